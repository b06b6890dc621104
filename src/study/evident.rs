//! The nodes between undistorted photographs and what is rendered of them.

use super::settings::Settings;
use crate::flow::{Graph, NodeId};
use crate::stages::background::Background;
use crate::stages::evidence::{Before, Evidence};
use crate::stages::evidence_pictures::EvidencePictures;

/// A photograph's name, undistorted picture and camera.
pub(super) type Seen = (String, NodeId, NodeId);

/// What is rendered of each photograph, and what it rests on.
pub(super) struct Evident {
    /// Shares of root, or the photographs themselves.
    pub rendered: Vec<NodeId>,
    /// What is behind the roots; none where the photographs themselves are rendered.
    pub background: Vec<NodeId>,
    /// Pictures of it, per photograph, where the study asks for them.
    pub pictures: Vec<NodeId>,
}

/// Adds the nodes that make of every undistorted photograph its share of root, where the study asks for it.
pub(super) fn add(graph: &mut Graph, s: &Settings, seen: &[Seen]) -> Evident {
    let (photos, cameras): (Vec<NodeId>, Vec<NodeId>) = seen.iter().map(|s| (s.1, s.2)).unzip();
    if !s.contrast.enabled {
        return Evident { rendered: photos, background: Vec::new(), pictures: Vec::new() };
    }
    let window_mm = s.contrast.window_mm;
    let stage = Background { tank: s.tank.clone(), background: s.contrast.background, window_mm };
    let background = graph.add("background", stage, &[("photos", &photos), ("cameras", &cameras)]);
    let (mut rendered, mut pictures) = (Vec::new(), Vec::new());
    for (view, (name, photo, camera)) in seen.iter().enumerate() {
        let (photo, camera) = (*photo, *camera);
        let before = Before { tank: s.tank.clone(), view, window_mm };
        let ports = [("photo", &[photo][..]), ("camera", &[camera]), ("background", &[background])];
        let stage = Evidence { before: before.clone(), blur_mm: s.contrast.blur_mm };
        let evidence = graph.add(&format!("evidence/{name}"), stage, &ports);
        rendered.push(evidence);
        if s.report.evidence {
            let [photo, camera, background] = ports;
            let ports = [photo, camera, background, ("evidence", &[evidence])];
            pictures.push(graph.add(&format!("evidence-pictures/{name}"), EvidencePictures { before }, &ports));
        }
    }
    Evident { rendered, background: vec![background], pictures }
}
