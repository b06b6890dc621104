//! The nodes of a study that people look at and no number rests on.

use super::nodes::{Shown, StudyNodes};
use super::settings::Settings;
use super::spread::spread;
use super::upstream::Upstream;
use crate::error::Result;
use crate::flow::{Graph, NodeId};
use crate::report::page::preview_px;
use crate::stages::labels::Labels;
use crate::stages::overlay::Overlay;
use crate::stages::preview::Preview;
use crate::stages::root_lines::RootLines;
use crate::stages::root_overlay::RootOverlay;
use crate::stages::sight::Sight;
use crate::stages::volume::Volume;

/// Adds them to the graph.
///
/// # Errors
/// Where random halves of the views are too few or too small.
pub(super) fn shown(graph: &mut Graph, s: &Settings, from: &Upstream, nodes: &StudyNodes) -> Result<Shown> {
    let &StudyNodes { merged, rootness, extract, system, .. } = nodes;
    // Halves of the views are not corrected, so they vary about the traits as traced.
    let traced = nodes.corrections.as_ref().map_or(nodes.traits, |c| c.traits);
    let spread = spread(graph, s, &from.all(), traced)?;
    let of_views = |graph: &mut Graph, add: &dyn Fn(&mut Graph, &str, NodeId, NodeId) -> NodeId| {
        from.seen.iter().map(|(name, photo, camera)| add(graph, name, *photo, *camera)).collect::<Vec<_>>()
    };
    let root_overlays = of_views(graph, &|graph, name, photo, camera| {
        let stage = RootOverlay { tank: s.tank.clone(), line_radius_px: s.overlay.mark_radius };
        let ports = [("photo", &[photo][..]), ("camera", &[camera]), ("system", &[system])];
        graph.add(&format!("root-overlay/{name}"), stage, &ports)
    });
    let longest_px = preview_px(from.seen.len());
    let previews = of_views(graph, &|graph, name, photo, _| {
        graph.add(&format!("preview/{name}"), Preview { longest_px }, &[("photo", &[photo])])
    });
    let root_lines = of_views(graph, &|graph, name, _, camera| {
        let lines = RootLines { tank: s.tank.clone() };
        graph.add(&format!("root-lines/{name}"), lines, &[("camera", &[camera][..]), ("system", &[system])])
    });
    let overlays = of_views(graph, &|graph, name, photo, camera| {
        let stage = Overlay { tank: s.tank.clone(), mark_radius_px: s.overlay.mark_radius };
        let ports = [("photo", &[photo][..]), ("camera", &[camera]), ("roots", &[extract])];
        graph.add(&format!("overlay/{name}"), stage, &ports)
    });
    let volume = graph.add("volume", Volume { grid: s.grid }, &[("merged", &[merged]), ("rootness", &[rootness])]);
    let labels = graph.add("labels", Labels { grid: s.grid }, &[("system", &[system])]);
    let sight = Sight { grid: s.grid, tank: s.true_tank.clone(), min_views: s.merge.min_views };
    let sight = graph.add("sight", sight, &[("merged", &[merged][..]), ("truth", from.truth.as_slice())]);
    let evidence_pictures = from.evidence_pictures.clone();
    Ok(Shown { volume, labels, sight, overlays, root_overlays, previews, root_lines, spread, evidence_pictures })
}
