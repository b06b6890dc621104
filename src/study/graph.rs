//! A study's settings as a graph of nodes: what is computed from what.

use super::nodes::StudyNodes;
use super::settings::{Settings, Source};
use super::shown::shown;
use super::upstream::Upstream;
use crate::error::{Error, Result};
use crate::evaluation::ScoreParams;
use crate::flow::{Graph, NodeId};
use crate::stages::diameters::Diameters;
use crate::stages::evaluate::Evaluate;
use crate::stages::evaluate_cameras::EvaluateCameras;
use crate::stages::evaluate_roots::EvaluateRoots;
use crate::stages::extract::Extract;
use crate::stages::hierarchy::Hierarchy;
use crate::stages::merge::Merge;
use crate::stages::rootness::Rootness;
use crate::stages::slices::Slices;
use crate::stages::suppress::Suppress;
use crate::stages::trace::Trace;
use crate::stages::traits::Traits;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Adds the study to the graph, with all that is shown of it.
///
/// # Errors
/// Where two photographs have one name but for its ending.
pub fn add(graph: &mut Graph, s: &Settings) -> Result<StudyNodes> {
    let from = Upstream::add(graph, s)?;
    let mut nodes = measured(graph, s, &from)?;
    nodes.shown = Some(shown(graph, s, &from, &nodes)?);
    Ok(nodes)
}

/// The points of sweeps: what many have in common is added once, and nothing is added that only shows.
#[derive(Default)]
pub(super) struct Points(BTreeMap<String, Upstream>);

impl Points {
    /// Adds one point.
    ///
    /// # Errors
    /// As [`add`].
    pub(super) fn add(&mut self, graph: &mut Graph, s: &Settings) -> Result<StudyNodes> {
        let from = match self.0.entry(s.resolved_but(MEASURING)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(free) => free.insert(Upstream::add(graph, s)?),
        };
        spread_halves(s, from.views.len())?;
        measured(graph, s, from)
    }
}

/// Sections that decide nothing about the views' volumes and what they are made of.
const MEASURING: &[&str] =
    &["study", "merge", "rootness", "suppress", "extract", "trace", "diameters", "hierarchy", "traits", "overlay"];

/// Adds what is measured: from the views' volumes to the numbers.
///
/// # Errors
/// Where the slice to show lies outside the grid.
fn measured(graph: &mut Graph, s: &Settings, from: &Upstream) -> Result<StudyNodes> {
    let Reconstruction { merged, rootness, extract, system, traits } = reconstruct(graph, s, &from.all(), "");
    let slices = s.report.slice.map(|depth_mm| Slices::at(depth_mm, &s.grid)).transpose()?;
    let slices = slices.map(|stage| graph.add("slices", stage, &[("merged", &[merged]), ("rootness", &[rootness])]));
    let params = ScoreParams {
        z_min_mm: s.truth.z_min,
        z_max_mm: s.truth.z_max.unwrap_or(s.grid.spacing_mm * s.grid.shape[0] as f64 - 2.0),
        free_azimuth: from.calibration.is_some(),
        ..ScoreParams::default()
    };
    let score = from.truth.map(|truth| {
        let stage = Evaluate { tank: s.true_tank.clone(), params: params.clone() };
        graph.add("evaluate", stage, &[("roots", &[extract]), ("truth", &[truth])])
    });
    let roots_score = from.truth.map(|truth| {
        let stage = EvaluateRoots { tank: s.true_tank.clone(), params };
        graph.add("evaluate-roots", stage, &[("system", &[system]), ("truth", &[truth])])
    });
    // Two cameras fix no frame.
    let simulated = matches!(s.source, Source::Simulated(_)) && from.names.len() > 2;
    let camera_errors = from.truth.filter(|_| simulated).map(|truth| {
        let stage = EvaluateCameras { true_tank: s.true_tank.clone(), tank: s.tank.clone() };
        graph.add("evaluate-cameras", stage, &[("cameras", &[from.cameras]), ("truth", &[truth])])
    });
    Ok(StudyNodes {
        photos: from.names.clone(),
        photo_nodes: from.files.clone(),
        survey: from.survey,
        cameras: from.cameras,
        calibration: from.calibration.clone(),
        merged,
        rootness,
        extract,
        system,
        traits,
        slices,
        score,
        roots_score,
        camera_errors,
        shown: None,
    })
}

/// What a set of views gives.
pub(super) struct Reconstruction {
    pub merged: NodeId,
    pub rootness: NodeId,
    pub extract: NodeId,
    pub system: NodeId,
    pub traits: NodeId,
}

/// Photographs to reconstruct from; the lists run alike.
pub(super) struct Photographs<'a> {
    pub files: &'a [NodeId],
    pub cameras: &'a [NodeId],
    pub views: &'a [NodeId],
    /// What is behind the roots, where it is learned.
    pub background: &'a [NodeId],
}

/// From rendered views to traits; `draw` is added to the names of the nodes.
pub(super) fn reconstruct(graph: &mut Graph, s: &Settings, from: &Photographs<'_>, draw: &str) -> Reconstruction {
    let name = |stage: &str| format!("{stage}{draw}");
    let merged = graph.add(
        &name("merge"),
        Merge { evidence: s.contrast.enabled, params: s.merge.clone() },
        &[("views", from.views)],
    );
    let rootness = Rootness { spacing_mm: s.grid.spacing_mm, params: s.rootness.clone() };
    // A given scale asks nothing of the photographs.
    let widths = if s.rootness.sigma.is_empty() { from.background } else { &[] };
    let rootness = graph.add(&name("rootness"), rootness, &[("merged", &[merged][..]), ("background", widths)]);
    let ridges = graph.add(&name("suppress"), Suppress { params: s.suppress }, &[("rootness", &[rootness])]);
    let extract = Extract { grid: s.grid, params: s.extract };
    let extract = graph.add(&name("extract"), extract, &[("ridges", &[ridges])]);
    let trace = Trace { grid: s.grid, params: s.trace.clone() };
    let ports = [("ridges", &[ridges][..]), ("rootness", &[rootness])];
    let traced = graph.add(&name("trace"), trace, &ports);
    let measured = if s.diameters.enabled {
        let diameters = Diameters { tank: s.tank.clone(), params: s.diameters.clone() };
        let ports = [
            ("pieces", &[traced][..]),
            ("photos", from.files),
            ("cameras", from.cameras),
            ("background", from.background),
        ];
        graph.add(&name("diameters"), diameters, &ports)
    } else {
        traced
    };
    let hierarchy = Hierarchy { params: s.hierarchy.clone() };
    let system = graph.add(&name("hierarchy"), hierarchy, &[("pieces", &[measured])]);
    let traits = Traits { water_level_mm: s.tank.water_level_mm, study: s.name.clone(), params: s.traits.clone() };
    let traits = graph.add(&name("traits"), traits, &[("system", &[system])]);
    Reconstruction { merged, rootness, extract, system, traits }
}

/// How many random halves of that many views the study asks for.
///
/// # Errors
/// Where they are too few or too small.
pub(super) fn spread_halves(s: &Settings, views: usize) -> Result<usize> {
    let count = s.traits.resample;
    if count > 0 && (!(2..=1000).contains(&count) || views < 6) {
        return Err(Error::usage(format!("traits.resample is {count} for {views} photographs"))
            .help("give 2 to 1000 halves of at least 6 photographs, or 0"));
    }
    Ok(count)
}
