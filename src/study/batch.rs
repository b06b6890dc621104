//! What one study file asks for: one study, the points of its sweep, or several studies that share a base; all in one
//! graph, so that what they have in common is computed once.
//!
//! ```toml
//! [studies.every-ray]                  # the file's study with these values laid over it, under this name
//! render.exclude_irregular = false
//! ```
//!
//! With `[studies]`, the file's own study is a base only and is not run itself. So it is with `[plants]` ([`super::plants`]): each
//! capture of a trial is a study.

use super::document::{Document, Sources};
use super::graph;
use super::nodes::StudyNodes;
use super::origin::Origin;
use super::plants::{Only, Plants};
use super::settings::Settings;
use super::sweep::{Override, Section, ranges};
use super::trial::Trial;
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::DeValue;

/// One setting of a study.
pub struct Point {
    /// From 1, in the order of the sweep.
    pub number: usize,
    /// Values of the study's swept parameters.
    pub values: Vec<String>,
    /// The settings and their nodes, or why there are none.
    pub planned: Result<(Settings, StudyNodes)>,
}

impl Point {
    fn title(&self, parameters: &[String]) -> String {
        let values: Vec<String> =
            parameters.iter().zip(&self.values).map(|(name, value)| format!("{name} = {value}")).collect();
        format!("point {} ({})", self.number, values.join(", "))
    }
}

/// A study: its one point, or the points of its sweep.
pub struct Study {
    /// Name of the results folder.
    pub name: String,
    /// The swept parameters; none where the study is no sweep.
    pub parameters: Vec<String>,
    /// How many values the fastest axis of the sweep has.
    pub fastest: usize,
    /// Whether the points of the sweep have traits; other studies always have.
    pub traits: bool,
    /// All points.
    pub points: Vec<Point>,
}

impl Study {
    /// Whether the study has a `[sweep]`.
    pub fn is_sweep(&self) -> bool {
        !self.parameters.is_empty()
    }

    /// All nodes that bring the study up to date.
    pub fn targets(&self) -> Vec<NodeId> {
        self.points.iter().flat_map(|point| self.targets_of(point)).collect()
    }

    /// The nodes that one of its points needs: of a sweep's points the numbers, not the pictures.
    pub fn targets_of(&self, point: &Point) -> Vec<NodeId> {
        match &point.planned {
            Ok((_, nodes)) if self.is_sweep() => {
                nodes.numbers().into_iter().chain(nodes.measures().filter(|_| self.traits)).collect()
            }
            Ok((_, nodes)) => nodes.targets(),
            Err(_) => Vec::new(),
        }
    }

    /// A point for people: `point 3 (extract.high = 0.02)`.
    pub fn title(&self, point: &Point) -> String {
        point.title(&self.parameters)
    }

    /// The faults of points whose settings are unsound, each naming its point.
    pub fn faults(&self) -> Vec<Error> {
        let faults = self.points.iter().filter_map(|p| Some(p.planned.as_ref().err()?.clone().at(self.title(p))));
        faults.collect()
    }
}

/// Everything that a study file asks for.
pub struct Batch {
    /// The nodes of all studies.
    pub graph: Graph,
    /// The studies.
    pub studies: Vec<Study>,
    /// What the studies are together, where they are the captures of a trial.
    pub trial: Option<Trial>,
}

