//! From rendered views to roots and traits.

use super::settings::Settings;
use crate::flow::{Graph, NodeId};
use crate::stages::diameters::Diameters;
use crate::stages::explain::Explain;
use crate::stages::extract::Extract;
use crate::stages::hierarchy::Hierarchy;
use crate::stages::merge::Merge;
use crate::stages::rootness::Rootness;
use crate::stages::suppress::Suppress;
use crate::stages::trace::Trace;
use crate::stages::traits::Traits;

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
    /// Shares of root, where they are.
    pub evidence: &'a [NodeId],
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
    // What photographs need of the candidates is traced anew, so that nothing is joined over what they do not.
    let explained = (s.explain.enabled && !from.evidence.is_empty()).then(|| {
        let candidates = graph.add(&name("candidates"), trace.clone(), &ports);
        let stage = Explain { tank: s.tank.clone(), blur_mm: s.contrast.blur_mm, params: s.explain.clone() };
        let ports = [("pieces", &[candidates][..]), ("evidence", from.evidence), ("cameras", from.cameras)];
        graph.add(&name("explain"), stage, &ports)
    });
    let ports = [ports[0], ports[1], ("explained", explained.as_slice())];
    let traced = graph.add(&name("trace"), trace, &ports);
    let pieces = if s.diameters.enabled {
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
    let system = graph.add(&name("hierarchy"), hierarchy, &[("pieces", &[pieces])]);
    let traits = traits_of(graph, s, system, &name("traits"));
    Reconstruction { merged, rootness, extract, system, traits }
}

/// The traits of a system.
pub(super) fn traits_of(graph: &mut Graph, s: &Settings, system: NodeId, name: &str) -> NodeId {
    let traits = Traits { water_level_mm: s.tank.water_level_mm, study: s.name.clone(), params: s.traits.clone() };
    graph.add(name, traits, &[("system", &[system])])
}
