//! `study.lock`: everything that gave a result; JSON that a person can read and `rootvox rerun` can repeat.
//!
//! It holds the program's version; every parameter with its value, defaults written out; of a sweep the points, each
//! with what it changes; each distinct work (stage, version, parameters of the stage); and for every node its name, its
//! work, its key and the digest of its values, files first of all. No times, hosts or absolute paths: two runs of one
//! study on two machines write the same text. `photos.dir` and `corrections.file` are relative to the folder that the
//! lock lies in.

use super::batch::{Batch, Point, Study};
use super::document::Resolved;
use super::settings::{Settings, Source};
use crate::error::{Error, Result};
use crate::flow::{NodeId, Report};
use crate::store::{Digest, Key};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// Version of the lock's form.
const FORMAT: u32 = 1;

/// A lock file.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Lock {
    format: u32,
    /// Version of the program that made the result.
    pub rootvox: String,
    /// Name of the study.
    pub study: String,
    /// Every parameter (`section.key`) with its value as TOML; of a sweep, those of its first sound point.
    pub settings: Resolved,
    /// The swept parameters.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parameters: Vec<String>,
    /// The points of a sweep.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub points: Vec<LockedPoint>,
    /// Each distinct work.
    pub work: Vec<Work>,
    /// All nodes, inputs before consumers.
    pub nodes: Vec<LockedNode>,
}

/// A point of a sweep.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockedPoint {
    /// Its number.
    pub point: usize,
    /// Values of the swept parameters.
    pub values: Vec<String>,
    /// What differs from `settings`; null where the parameter is not given.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub settings: BTreeMap<String, Option<String>>,
    /// Whether its settings were at fault.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub failed: bool,
}

/// What a node does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Work {
    /// Name of the stage.
    pub stage: String,
    /// Version of the stage.
    pub version: u32,
    /// Its parameters.
    pub params: Value,
}

/// A node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockedNode {
    /// Its name, as `rootvox status --all` shows it.
    pub node: String,
    /// Its place in the list of works; none for a file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub work: Option<usize>,
    /// Its key; none for a file, and where it was not reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub key: Option<Key>,
    /// Digest of its values; none where it was not reached.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<Digest>,
}

impl Lock {
    /// The lock of a study that was run, to lie in `folder`.
    ///
    /// # Errors
    /// Where a parameter cannot be written.
    pub fn of(batch: &Batch, study: &Study, report: &Report, folder: &Path) -> Result<Self> {
        Self::of_nodes(batch, study, &study.targets(), report, folder)
    }

    /// The lock of what was made of a study's points, and of the nodes `targets`.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn of_nodes(batch: &Batch, study: &Study, targets: &[NodeId], report: &Report, folder: &Path) -> Result<Self> {
        let settings: Vec<Option<Resolved>> = study
            .points
            .iter()
            .map(|point| point.planned.as_ref().ok().map(|(s, _)| portable(s, folder)).transpose())
            .collect::<Result<_>>()?;
        let base = settings.iter().flatten().next().cloned().unwrap_or_default();
        let point = |(point, own): (&Point, Option<Resolved>)| LockedPoint {
            point: point.number,
            values: point.values.clone(),
            failed: own.is_none(),
            settings: own.map(|own| difference(&base, &own)).unwrap_or_default(),
        };
        let points = if study.is_sweep() { study.points.iter().zip(settings).map(point).collect() } else { Vec::new() };
        let reached = batch.graph.upstream(targets);
        let (mut work, mut nodes): (Vec<Work>, _) = (Vec::new(), Vec::new());
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        let names = batch.names_among(std::slice::from_ref(study));
        for (n, node) in batch.graph.nodes().zip(names).filter(|(n, _)| reached[n.index()]) {
            let at = match (batch.graph.stage(n), batch.graph.version(n)) {
                (Some(stage), Some(version)) => {
                    let params = batch.graph.params(n)?;
                    let place = *places.entry(format!("{stage} {version} {params}")).or_insert(work.len());
                    if place == work.len() {
                        work.push(Work { stage: stage.to_owned(), version, params });
                    }
                    Some(place)
                }
                _ => None,
            };
            nodes.push(LockedNode { node, work: at, key: report.key(n), digest: report.digest(n) });
        }
        Ok(Self {
            format: FORMAT,
            rootvox: env!("CARGO_PKG_VERSION").to_owned(),
            study: study.name.clone(),
            settings: base,
            parameters: study.parameters.clone(),
            points,
            work,
            nodes,
        })
    }

    /// Whether it is of a trial as a whole, whose captures have locks of their own.
    pub fn is_trial(&self) -> bool {
        self.parameters.first().is_some_and(|first| first == "plant")
    }

    /// The text of the file.
    ///
    /// # Errors
    /// Where it cannot be written as JSON.
    pub fn text(&self) -> Result<String> {
        serde_json::to_string_pretty(self).map(|t| t + "\n").map_err(|e| Error::failed(format!("study.lock: {e}")))
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// Where it cannot be read or is no lock of this version.
    pub fn read(path: &Path) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| {
            Error::usage(format!("cannot read the lock `{}`: {e}", path.display()))
                .help("every results folder holds a study.lock")
        })?;
        let lock: Self = serde_json::from_str(&text).map_err(|e| {
            Error::usage(format!("`{}` is no lock that this version can read: {e}", path.display()))
                .help("name the study.lock of a results folder")
        })?;
        if lock.format != FORMAT {
            return Err(Error::usage(format!("`{}` has format {}, not {FORMAT}", path.display(), lock.format))
                .help("use the version of rootvox that it names"));
        }
        Ok(lock)
    }

    /// The settings of every point as the text of a study file, or of the one study; `None` where they were at fault.
    pub fn texts(&self) -> Vec<Option<String>> {
        let lines = |settings: &Resolved| settings.iter().map(|(name, value)| format!("{name} = {value}\n")).collect();
        if self.points.is_empty() {
            return vec![Some(lines(&self.settings))];
        }
        let of_point = |point: &LockedPoint| {
            let mut own = self.settings.clone();
            for (name, value) in &point.settings {
                match value {
                    Some(value) => drop(own.insert(name.clone(), value.clone())),
                    None => drop(own.remove(name)),
                }
            }
            (!point.failed).then(|| lines(&own))
        };
        self.points.iter().map(of_point).collect()
    }
}