impl Batch {
    /// Reads the study file at `path` with `--set` overrides laid over it. A point of a sweep whose settings are at
    /// fault is kept with its fault, as long as another point is sound.
    ///
    /// # Errors
    /// Every fault of the file at once, with line, column and remedy.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self> {
        Self::load_only(path, overrides, &[])
    }

    /// As [`Self::load`]; of a trial, only the captures that `only` names.
    ///
    /// # Errors
    /// As [`Self::load`]; of a trial's list too all faults at once.
    pub fn load_only(path: &Path, overrides: &[String], only: &[Only]) -> Result<Self> {
        let mut batch = Self { graph: Graph::new(), studies: Vec::new(), trial: None };
        batch.add_file(path, overrides, only)?;
        batch.named_apart()
    }

    /// As [`Self::load`], of several study files in one graph.
    ///
    /// # Errors
    /// As [`Self::load`], where two studies have one name, and where a trial is one of several files.
    pub fn load_all(paths: &[impl AsRef<Path>], overrides: &[String]) -> Result<Self> {
        let mut batch = Self { graph: Graph::new(), studies: Vec::new(), trial: None };
        for path in paths.iter().map(AsRef::as_ref) {
            batch.add_file(path, overrides, &[])?;
            if batch.trial.is_some() && paths.len() > 1 {
                return Err(Error::usage(format!(
                    "`{}` is a trial: it cannot be one of several files",
                    path.display()
                ))
                .help("name it alone; workers of several commands share one store"));
            }
        }
        batch.named_apart()
    }

    /// Adds what a study file asks for.
    fn add_file(&mut self, path: &Path, overrides: &[String], only: &[Only]) -> Result<()> {
        let sources = Sources::open(path, overrides)?;
        let mut base = Document::parse(&sources)?;
        let start = path.parent().unwrap_or(Path::new("."));
        if let Some(mut plants) = Plants::take(&mut base, start, overrides)? {
            plants.keep(only)?;
            let origin = Origin::of_list(path, overrides, &plants.list.base);
            self.trial = Some(Trial::add(self, &mut base, &plants, &origin, only)?);
            return Ok(());
        }
        if !only.is_empty() {
            return Err(Error::usage(format!("--only: `{}` is no trial", path.display()))
                .help("a trial has a [plants] section that lists its captures"));
        }
        let origin = Origin::of(path, overrides);
        let derived = derived(&mut base)?;
        if derived.is_empty() {
            return self.add(base, &origin);
        }
        derived.into_iter().try_for_each(|document| self.add(document, &origin))
    }

    /// The batch, where its studies have names of their own.
    fn named_apart(self) -> Result<Self> {
        let mut names = BTreeSet::new();
        match self.studies.iter().find(|study| !names.insert(&study.name)) {
            None => Ok(self),
            Some(twice) => Err(Error::usage(format!("two studies are named `{}`", twice.name))
                .help("the results of each study go into a folder of its name")),
        }
    }

    /// Adds a study that is no sweep.
    pub(super) fn add_plain(&mut self, settings: Settings) -> Result<()> {
        let nodes = graph::add(&mut self.graph, &settings)?;
        let name = settings.name.clone();
        let point = Point { number: 1, values: Vec::new(), planned: Ok((settings, nodes)) };
        self.studies.push(Study { name, parameters: Vec::new(), fastest: 1, traits: true, points: vec![point] });
        Ok(())
    }

    /// Adds the study in `document`, with all points of its sweep.
    pub(super) fn add(&mut self, mut document: Document<'_>, origin: &Origin) -> Result<()> {
        let section = Section::take(&mut document)?;
        let Some(section) = section else {
            return self.add_plain(Settings::read(document, origin)?);
        };
        let laid: Vec<Vec<Override<'_>>> = section.points()?;
        let values: Vec<Vec<String>> = laid.iter().map(|l| l.iter().map(|o| o.text.clone()).collect()).collect();
        let read = |laid: Vec<Override<'_>>| {
            let mut document = document.clone();
            for o in laid {
                document.set(o.parameter, o.value);
            }
            Settings::read(document, origin)
        };
        let read: Vec<Result<Settings>> = laid.into_par_iter().map(read).collect();
        let (mut points, mut shared) = (Vec::with_capacity(read.len()), graph::Points::default());
        for (n, (settings, values)) in read.into_iter().zip(values).enumerate() {
            let planned = settings.and_then(|settings| {
                let nodes = shared.add(&mut self.graph, &settings)?;
                Ok((settings, nodes))
            });
            points.push(Point { number: n + 1, values, planned });
        }
        let Some(name) = points.iter().find_map(|p| p.planned.as_ref().ok().map(|(s, _)| s.name.clone())) else {
            return Error::many(faults_of_all(&section.parameters(), points));
        };
        let (parameters, fastest) = (section.parameters(), section.fastest());
        self.studies.push(Study { name, parameters, fastest, traits: section.traits, points });
        Ok(())
    }

    /// Folder that the studies' results folders lie in: `results_dir`, or that of the trial in it.
    pub fn results_in(&self, results_dir: &Path) -> PathBuf {
        self.trial.as_ref().map_or_else(|| results_dir.to_owned(), |trial| results_dir.join(&trial.name))
    }

    /// All nodes that bring all studies up to date.
    pub fn targets(&self) -> Vec<NodeId> {
        let of_trial = self.trial.iter().flat_map(Trial::targets);
        self.studies.iter().flat_map(Study::targets).chain(of_trial).collect()
    }

    /// What a person should know of how the settings were understood, each once.
    pub fn notes(&self) -> BTreeSet<&str> {
        let settings = self.studies.iter().flat_map(|study| &study.points).filter_map(|p| p.planned.as_ref().ok());
        let notes = settings.flat_map(|(settings, _)| &settings.notes);
        notes.chain(self.trial.iter().flat_map(|trial| &trial.notes)).map(String::as_str).collect()
    }

    /// A name for each node, unlike that of any other: its label and, where not all points share it, whose it is:
    /// `extract [2]`, `rootness [1-4]`, `render/003.jpg [every-ray]`.
    pub fn names(&self) -> Vec<String> {
        self.names_among(&self.studies)
    }

    /// The names that the nodes have where these studies are alone.
    pub(super) fn names_among(&self, studies: &[Study]) -> Vec<String> {
        let mut owners: Vec<Vec<(usize, usize)>> = self.graph.nodes().map(|_| Vec::new()).collect();
        let (mut points, mut walk) = (0, self.graph.walk());
        for (s, study) in studies.iter().enumerate() {
            for point in study.points.iter().filter(|p| p.planned.is_ok()) {
                points += 1;
                for node in walk.upstream(&study.targets_of(point)) {
                    owners[node.index()].push((s, point.number));
                }
            }
        }
        let name = |(node, owners): (NodeId, Vec<(usize, usize)>)| {
            let label = self.graph.label(node);
            if owners.is_empty() || owners.len() == points {
                return label.to_owned();
            }
            let of_study = |(s, study): (usize, &Study)| {
                let numbers: Vec<usize> = owners.iter().filter(|(of, _)| *of == s).map(|(_, n)| *n).collect();
                match (numbers.is_empty(), studies.len() > 1, study.is_sweep()) {
                    (true, ..) => None,
                    (false, true, false) => Some(study.name.clone()),
                    (false, true, true) => Some(format!("{} {}", study.name, ranges(&numbers))),
                    (false, false, _) => Some(ranges(&numbers)),
                }
            };
            let whose: Vec<String> = studies.iter().enumerate().filter_map(of_study).collect();
            format!("{label} [{}]", whose.join("; "))
        };
        self.graph.nodes().zip(owners).map(name).collect()
    }

    /// The node with that name ([`Batch::names`]), or else the first with that label.
    ///
    /// # Errors
    /// Where there is none.
    pub fn find(&self, name: &str) -> Result<NodeId> {
        let named = self.names().iter().position(|n| n == name).and_then(|n| self.graph.nodes().nth(n));
        named.map_or_else(|| self.graph.find(name), Ok)
    }
}

