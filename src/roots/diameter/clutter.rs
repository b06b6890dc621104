//! Which pixels of a photograph the traced roots cover.

use super::profile::Sight;
use super::track::{Beads, Track};
use crate::roots::system::TracedRoot;
use ndarray::Array2;

const NONE: u32 = 0;
const SEVERAL: u32 = u32::MAX;

/// Per pixel the root that covers it.
#[derive(Debug, Clone)]
pub struct Clutter(Array2<u32>);

impl Clutter {
    /// Paints every root with its radius and a pixel of blur on either side: a disc at every bead.
    pub fn new(sight: &Sight<'_>, roots: &[TracedRoot], beads: &[Beads], tracks: &[Track]) -> Self {
        let (height, width) = sight.light.dim();
        let mut map = Array2::from_elem((height, width), NONE);
        for (r, ((traced, beads), track)) in roots.iter().zip(beads).zip(tracks).enumerate() {
            let mark = r as u32 + 1;
            for (b, pixel) in track.pixels.iter().enumerate() {
                let (Some(pixel), Some(jacobian)) = (pixel, track.jacobian(b)) else { continue };
                let radius = traced.root.radii_mm[beads.points[b]];
                let reach = radius * jacobian.norm() * std::f64::consts::FRAC_1_SQRT_2 + 1.0;
                let range = |centre: f64, size: usize| {
                    let low = (centre - reach).ceil().max(0.0) as usize;
                    let high = ((centre + reach).floor() + 1.0).clamp(0.0, size as f64) as usize;
                    low..high
                };
                for v in range(pixel.y, height) {
                    for u in range(pixel.x, width) {
                        if (u as f64 - pixel.x).hypot(v as f64 - pixel.y) <= reach {
                            let cell = &mut map[[v, u]];
                            *cell = if *cell == NONE || *cell == mark { mark } else { SEVERAL };
                        }
                    }
                }
            }
        }
        Self(map)
    }

    /// Whether a root other than number `root` covers the pixel.
    pub fn is_foreign(&self, v: usize, u: usize, root: usize) -> bool {
        let cell = self.0[[v, u]];
        cell != NONE && cell != root as u32 + 1
    }
}
