//! The report of a study: what its page shows, gathered from the store.

use super::batch::Point;
use super::lock::Lock;
use super::nodes::StudyNodes;
use super::settings::{Settings, Source};
use crate::calibration::Registration;
use crate::error::{Error, Result};
use crate::evaluation::{Band, CameraErrors, Score, Sight};
use crate::flow::{Graph, NodeId, Report};
use crate::formats::tables::{self, Table};
use crate::formats::{NamedView, camera_file};
use crate::optics::View;
use crate::report::page::{CameraOrigin, Corrected, Evidence, Page, Photograph, Provenance, Warning, directions};
use crate::roots::RootSystem;
use crate::roots::correction::Outcome;
use crate::stages::evaluate_roots::Judgement;
use std::collections::BTreeMap;

/// Warnings of one stage that the page shows.
const MOST_WARNINGS: usize = 3;

/// The commands that the page names.
pub struct Commands<'a> {
    /// The one that made it.
    pub made_by: &'a str,
    /// The one that makes it again.
    pub again: &'a str,
}

/// The page of a point that was run.
///
/// # Errors
/// Where something of it is missing in the store.
pub fn html(point: &Point, graph: &Graph, report: &Report, lock: &Lock, commands: &Commands<'_>) -> Result<String> {
    let photographs = photographs(point, report)?;
    with(point, graph, report, lock, commands, &photographs, |page| page.html())
}

/// What `make` makes of the page of a point that was run, with these photographs.
///
/// # Errors
/// Where something of it is missing in the store, and those of `make`.
pub fn with<T>(
    point: &Point,
    graph: &Graph,
    report: &Report,
    lock: &Lock,
    commands: &Commands<'_>,
    photographs: &[Photograph],
    make: impl FnOnce(&Page<'_>) -> Result<T>,
) -> Result<T> {
    let (settings, nodes) = point.planned.as_ref().map_err(Clone::clone)?;
    let traits = report.artefact(nodes.traits)?;
    let table = |name: &str| -> Result<Table> { tables::read(name, &traits.bytes(name)?) };
    let spread = |node: NodeId| -> Result<Table> {
        let name = "trait_spread.csv";
        tables::read(name, &report.artefact(node)?.bytes(name)?)
    };
    let shown = nodes.shown()?;
    let system: RootSystem = report.artefact(nodes.system)?.json("system.json")?;
    let named: Vec<NamedView> = report.artefact(nodes.cameras)?.json("cameras")?;
    let views = in_order(&nodes.photos, &named)?;
    let registration: Option<Registration> =
        nodes.calibration.as_ref().map(|c| report.artefact(c.pose)?.json("registration")).transpose()?;
    let camera_errors: Option<CameraErrors> =
        nodes.camera_errors.map(|n| report.artefact(n)?.json("errors")).transpose()?;
    let score: Option<Score> = nodes.score.map(|n| report.artefact(n)?.json("score")).transpose()?;
    let bands: Option<Vec<Band>> = nodes.score.map(|n| report.artefact(n)?.json("bands")).transpose()?;
    let judgement: Option<Judgement> = nodes.roots_score.map(|n| report.artefact(n)?.json("judgement")).transpose()?;
    let corrected = match &nodes.corrections {
        Some(c) => {
            let outcomes: Vec<Outcome> = report.artefact(c.corrections)?.json("outcomes.json")?;
            Some((outcomes, tables::read_traits(&report.artefact(c.traits)?.bytes("traits.csv")?)?))
        }
        None => None,
    };
    let sight: Vec<Sight> = report.artefact(shown.sight)?.json("sight")?;
    let warnings = warnings(graph, nodes, report);
    let stages = stages(lock);
    let inputs: Vec<(String, String)> = lock
        .nodes
        .iter()
        .filter(|node| node.work.is_none())
        .filter_map(|node| Some((node.node.clone(), node.digest?.to_string())))
        .collect();
    make(&Page {
        name: &lock.study,
        tank: &settings.tank,
        system: &system,
        traits: &tables::read_traits(&traits.bytes("traits.csv")?)?,
        // A page that follows changes does not wait for resampled views.
        spread: shown.spread.filter(|&node| report.artefact(node).is_ok()).map(spread).transpose()?.as_ref(),
        per_root: &table("per_root.csv")?,
        profile: &table("depth_profile.csv")?,
        evidence: Evidence {
            warnings: &warnings,
            cameras: origin(settings, registration.as_ref()),
            camera_errors: camera_errors.as_ref(),
            views: &views,
            sight: &sight,
            bands: bands.as_deref().unwrap_or_default(),
            score: score.as_ref(),
            roots_score: judgement.as_ref().map(|j| &j.score),
        },
        photographs,
        corrections: corrected.as_ref().map(|(outcomes, traced)| Corrected { outcomes, traced }),
        provenance: Provenance {
            made_by: commands.made_by,
            again: commands.again,
            grid: &settings.grid,
            settings: &lock.settings,
            stages: &stages,
            inputs: &inputs,
        },
    })
}

fn origin<'a>(settings: &Settings, registration: Option<&'a Registration>) -> CameraOrigin<'a> {
    match (registration, &settings.source) {
        (Some(registration), _) => CameraOrigin::Found(&registration.quality),
        (None, Source::Simulated(_)) => CameraOrigin::Simulated,
        (None, Source::Files(_)) => CameraOrigin::File,
    }
}