/// The faults of a sweep none of whose points is sound: once what all have, else with the first point that has it.
fn faults_of_all(parameters: &[String], points: Vec<Point>) -> Vec<Error> {
    let (count, mut order) = (points.len(), Vec::new());
    let mut holders: BTreeMap<String, (usize, Error)> = BTreeMap::new();
    for point in points {
        let title = point.title(parameters);
        for fault in point.planned.err().into_iter().flat_map(Error::apart) {
            let (held, _) = holders.entry(fault.message.clone()).or_insert_with(|| {
                order.push(fault.message.clone());
                (0, fault.at(&title))
            });
            *held += 1;
        }
    }
    let named = |message: String| {
        let (held, mut fault) = holders.remove(&message)?;
        if held == count {
            fault.message = message;
        }
        Some(fault)
    };
    order.into_iter().filter_map(named).collect()
}

/// The studies of `[studies]`, each laid over the base; `base` is then without that section.
fn derived<'t>(base: &mut Document<'t>) -> Result<Vec<Document<'t>>> {
    let Some((_, section)) = base.take_table("studies") else { return Ok(Vec::new()) };
    let mut entries: Vec<_> = section.into_iter().collect();
    entries.sort_by_key(|(key, _)| key.span().start);
    let (mut documents, mut faults) = (Vec::new(), Vec::new());
    for (key, value) in entries {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => {
                let mut document = base.clone();
                document.lay(table);
                let name = DeValue::String(key.get_ref().clone());
                document.set("study.name", Spanned::new(key.span(), name));
                documents.push(document);
            }
            other => {
                let message = format!("[studies] expected a table of values, found {}", other.type_str());
                faults.push(base.fault(&message, Some(span)));
            }
        }
    }
    Error::many(faults)?;
    Ok(documents)
}