/// The settings with `photos.dir` and `corrections.file` as seen from `folder`.
fn portable(settings: &Settings, folder: &Path) -> Result<Resolved> {
    let mut resolved = settings.resolved.clone();
    if let Some(file) = &settings.corrections_file {
        let file = relative(file, folder)?.display().to_string();
        resolved.insert("corrections.file".into(), toml::Value::from(file).to_string());
    }
    match settings.source {
        Source::Files(_) => {
            let dir = relative(&settings.input_dir, folder)?.display().to_string();
            resolved.insert("photos.dir".into(), toml::Value::from(dir).to_string());
        }
        Source::Simulated(_) => resolved.retain(|name, _| !name.starts_with("photos.")),
    }
    Ok(resolved)
}

/// The path `to` as seen from the folder `from`.
fn relative(to: &Path, from: &Path) -> Result<PathBuf> {
    let whole = |path: &Path| {
        let absolute = std::path::absolute(path).map_err(|e| Error::io("find", path, e))?;
        let mut parts: Vec<PathBuf> = Vec::new();
        for part in absolute.components() {
            match part {
                Component::ParentDir if parts.len() > 1 => drop(parts.pop()),
                part => parts.push(PathBuf::from(part.as_os_str())),
            }
        }
        Ok::<_, Error>(parts)
    };
    let (to, from) = (whole(to)?, whole(from)?);
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let up = from[common..].iter().map(|_| PathBuf::from(".."));
    let path: PathBuf = up.chain(to[common..].iter().cloned()).collect();
    Ok(if path.as_os_str().is_empty() { PathBuf::from(".") } else { path })
}

fn difference(base: &Resolved, own: &Resolved) -> BTreeMap<String, Option<String>> {
    let changed = own.iter().filter(|(name, value)| base.get(*name) != Some(value));
    let gone = base.keys().filter(|name| !own.contains_key(*name));
    let changed = changed.map(|(name, value)| (name.clone(), Some(value.clone())));
    changed.chain(gone.map(|name| (name.clone(), None))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_the_lock() {
        let seen = |to: &str, from: &str| relative(Path::new(to), Path::new(from)).unwrap().display().to_string();
        assert_eq!(seen("/a/plant", "/a/results/x"), "../../plant");
        assert_eq!(seen("/a/b/../plant/.", "/a/plant"), ".");
        assert_eq!(seen(".", "./results/x"), "../..");
    }

    #[test]
    fn a_point_is_its_difference_from_the_first() {
        let map = |entries: &[(&str, &str)]| -> Resolved {
            entries.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect()
        };
        let (base, own) = (map(&[("a.x", "1"), ("a.y", "2")]), map(&[("a.x", "1"), ("a.z", "3")]));
        let settings = difference(&base, &own);
        assert_eq!(settings.len(), 2);
        let point = LockedPoint { point: 1, values: Vec::new(), settings, failed: false };
        let lock = Lock {
            format: FORMAT,
            rootvox: String::new(),
            study: String::new(),
            settings: base,
            parameters: Vec::new(),
            points: vec![point],
            work: Vec::new(),
            nodes: Vec::new(),
        };
        assert_eq!(lock.texts(), [Some("a.x = 1\na.z = 3\n".to_owned())]);
    }
}
