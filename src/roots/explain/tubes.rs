//! The beads drawn into a photograph as tubes: which of them cover a place, and how much of it.

use super::beads::Chain;
use super::look::{Look, Looking};
use nalgebra::Vector2;

/// Half a pixel beyond its own length a bead still covers, so that a line has no gaps.
const OVERLAP_PX: f32 = 0.5;
/// A place is sought at the nearest pixel, which lies at most so far, px.
const NEAREST_PX: f32 = 0.71;

/// The beads that cover each pixel of a photograph.
#[derive(Debug)]
pub struct Tubes<'a, 'w> {
    looking: &'a Looking<'w>,
    chain: &'a Chain,
    radius_mm: &'a [f32],
    width: usize,
    /// Where in `beads` each pixel's begin, row by row; one more at the end.
    start: Vec<u32>,
    beads: Vec<u32>,
}

impl<'a, 'w> Tubes<'a, 'w> {
    /// Draws the beads for which `drawn` holds, with their radii, mm.
    pub fn new(
        looking: &'a Looking<'w>,
        chain: &'a Chain,
        radius_mm: &'a [f32],
        drawn: impl Fn(usize) -> bool,
    ) -> Self {
        let (height, width, _) = looking.witness.evidence.dim();
        let each = |put: &mut dyn FnMut(usize, u32)| {
            for (b, look) in looking.looks.iter().enumerate() {
                let Some(look) = look.filter(|_| drawn(b)) else { continue };
                let reach = looking.cover.reach_px(radius_mm[b] * look.px_per_mm) + NEAREST_PX;
                let half = 0.5 * look.length_px + OVERLAP_PX + NEAREST_PX;
                let range = |centre: f32, size: usize| {
                    let reach = reach.max(half);
                    (centre - reach).ceil().max(0.0) as usize
                        ..((centre + reach).floor() + 1.0).clamp(0.0, size as f32) as usize
                };
                for v in range(look.pixel.y, height) {
                    for u in range(look.pixel.x, width) {
                        let off = Vector2::new(u as f32, v as f32) - look.pixel;
                        if off.dot(&look.along).abs() <= half && off.perp(&look.along).abs() <= reach {
                            put(v * width + u, b as u32);
                        }
                    }
                }
            }
        };
        let mut start = vec![0_u32; height * width + 1];
        each(&mut |pixel, _| start[pixel + 1] += 1);
        for pixel in 0..height * width {
            start[pixel + 1] += start[pixel];
        }
        let mut next = start.clone();
        let mut beads = vec![0_u32; start[height * width] as usize];
        each(&mut |pixel, bead| {
            beads[next[pixel] as usize] = bead;
            next[pixel] += 1;
        });
        Self { looking, chain, radius_mm, width, start, beads }
    }

    /// The beads of other pieces than `piece` about a place inside the photograph, and the share that each gives it.
    pub fn others(&self, at: Vector2<f32>, piece: u32) -> impl Iterator<Item = (u32, f32)> {
        let pixel = at.y.round() as usize * self.width + at.x.round() as usize;
        let near = &self.beads[self.start[pixel] as usize..self.start[pixel + 1] as usize];
        near.iter()
            .filter(move |bead| self.chain.piece[**bead as usize] != piece)
            .map(move |bead| (*bead, self.share(*bead as usize, at)))
    }

    fn share(&self, bead: usize, at: Vector2<f32>) -> f32 {
        let Some(look): Option<Look> = self.looking.looks[bead] else { return 0.0 };
        let off = at - look.pixel;
        if off.dot(&look.along).abs() > 0.5 * look.length_px + OVERLAP_PX {
            return 0.0;
        }
        self.looking.cover.share(off.perp(&look.along), self.radius_mm[bead] * look.px_per_mm)
    }
}
