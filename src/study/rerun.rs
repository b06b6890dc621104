//! A study made again from its `study.lock`, and held against it.

use super::batch::{Batch, Point, Study};
use super::document::{Document, Sources};
use super::graph;
use super::lock::{Lock, LockedNode};
use super::origin::Origin;
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Change, Graph, NodeId, Report, Stage};
use crate::stages::traits::Traits;
use std::path::Path;

/// Makes the graph of a locked study.
///
/// Input paths start from the folder of the lock, or from `photos_dir`, which starts from where the user stands.
///
/// # Errors
/// Where the lock's settings cannot be read by this version, or the photographs are not there.
pub fn batch(lock: &Lock, path: &Path, photos_dir: Option<&str>) -> Result<Batch> {
    if lock.is_trial() {
        return Err(Error::usage(format!("`{}` is the lock of a whole trial", path.display()))
            .help("each capture has a lock of its own, beside the trial's folder: <plant>-<date>/study.lock"));
    }
    let overrides: Vec<String> = photos_dir.map(|dir| format!("photos.dir={dir}")).into_iter().collect();
    let origin = Origin::of(path, &overrides);
    let mut graph = Graph::new();
    let mut plan = |text: Option<String>| -> Result<_> {
        let text = text.ok_or_else(|| Error::usage("its settings were at fault"))?;
        let sources = Sources::new(&path.display().to_string(), &text, &overrides)?;
        let settings = Settings::read(Document::parse(&sources)?, &origin).map_err(here)?;
        let nodes = graph::add(&mut graph, &settings)?;
        Ok((settings, nodes))
    };
    let mut points = Vec::new();
    for (n, text) in lock.texts().into_iter().enumerate() {
        let was_sound = text.is_some();
        let planned = plan(text);
        if let (Err(error), true) = (&planned, was_sound) {
            return Err(error.clone());
        }
        let locked = lock.points.get(n);
        let number = locked.map_or(n + 1, |point| point.point);
        points.push(Point { number, values: locked.map(|point| point.values.clone()).unwrap_or_default(), planned });
    }
    let traits = lock.work.iter().any(|work| work.stage == Traits::NAME);
    let (name, parameters, fastest) = (lock.study.clone(), lock.parameters.clone(), points.len());
    let study = Study { name, parameters, fastest, traits, points };
    Ok(Batch { graph, studies: vec![study], trial: None })
}

/// The settings are the lock's: only the folder can be another.
fn here(mut error: Error) -> Error {
    if error.message.starts_with("photos.") {
        error.help = Some("name the folder of the capture: --photos-dir DIR".into());
    }
    error
}

/// How a rerun compares with its lock.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Nodes of the lock.
    pub nodes: usize,
    /// Nodes with equal digests.
    pub identical: usize,
    /// The first node to differ, inputs before consumers, and why.
    pub first: Option<(String, String)>,
}

/// Holds a run of [`batch`] against its lock.
///
/// # Errors
/// Where the parameters of a stage cannot be written.
pub fn compare(lock: &Lock, batch: &Batch, report: &Report, failures: &[(NodeId, Error)]) -> Result<Comparison> {
    let names = batch.names();
    let (mut identical, mut first) = (0, None);
    for locked in &lock.nodes {
        let now = names.iter().position(|name| *name == locked.node).and_then(|n| batch.graph.nodes().nth(n));
        if locked.digest.is_none() || now.is_some_and(|n| report.digest(n) == locked.digest) {
            identical += 1;
        } else if first.is_none() {
            first = Some((locked.node.clone(), reason(lock, locked, batch, now, failures)?));
        }
    }
    Ok(Comparison { nodes: lock.nodes.len(), identical, first })
}

/// Why a node differs whose inputs are all equal.
fn reason(
    lock: &Lock,
    locked: &LockedNode,
    batch: &Batch,
    now: Option<NodeId>,
    failures: &[(NodeId, Error)],
) -> Result<String> {
    let Some(node) = now else { return Ok("this version has no such node".into()) };
    if let Some((_, error)) = failures.iter().find(|(failed, _)| *failed == node) {
        return Ok(error.message.clone());
    }
    let work = locked.work.and_then(|at| lock.work.get(at));
    let (Some(work), Some(version)) = (work, batch.graph.version(node)) else {
        return Ok("input: the file has another content".into());
    };
    if work.version != version {
        return Ok(format!("version: the stage `{}` was {} and is {version}", work.stage, work.version));
    }
    let changes = Change::of_parameters(&work.params, &batch.graph.params(node)?);
    if !changes.is_empty() {
        let words: Vec<String> = changes.iter().map(ToString::to_string).collect();
        return Ok(format!("setting: {}", words.join("; ")));
    }
    let (then, today) = (&lock.rootvox, env!("CARGO_PKG_VERSION"));
    Ok(format!("the same work on the same inputs gave other values (rootvox {then} then, {today} now)"))
}
