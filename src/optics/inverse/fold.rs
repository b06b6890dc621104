//! Where the regular rays end: the moment b_fold(s) at which the exit points fold back.  Paper 2.3.3.
//!
//! For every s the regular rays are those with |b| < b_fold(s): the first b at which the exit determinant
//! vanishes, or, where it never does, the largest b that gets into the water. The ratio
//! b_fold(s) / N₁(s) is even in s and smooth, so it is kept as a Chebyshev series in s², long enough
//! that it follows the bisected fold to 1e-9 of its value. Behind a wall so thick that flat rays no longer graze
//! the water (inner radius x index of water under outer radius x index of air, a quarter of the radius) the fold has
//! a kink; there the series stays inside it, by up to 3e-4 of its value.

use super::path::Path;

/// b_fold(s), for |s| up to a given bound.
#[derive(Debug, Clone)]
pub(super) struct Fold {
    /// Chebyshev coefficients of b_fold/N₁ in t = s²/largest s² mapped to -1..1; the first one halved.
    series: Vec<f64>,
    /// 2 / largest s².
    scale: f64,
}

impl Fold {
    /// The fold of this camera and tank for |s| <= `largest_s`.
    pub fn new(path: &Path, largest_s: f64) -> Self {
        let scale = 2.0 / (largest_s * largest_s);
        let ratio = |t: f64| {
            let s2 = (t + 1.0) / scale;
            fold_by_bisection(path, s2.sqrt()) / (path.n_squared[0] - s2).sqrt()
        };
        let mut terms = 8;
        loop {
            let mut fold = Self { series: chebyshev(&ratio, terms), scale };
            let tail: f64 = fold.series[terms - 2..].iter().map(|c| c.abs()).sum();
            if tail < 1e-10 * fold.series[0] {
                return fold;
            }
            if terms >= 64 {
                fold.stay_within(&ratio);
                return fold;
            }
            terms *= 2;
        }
    }

    /// Lowers a series that did not converge (the fold has a kink where another wall takes over) until it
    /// nowhere exceeds the fold.
    fn stay_within(&mut self, ratio: &dyn Fn(f64) -> f64) {
        let excess = (0..=256)
            .map(|i| i as f64 / 128.0 - 1.0)
            .map(|t| self.ratios(&[(t + 1.0) / self.scale])[0] / ratio(t))
            .fold(1.0, f64::max);
        self.series.iter_mut().for_each(|c| *c /= excess * (1.0 + 1e-6));
    }

    /// Smallest b_fold / N₁, to a millionth below.
    pub fn smallest(&self) -> f64 {
        (0..=256).map(|i| self.ratios(&[f64::from(i) / 128.0 / self.scale])[0]).fold(f64::INFINITY, f64::min)
            * (1.0 - 1e-6)
    }

    /// b_fold / N₁ at each `s²` (Clenshaw).
    #[inline(always)]
    pub fn ratios<const N: usize>(&self, s2: &[f64; N]) -> [f64; N] {
        let (mut t, mut b1, mut b2) = ([0.0; N], [0.0; N], [0.0; N]);
        for l in 0..N {
            t[l] = s2[l] * self.scale - 1.0;
        }
        for &c in self.series[1..].iter().rev() {
            for l in 0..N {
                (b1[l], b2[l]) = (c + 2.0 * t[l] * b1[l] - b2[l], b1[l]);
            }
        }
        for l in 0..N {
            b1[l] = self.series[0] + t[l] * b1[l] - b2[l];
        }
        b1
    }
}

/// First b at which the exit determinant stops being negative, or (just under) the largest b.
fn fold_by_bisection(path: &Path, s: f64) -> f64 {
    const STEPS: usize = 200;
    let largest = path.largest_moment(s) * (1.0 - 1e-9);
    let regular = |b: f64| path.exit_determinant(b, s) < 0.0;
    let Some(first) = (1..=STEPS).find(|&i| !regular(largest * i as f64 / STEPS as f64)) else {
        return largest;
    };
    let (mut low, mut high) = (largest * (first - 1) as f64 / STEPS as f64, largest * first as f64 / STEPS as f64);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if regular(middle) { low = middle } else { high = middle }
    }
    low
}

/// Chebyshev coefficients of `f` on -1..1 from its values at the `terms` roots; the first one halved.
fn chebyshev(f: &dyn Fn(f64) -> f64, terms: usize) -> Vec<f64> {
    let angle = |k: usize| std::f64::consts::PI * (k as f64 + 0.5) / terms as f64;
    let values: Vec<f64> = (0..terms).map(|k| f(angle(k).cos())).collect();
    (0..terms)
        .map(|j| {
            let sum: f64 = (0..terms).map(|k| values[k] * (j as f64 * angle(k)).cos()).sum();
            sum * if j == 0 { 1.0 } else { 2.0 } / terms as f64
        })
        .collect()
}
