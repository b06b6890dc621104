//! Newton within the regular rays, lanes of points abreast, and the bisection that takes over where Newton has
//! not settled.

use super::path::Misses;
use super::{Rays, Solved, ViewMap};

/// A step under this in b (mm) and under a thousandth of it in s settles: what is left is of the order of its
/// square, or, at worst (a point on the wall at the fold itself), of its own.
const SETTLED: f64 = 1e-7;
/// Newton steps before the bisection takes over.
const MOST_STEPS: usize = 12;

impl ViewMap {
    /// Solves one point given in the turned frame; `None` where the ray would pass over rim or underside.
    pub(super) fn solve(&self, x: f64, y: f64, z: f64) -> Option<Solved> {
        let mut rays = self.axis_rays::<1>();
        self.solve_rays(&[x], &[y], z, &[true], &mut rays);
        let ([b], [s], [distance]) = (rays.b, rays.s, rays.distance);
        (!distance.is_nan()).then_some(Solved { b, s, distance })
    }

    /// Rays straight at the axis, half-way between the steepest ones: the guess from which any point is solved.
    pub(super) fn axis_rays<const N: usize>(&self) -> Rays<N> {
        Rays { s: [0.5 * (self.s_range.0 + self.s_range.1); N], ..Rays::ZERO }
    }

    /// Solves N points of one plane, given in the turned frame, starting from `rays`, which may be anything.
    /// Lanes that are not `wanted` are carried along without being settled.
    #[inline(always)]
    pub(super) fn solve_rays<const N: usize>(
        &self,
        x: &[f64; N],
        y: &[f64; N],
        z: f64,
        wanted: &[bool; N],
        rays: &mut Rays<N>,
    ) {
        for s in &mut rays.s {
            // A NaN becomes the lower end.
            *s = s.max(self.s_range.0).min(self.s_range.1);
        }
        let fold = self.fold_moments(&rays.s);
        for (b, fold) in rays.b.iter_mut().zip(fold) {
            *b = b.max(-fold).min(fold);
        }
        let mut settled = [false; N];
        for _ in 0..MOST_STEPS {
            settled = self.step(x, y, z, rays);
            if (0..N).all(|l| settled[l] | !wanted[l]) {
                break;
            }
        }
        for l in (0..N).filter(|&l| wanted[l] && !settled[l]) {
            match self.bisect(x[l], y[l], z) {
                Some(found) => {
                    (rays.b[l], rays.s[l], rays.distance[l]) = (found.b, found.s, found.distance);
                    let m = self.path.misses(found.b, found.s, x[l], y[l], z);
                    rays.density[l] = (1.0 / (m.f1_b * m.f2_s - m.f1_s * m.f2_b)).abs();
                }
                None => rays.distance[l] = f64::NAN,
            }
        }
        for l in 0..N {
            (rays.wall_z[l], rays.water_z[l]) = self.path.entry_heights(rays.b[l], rays.s[l]);
        }
    }

    /// Largest regular |b| at each s.
    #[inline(always)]
    pub(super) fn fold_moments<const N: usize>(&self, s: &[f64; N]) -> [f64; N] {
        let mut out = [0.0; N];
        for l in 0..N {
            out[l] = s[l] * s[l];
        }
        let ratio = self.fold.ratios(&out);
        for l in 0..N {
            out[l] = ratio[l] * (self.path.n_squared[0] - s[l] * s[l]).sqrt();
        }
        out
    }

