//! The folded rays: those beyond the fold, that cross regular ones before they leave the water.  Paper 2.3.3.
//!
//! They are only followed to show what their exclusion is worth (paper figures 6 and 8), so plain search does:
//! on the point's side of the axis, b runs in [`STEPS`] steps from the fold to the largest moment that gets into the
//! water, s answering F₂ by Newton; a change of sign of F₁ is bisected, else the smallest |F₁| among the steps
//! counts.

use super::{Solved, ViewMap};

const STEPS: usize = 16;

impl ViewMap {
    /// The irregular ray closest to a point of the turned frame, searched on the side of `fold`, the fold's own ray
    /// (b, s) at the point.
    pub(super) fn irregular(&self, x: f64, y: f64, z: f64, fold: (f64, f64)) -> Solved {
        let (low, high) = self.s_range;
        let side = 1f64.copysign(fold.0);
        // The ray at `fraction` of the way from the fold to the largest moment; misses are signed away from the axis.
        let at = |fraction: f64, s_start: f64| {
            let mut s = s_start;
            let mut ray = (0.0, s, 0.0);
            for _ in 0..4 {
                let [inner] = self.fold_moments(&[s]);
                let outer = self.path.largest_moment(s) * (1.0 - 1e-9);
                let b = side * (inner + fraction * (outer - inner).max(0.0));
                let m = self.path.misses(b, s, x, y, z);
                ray = (b, s, side * m.f1);
                s = (s - m.f2_on_chord / m.f2_s.max(1.0)).clamp(low, high);
            }
            ray
        };
        let solved = |(b, s, miss): (f64, f64, f64)| Solved { b, s, distance: miss.abs() };
        let mut best = at(0.0, fold.1);
        let mut last = best;
        for i in 1..=STEPS {
            let next = at(i as f64 / STEPS as f64, last.1);
            if (last.2 > 0.0) != (next.2 > 0.0) {
                let (mut from, mut to) = ((i - 1) as f64 / STEPS as f64, i as f64 / STEPS as f64);
                let mut ray = next;
                for _ in 0..40 {
                    let middle = 0.5 * (from + to);
                    ray = at(middle, ray.1);
                    if (ray.2 > 0.0) == (last.2 > 0.0) { from = middle } else { to = middle }
                }
                return solved(ray);
            }
            if next.2.abs() < best.2.abs() {
                best = next;
            }
            last = next;
        }
        solved(best)
    }
}
