//! A study's settings as a graph of nodes: what is computed from what.

use super::nodes::{CorrectionNodes, StudyNodes};
use super::origin::MEASURING;
use super::reconstruct::{Reconstruction, reconstruct, traits_of};
use super::settings::{Settings, Source};
use super::shown::shown;
use super::spread::spread_halves;
use super::upstream::Upstream;
use crate::error::Result;
use crate::evaluation::ScoreParams;
use crate::flow::{Graph, NodeId};
use crate::stages::corrections::Corrections;
use crate::stages::evaluate::Evaluate;
use crate::stages::evaluate_cameras::EvaluateCameras;
use crate::stages::evaluate_roots::EvaluateRoots;
use crate::stages::slices::Slices;
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

/// Adds what is measured: from the views' volumes to the numbers.
///
/// # Errors
/// Where the slice to show lies outside the grid.
fn measured(graph: &mut Graph, s: &Settings, from: &Upstream) -> Result<StudyNodes> {
    let Reconstruction { merged, rootness, extract, system: traced, traits: as_traced } =
        reconstruct(graph, s, &from.all(), "");
    let corrected = corrected(graph, s, from, traced, rootness);
    let system = corrected.unwrap_or(traced);
    let traits = corrected.map_or(as_traced, |system| traits_of(graph, s, system, "traits/corrected"));
    let corrections = corrected.map(|node| CorrectionNodes { corrections: node, traced, traits: as_traced });
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
        seen: from.seen.iter().map(|(_, undistorted, camera)| (*undistorted, *camera)).collect(),
        evidence: from.evidence.as_slice().into(),
        survey: from.survey,
        cameras: from.cameras,
        calibration: from.calibration.clone(),
        merged,
        rootness,
        extract,
        system,
        traits,
        corrections,
        slices,
        score,
        roots_score,
        camera_errors,
        shown: None,
    })
}

/// The traced roots as a person corrected them, where there are corrections.
fn corrected(graph: &mut Graph, s: &Settings, from: &Upstream, traced: NodeId, rootness: NodeId) -> Option<NodeId> {
    let file = graph.file("corrections-file", s.corrections_file.as_ref()?);
    let photos = from.names.to_vec();
    let stage = Corrections { tank: s.tank.clone(), grid: s.grid, photos, params: s.corrections.params() };
    let ports = [("system", &[traced][..]), ("file", &[file]), ("cameras", &from.seen_by), ("rootness", &[rootness])];
    Some(graph.add("corrections", stage, &ports))
}