/// The camera of each photograph.
fn in_order(photos: &[String], named: &[NamedView]) -> Result<Vec<View>> {
    let of = |photo: &String| {
        let view = named.iter().find(|v| camera_file::means(&v.file, photo)).map(|v| v.view.clone());
        view.ok_or_else(|| Error::failed(format!("the photograph `{photo}` has no camera")))
    };
    photos.iter().map(of).collect()
}

/// The photographs of a point that was run, with the roots on them.
///
/// # Errors
/// Where something of them is missing in the store.
pub fn photographs(point: &Point, report: &Report) -> Result<Vec<Photograph>> {
    let (_, nodes) = point.planned.as_ref().map_err(Clone::clone)?;
    let named: Vec<NamedView> = report.artefact(nodes.cameras)?.json("cameras")?;
    let views = &in_order(&nodes.photos, &named)?;
    let directions = directions(views);
    let shown = nodes.shown()?;
    let made = shown.previews.iter().zip(&shown.root_lines);
    nodes
        .photos
        .iter()
        .zip(views)
        .zip(directions)
        .zip(made)
        .map(|(((name, view), from_deg), (&preview, &lines))| {
            Ok(Photograph {
                name: name.clone(),
                size_px: [view.lens.ideal().width, view.lens.ideal().height],
                from_deg,
                jpeg: report.artefact(preview)?.bytes("preview.jpg")?,
                lines: report.artefact(lines)?.json("lines")?,
            })
        })
        .collect()
}

/// What stages warned of. What every photograph warns of alike is said for the first ones, and counted.
fn warnings(graph: &Graph, nodes: &StudyNodes, report: &Report) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let mut warned: BTreeMap<&str, usize> = BTreeMap::new();
    let reached = graph.upstream(&nodes.targets());
    for node in graph.nodes().filter(|node| reached[node.index()]) {
        let Some(manifest) = report.manifest(node) else { continue };
        let stage = graph.stage(node).unwrap_or_default();
        let count = warned.entry(stage).or_default();
        let shown = manifest.warnings.len().min(MOST_WARNINGS.saturating_sub(*count));
        warnings.extend(manifest.warnings[..shown].iter().map(|text| Warning {
            stage: stage.to_owned(),
            place: graph.label(node).to_owned(),
            text: text.clone(),
        }));
        *count += manifest.warnings.len();
    }
    for (stage, count) in warned.into_iter().filter(|&(_, count)| count > MOST_WARNINGS) {
        let text = format!("{} more warnings of this kind", count - MOST_WARNINGS);
        warnings.push(Warning { stage: stage.to_owned(), place: stage.to_owned(), text });
    }
    warnings
}

/// Each stage with its version, in the order of the data.
fn stages(lock: &Lock) -> Vec<(String, u32)> {
    let mut stages: Vec<(String, u32)> = Vec::new();
    for work in &lock.work {
        if !stages.iter().any(|(stage, _)| *stage == work.stage) {
            stages.push((work.stage.clone(), work.version));
        }
    }
    stages
}
