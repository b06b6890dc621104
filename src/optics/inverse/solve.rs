//! Newton within the regular rays, one point at a time or lanes of points abreast, and the bisection that
//! takes over where Newton has not settled.

use super::path::Misses;
use super::{Solved, ViewMap};

/// Points solved abreast by [`ViewMap::solve_lanes`].
pub const LANES: usize = 8;

/// Misses under this count as none, mm.
const SETTLED_MM: f64 = 1e-9;
/// Newton steps before the bisection takes over.
const MOST_STEPS: usize = 12;

/// Rays of [`LANES`] points, a guess before solving and the solution after.
#[derive(Debug, Clone, Copy)]
pub struct Lanes {
    /// Moments b about the axis.
    pub b: [f64; LANES],
    /// Axial invariants s.
    pub s: [f64; LANES],
    /// Distance of each point from its ray, mm; NaN where no ray can be given.
    pub distance: [f64; LANES],
}

impl ViewMap {
    /// The guess from which any point can be solved: the ray at the axis at middle height.
    pub fn first_guess(&self) -> Lanes {
        let s = 0.5 * (self.s_range.0 + self.s_range.1);
        Lanes { b: [0.0; LANES], s: [s; LANES], distance: [0.0; LANES] }
    }

    /// Solves one point given in the turned frame; `None` where the ray would pass over rim or underside.
    pub(super) fn solve(&self, x: f64, y: f64, z: f64) -> Option<Solved> {
        let (mut b, mut s) = (0.0, 0.5 * (self.s_range.0 + self.s_range.1));
        for _ in 0..MOST_STEPS {
            let step = self.step(b, s, x, y, z);
            if step.settled {
                return Some(Solved { b, s, distance: step.f1.abs() });
            }
            (b, s) = (step.b, step.s);
        }
        self.bisect(x, y, z)
    }

    /// Solves [`LANES`] points of the tank frame, mm, starting from the rays in `lanes`. Lanes that are not
    /// `wanted` are carried along without being settled.
    #[inline(always)]
    pub fn solve_lanes(
        &self,
        x: &[f64; LANES],
        y: &[f64; LANES],
        z: &[f64; LANES],
        wanted: &[bool; LANES],
        lanes: &mut Lanes,
    ) {
        let mut px = [0.0; LANES];
        let mut py = [0.0; LANES];
        for l in 0..LANES {
            (px[l], py[l]) = self.turned(x[l], y[l]);
        }
        for _ in 0..MOST_STEPS {
            let mut settled = [true; LANES];
            let mut next = *lanes;
            for l in 0..LANES {
                let step = self.step(lanes.b[l], lanes.s[l], px[l], py[l], z[l]);
                next.b[l] = step.b;
                next.s[l] = step.s;
                next.distance[l] = step.f1.abs();
                settled[l] = step.settled | !wanted[l];
            }
            if settled.iter().all(|&s| s) {
                lanes.distance = next.distance;
                return;
            }
            *lanes = next;
        }
        for l in 0..LANES {
            if wanted[l] {
                let step = self.step(lanes.b[l], lanes.s[l], px[l], py[l], z[l]);
                if step.settled {
                    lanes.distance[l] = step.f1.abs();
                    continue;
                }
                match self.bisect(px[l], py[l], z[l]) {
                    Some(found) => (lanes.b[l], lanes.s[l], lanes.distance[l]) = (found.b, found.s, found.distance),
                    None => lanes.distance[l] = f64::NAN,
                }
            }
        }
    }

    /// Largest regular |b| at s.
    #[inline(always)]
    pub(super) fn fold_moment(&self, s: f64) -> f64 {
        self.fold.ratio(s * s) * (self.path.n_squared[0] - s * s).sqrt()
    }

    /// One Newton step, kept between the folds and within the range of s.
    #[inline(always)]
    fn step(&self, b: f64, s: f64, x: f64, y: f64, z: f64) -> Step {
        let m = self.path.misses(b, s, x, y, z);
        let fold = self.fold_moment(s);
        let inverse = 1.0 / (m.f1_b * m.f2_s - m.f1_s * m.f2_b);
        let free = b - (m.f1 * m.f2_s - m.f2 * m.f1_s) * inverse;
        // A step beyond the fold stops on it; s then answers F₂ alone.
        let s_with =
            |b_next: f64| (s - (m.f2 + m.f2_b * (b_next - b)) / m.f2_s).max(self.s_range.0).min(self.s_range.1);
        let outward = free.abs() > fold;
        let kept = if outward { self.fold_moment(s_with(fold.copysign(free))).copysign(free) } else { free };
        let s_next = s_with(kept);
        let next_fold = self.fold_moment(s_next);
        let b_next = if outward { next_fold.copysign(free) } else { free.max(-next_fold).min(next_fold) };
        // Settled: on the ray; or on the fold with the point beyond it.
        let on_ray = m.f1.abs() < SETTLED_MM;
        let beyond = (m.f1 > 0.0 && b >= fold * (1.0 - 1e-15)) | (m.f1 < 0.0 && b <= -fold * (1.0 - 1e-15));
        Step { b: b_next, s: s_next, f1: m.f1, settled: (on_ray | beyond) & (m.f2.abs() < SETTLED_MM) }
    }

    /// The solution by bisection in s, with b bisected between the folds for each s; `None` where it lies
    /// outside the range of s.
    #[cold]
    fn bisect(&self, x: f64, y: f64, z: f64) -> Option<Solved> {
        let (mut low, mut high) = self.s_range;
        if self.level(low, x, y, z).1.f2_on_chord > 0.0 || self.level(high, x, y, z).1.f2_on_chord < 0.0 {
            return None;
        }
        while let Some(middle) = between(low, high) {
            if self.level(middle, x, y, z).1.f2_on_chord > 0.0 { high = middle } else { low = middle }
        }
        let (b, misses) = self.level(low, x, y, z);
        Some(Solved { b, s: low, distance: misses.f1.abs() })
    }

    /// The ray of this s that passes the point in plan, or, where none does, the fold's on the point's side.
    fn level(&self, s: f64, x: f64, y: f64, z: f64) -> (f64, Misses) {
        let fold = self.fold_moment(s);
        let at = |b: f64| (b, self.path.misses(b, s, x, y, z));
        let (mut low, mut high) = (-fold, fold);
        // F₁ falls with b.
        for end in [at(low), at(high)] {
            if end.1.f1 * end.0 >= 0.0 {
                return end;
            }
        }
        while let Some(middle) = between(low, high) {
            if at(middle).1.f1 > 0.0 { low = middle } else { high = middle }
        }
        at(low)
    }
}

/// The middle of two numbers, while there is one.
fn between(low: f64, high: f64) -> Option<f64> {
    let middle = 0.5 * (low + high);
    (low < middle && middle < high).then_some(middle)
}

/// A Newton step and the misses of the ray it started from.
struct Step {
    b: f64,
    s: f64,
    f1: f64,
    settled: bool,
}