    /// One Newton step, kept between the folds and within the range of s; tells which lanes have settled.
    #[inline(always)]
    fn step<const N: usize>(&self, x: &[f64; N], y: &[f64; N], z: f64, rays: &mut Rays<N>) -> [bool; N] {
        let (low, high) = self.s_range;
        let (b, s) = (rays.b, rays.s);
        let fold = self.fold_moments(&s);
        let (mut free, mut f1) = ([0.0; N], [0.0; N]);
        // The s that answers F₂ for a given b: s_free + s_per_b (b - b_now).
        let (mut s_free, mut s_per_b) = ([0.0; N], [0.0; N]);
        let mut s_on_fold = [0.0; N];
        for l in 0..N {
            let m = self.path.misses(b[l], s[l], x[l], y[l], z);
            let inverse = 1.0 / (m.f1_b * m.f2_s - m.f1_s * m.f2_b);
            rays.density[l] = inverse.abs();
            free[l] = b[l] - (m.f1 * m.f2_s - m.f2 * m.f1_s) * inverse;
            f1[l] = m.f1;
            let per_s = 1.0 / m.f2_s;
            s_free[l] = s[l] - m.f2 * per_s;
            s_per_b[l] = -m.f2_b * per_s;
            s_on_fold[l] = (s_free[l] + s_per_b[l] * (fold[l].copysign(free[l]) - b[l])).max(low).min(high);
        }
        // A step beyond the fold stops on it.
        let stop = self.fold_moments(&s_on_fold);
        for l in 0..N {
            let kept = if free[l].abs() > fold[l] { stop[l].copysign(free[l]) } else { free[l] };
            rays.s[l] = (s_free[l] + s_per_b[l] * (kept - b[l])).max(low).min(high);
        }
        let next_fold = self.fold_moments(&rays.s);
        let mut settled = [false; N];
        for l in 0..N {
            let outward = free[l].abs() > fold[l];
            let kept =
                if outward { next_fold[l].copysign(free[l]) } else { free[l].max(-next_fold[l]).min(next_fold[l]) };
            // Far from the point the slope may have the wrong sign and lead to the fold on the other side: back
            // towards the axis.
            let astray = outward & (f1[l] * free[l] < 0.0);
            rays.b[l] = if astray { 0.5 * b[l] } else { kept };
            rays.distance[l] = if outward { f1[l].abs() } else { 0.0 };
            // At the end of the range of s a small step means nothing.
            let inside = (rays.s[l] > low) & (rays.s[l] < high);
            settled[l] =
                ((rays.b[l] - b[l]).abs() < SETTLED) & ((rays.s[l] - s[l]).abs() < 1e-3 * SETTLED) & inside & !astray;
        }
        settled
    }

    /// The solution by bisection in the moment, as a part c of the fold's, with the ray of each moment at the
    /// point's height bisected in s; `None` where it lies outside the range of s.
    ///
    /// Along the rays of one height the slope of F₁ is the determinant of (F₁, F₂) over ∂F₂/∂s: it keeps its sign
    /// where rays are regular, also steep ones, for which F₁ alone may turn back.
    #[cold]
    fn bisect(&self, x: f64, y: f64, z: f64) -> Option<Solved> {
        let at = |c: f64| self.level(c, x, y, z);
        let on_level = |c: f64| at(c).1.f2_on_chord.abs() < 1e-6;
        let cross = |mut low: f64, mut high: f64| {
            while let Some(middle) = between(low, high) {
                if at(middle).1.f1 > 0.0 { low = middle } else { high = middle }
            }
            low
        };
        let solved = |c: f64| {
            let ((b, s), misses) = at(c);
            Solved { b, s, distance: misses.f1.abs() }
        };
        let c = if at(-1.0).1.f1 <= 0.0 {
            -1.0
        } else if at(1.0).1.f1 >= 0.0 {
            1.0
        } else {
            cross(-1.0, 1.0)
        };
        if on_level(c) {
            return Some(solved(c));
        }
        // Around c the point's height asks for an s beyond the range: what is left are the moments at either fold.
        for end in [-1.0, 1.0] {
            if !on_level(end) {
                continue;
            }
            let (mut on, mut beyond) = (end, c);
            while let Some(middle) = between(on.min(beyond), on.max(beyond)) {
                if on_level(middle) { on = middle } else { beyond = middle }
            }
            let (low, high) = (on.min(end), on.max(end));
            if at(low).1.f1 > 0.0 && at(high).1.f1 <= 0.0 {
                return Some(solved(cross(low, high)));
            }
        }
        None
    }

    /// The ray with moment c b_fold(s) that passes at the point's height, or the one at the end of the range of s.
    fn level(&self, c: f64, x: f64, y: f64, z: f64) -> ((f64, f64), Misses) {
        let at = |s: f64| {
            let b = c * self.fold_moments(&[s])[0];
            ((b, s), self.path.misses(b, s, x, y, z))
        };
        let (mut low, mut high) = self.s_range;
        while let Some(middle) = between(low, high) {
            if at(middle).1.f2_on_chord > 0.0 { high = middle } else { low = middle }
        }
        at(low)
    }
}

/// The middle of two numbers, while there is one.
fn between(low: f64, high: f64) -> Option<f64> {
    let middle = 0.5 * (low + high);
    (low < middle && middle < high).then_some(middle)
}
