//! Which pixels of a photograph the traced roots cover.
//!
//! A piece hides another where both cover a pixel and it is at least `HIDES` (a half) times as strong: among close roots
//! there are many weak ridges that are none, and these must not keep the photographs from looking at what is one.

use super::sight::Sight;
use super::track::{Beads, Track};
use crate::roots::system::TracedRoot;
use ndarray::Array2;

/// A ridge of less than this part of another's strength does not hide it.
const HIDES: f64 = 0.5;
const NONE: u32 = 0;

/// Per pixel the two strongest roots that cover it, as number + 1.
#[derive(Debug, Clone)]
pub struct Clutter<'a> {
    marks: Array2<[u32; 2]>,
    strengths: &'a [f64],
}

impl<'a> Clutter<'a> {
    /// Paints every root with its radius and a pixel of blur on either side: a disc at every bead. `strengths` are
    /// theirs.
    pub fn new(
        sight: &Sight<'_>,
        roots: &[TracedRoot],
        strengths: &'a [f64],
        beads: &[Beads],
        tracks: &[Track],
    ) -> Self {
        let (height, width) = sight.light.dim();
        let mut clutter = Self { marks: Array2::from_elem((height, width), [NONE; 2]), strengths };
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
                            clutter.paint(v, u, mark);
                        }
                    }
                }
            }
        }
        clutter
    }

    fn strength(&self, mark: u32) -> f64 {
        if mark == NONE { f64::NEG_INFINITY } else { self.strengths[mark as usize - 1] }
    }

    fn paint(&mut self, v: usize, u: usize, mark: u32) {
        let [first, second] = self.marks[[v, u]];
        if mark == first || mark == second {
            return;
        }
        if self.strength(mark) > self.strength(first) {
            self.marks[[v, u]] = [mark, first];
        } else if self.strength(mark) > self.strength(second) {
            self.marks[[v, u]][1] = mark;
        }
    }

    /// Whether a root hides number `root` at the pixel.
    pub fn is_foreign(&self, v: usize, u: usize, root: usize) -> bool {
        let own = root as u32 + 1;
        let [first, second] = self.marks[[v, u]];
        let other = if first == own { second } else { first };
        self.strength(other) >= HIDES * self.strengths[root]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weak_ridges_hide_no_strong_ones() {
        let strengths = [1.0, 0.3, 0.8, 0.2];
        let covered = |marks: &[u32]| {
            let mut clutter = Clutter { marks: Array2::from_elem((1, 1), [NONE; 2]), strengths: &strengths };
            marks.iter().for_each(|&mark| clutter.paint(0, 0, mark));
            [0, 1, 2, 3].map(|root| clutter.is_foreign(0, 0, root))
        };
        assert_eq!(covered(&[1]), [false, true, true, true]);
        assert_eq!(covered(&[2, 4]), [false, true, false, true], "too weak for the strong, not for each other");
        for order in [[1, 2, 3, 4], [4, 3, 2, 1], [2, 3, 1, 4], [3, 3, 1, 1]] {
            assert_eq!(covered(&order), [true, true, true, true], "{order:?}");
        }
    }
}
