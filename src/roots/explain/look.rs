//! A photograph's look at a bead.

use super::Witness;
use super::beads::Chain;
use super::cover::Cover;
use crate::optics::Vec3;
use crate::photo::evidence::share::{SPAN, ZERO};
use nalgebra::Vector2;

/// Step of the numeric derivative, mm: far below a pixel, far above rounding.
const STEP_MM: f64 = 0.02;
/// Confidence under which nothing is told.
const LEAST_SAY: f32 = 0.02;

/// A bead in a photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Pixel: x = column, y = row.
    pub pixel: Vector2<f32>,
    /// Unit direction of the root in the photograph.
    pub along: Vector2<f32>,
    /// Length of the bead's step in the photograph, px.
    pub length_px: f32,
    /// Scale across the root, px/mm.
    pub px_per_mm: f32,
    /// Share of root that the photograph shows, 0..1.
    pub share: f32,
    /// How far its word counts, 0..1: confidence, less where the root is seen end on.
    pub say: f32,
}

/// A photograph with its looks, one per bead; none where it does not see the bead through a clear, regular ray or knows nothing.
#[derive(Debug, Clone)]
pub struct Looking<'a> {
    /// The photograph.
    pub witness: Witness<'a>,
    /// What tubes look like in it.
    pub cover: Cover,
    /// Per bead.
    pub looks: Vec<Option<Look>>,
}

/// The looks of a photograph at all beads.
pub fn looks(witness: &Witness<'_>, chain: &Chain) -> Vec<Option<Look>> {
    (0..chain.len()).map(|b| look(witness, &chain.places[b], &chain.tangents[b], chain.step_mm[b])).collect()
}

fn look(witness: &Witness<'_>, place: &Vec3, tangent: &Vec3, step_mm: f64) -> Option<Look> {
    let pixel = |p: &Vec3| {
        let seen = witness.map.project(p)?;
        (seen.clear && seen.distance_mm < STEP_MM && witness.map.view().holds(seen.u, seen.v))
            .then(|| Vector2::new(seen.u, seen.v))
    };
    let here = pixel(place)?;
    let mut slope = nalgebra::Matrix2x3::zeros();
    for axis in 0..3 {
        let mut moved = *place;
        moved[axis] += STEP_MM;
        slope.set_column(axis, &((pixel(&moved)? - here) / STEP_MM));
    }
    let run = slope * tangent;
    let along = run.try_normalize(1e-9).unwrap_or_else(|| Vector2::new(1.0, 0.0));
    let px_per_mm = slope.tr_mul(&Vector2::new(-along.y, along.x)).norm();
    let (share, confidence) = read(witness, here.cast())?;
    Some(Look {
        pixel: here.cast(),
        along: along.cast(),
        length_px: (run.norm() * step_mm) as f32,
        px_per_mm: px_per_mm as f32,
        share,
        say: confidence * (run.norm() / px_per_mm.max(1e-9)).min(1.0) as f32,
    })
}

/// Share and confidence between pixels, 0..1 each; none outside or where hardly anything is told.
pub fn read(witness: &Witness<'_>, at: Vector2<f32>) -> Option<(f32, f32)> {
    let (height, width, _) = witness.evidence.dim();
    if !(at.x >= 0.0 && at.y >= 0.0 && at.x < (width - 1) as f32 && at.y < (height - 1) as f32) {
        return None;
    }
    let (mut share, mut say) = (0.0, 0.0);
    for ([v, u], weight) in corners(at) {
        let confidence = weight * f32::from(witness.evidence[[v, u, 1]]) / 255.0;
        share += confidence * (f32::from(witness.evidence[[v, u, 0]]) - ZERO) / SPAN;
        say += confidence;
    }
    (say > LEAST_SAY).then(|| ((share / say).clamp(0.0, 1.0), say))
}

/// The four pixels (row, column) about a position, and their weights.
pub fn corners(at: Vector2<f32>) -> [([usize; 2], f32); 4] {
    let (u, v) = (at.x as usize, at.y as usize);
    let (fu, fv) = (at.x - u as f32, at.y - v as f32);
    [
        ([v, u], (1.0 - fu) * (1.0 - fv)),
        ([v, u + 1], fu * (1.0 - fv)),
        ([v + 1, u], (1.0 - fu) * fv),
        ([v + 1, u + 1], fu * fv),
    ]
}
