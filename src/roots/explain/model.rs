//! The kept beads drawn into a photograph: per pixel how much of it the roots account for, and which.

use super::beads::Chain;
use super::look::{Looking, corners};
use nalgebra::Vector2;
use ndarray::Array2;

/// Half a pixel beyond its own length a bead still draws, so that a line has no gaps.
const OVERLAP_PX: f32 = 0.5;
/// Shares below it are none.
const LEAST: f32 = 0.02;

/// A piece's share of a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Part {
    share: f32,
    piece: u32,
}

const NONE: Part = Part { share: 0.0, piece: u32::MAX };

/// Per pixel the two pieces that cover most of it.
#[derive(Debug, Clone)]
pub struct Model {
    parts: Array2<[Part; 2]>,
}

impl Model {
    /// Draws the beads that are kept with their radii, mm.
    pub fn new(looking: &Looking<'_>, chain: &Chain, kept: &[bool], radius_mm: &[f32]) -> Self {
        let (height, width, _) = looking.witness.evidence.dim();
        let mut model = Self { parts: Array2::from_elem((height, width), [NONE; 2]) };
        for (b, look) in looking.looks.iter().enumerate() {
            let Some(look) = look.filter(|_| kept[b]) else { continue };
            let radius = radius_mm[b] * look.px_per_mm;
            let half = 0.5 * look.length_px + OVERLAP_PX;
            let reach = looking.cover.reach_px(radius).max(half);
            let range = |centre: f32, size: usize| {
                (centre - reach).ceil().max(0.0) as usize
                    ..((centre + reach).floor() + 1.0).clamp(0.0, size as f32) as usize
            };
            for v in range(look.pixel.y, height) {
                for u in range(look.pixel.x, width) {
                    let off = Vector2::new(u as f32, v as f32) - look.pixel;
                    if off.dot(&look.along).abs() > half {
                        continue;
                    }
                    let share = looking.cover.share(off.perp(&look.along), radius);
                    if share >= LEAST {
                        model.draw(v, u, Part { share, piece: chain.piece[b] });
                    }
                }
            }
        }
        model
    }

    fn draw(&mut self, v: usize, u: usize, part: Part) {
        let [first, second] = &mut self.parts[[v, u]];
        if first.piece == part.piece {
            first.share = first.share.max(part.share);
        } else if part.share > first.share {
            *second = *first;
            *first = part;
        } else if second.piece == part.piece {
            second.share = second.share.max(part.share);
        } else if part.share > second.share {
            *second = part;
        }
    }

    /// Share that others than `piece` account for at a pixel.
    pub fn others(&self, v: usize, u: usize, piece: u32) -> f32 {
        let [first, second] = self.parts[[v, u]];
        if first.piece == piece { second.share } else { first.share }
    }

    /// The same between pixels; `at` lies a pixel inside the photograph.
    pub fn others_between(&self, at: Vector2<f32>, piece: u32) -> f32 {
        corners(at).into_iter().map(|([v, u], weight)| weight * self.others(v, u, piece)).sum()
    }
}
