//! Where the regular rays end: the moment b_fold(s) at which the exit points fold back.  Paper 2.3.3.
//!
//! For every s the regular rays are those with |b| < b_fold(s): the first b at which the exit determinant
//! vanishes, or, where it never does, the largest b that gets into the water. The ratio
//! b_fold(s) / N₁(s) is even in s and mostly smooth, so it is kept as a Chebyshev series in s², long enough
//! that it follows the bisected fold to 1e-9 of its value. Behind a wall so thick that flat rays no longer graze
//! the water (inner radius x index of water under outer radius x index of air, a quarter of the radius) another
//! bound takes over at some s and the fold has a kink or a step; there the range of s² is halved around it until
//! every piece is smooth or too narrow to matter.

use super::path::Path;

/// b_fold(s), for |s| up to a given bound.
#[derive(Debug, Clone)]
pub(super) struct Fold {
    /// By rising s²; one unless the fold has kinks.
    pieces: Vec<Piece>,
}

/// See [`Fold::lower_bound`].
#[derive(Debug, Clone, Copy)]
pub(super) struct LowerBound {
    c0: f64,
    c1: f64,
    c2: f64,
}

impl LowerBound {
    /// The bound of b_fold / N₁ at s².
    #[inline(always)]
    pub fn ratio(&self, s2: f64) -> f64 {
        self.c0 + s2 * (self.c1 + s2 * self.c2)
    }
}

/// The fold over a range of s² as a Chebyshev series.
#[derive(Debug, Clone)]
struct Piece {
    /// Range of s².
    low: f64,
    high: f64,
    /// 2 / (high - low).
    scale: f64,
    /// Coefficients of b_fold/N₁ in s² mapped to -1..1; the first one halved.
    series: Vec<f64>,
}

/// Terms of a series at most.
const MOST_TERMS: usize = 64;
/// Part of the range of s² below which a piece that is not smooth is left alone.
const NARROWEST: f64 = 1e-9;

impl Fold {
    /// The fold of this camera and tank for |s| <= `largest_s`.
    pub fn new(path: &Path, largest_s: f64) -> Self {
        let ratio = |s2: f64| fold_by_bisection(path, s2.sqrt()) / (path.n_squared[0] - s2).sqrt();
        let whole = largest_s * largest_s;
        let mut pieces = Vec::new();
        let mut open = vec![(0.0, whole)];
        while let Some((low, high)) = open.pop() {
            match Piece::smooth(&ratio, low, high) {
                Some(piece) => pieces.push(piece),
                None if high - low <= NARROWEST * whole => pieces.push(Piece::constant(&ratio, low, high)),
                None => {
                    let middle = 0.5 * (low + high);
                    open.extend([(middle, high), (low, middle)]);
                }
            }
        }
        Self { pieces }
    }

    /// Whether the fold has no kinks.
    pub fn is_smooth(&self) -> bool {
        self.pieces.len() == 1
    }

    /// b_fold / N₁ at each `s²` with its derivative in `s²`, of a smooth fold; of another that of its first piece.
    #[inline(always)]
    pub fn ratios_and_slopes<const N: usize>(&self, s2: &[f64; N]) -> ([f64; N], [f64; N]) {
        self.pieces[0].ratios_and_slopes(s2)
    }

    /// A parabola in s² that stays below b_fold / N₁ by at least a millionth: cheap to ask, and close to the fold where
    /// that is smooth.
    pub fn lower_bound(&self) -> LowerBound {
        let largest = self.pieces.last().map_or(1.0, |piece| piece.high);
        let ratio = |s2: f64| self.ratios(&[s2])[0];
        // Through the ends and the middle of the range.
        let [a, b, c] = [0.0, 0.5, 1.0].map(|t| ratio(t * largest));
        let mut bound =
            LowerBound { c0: a, c1: (4.0 * b - 3.0 * a - c) / largest, c2: 2.0 * (a - 2.0 * b + c) / largest.powi(2) };
        let samples = self
            .pieces
            .iter()
            .flat_map(|piece| (0..=256).map(|i| piece.low + (piece.high - piece.low) * f64::from(i) / 256.0));
        let excess = samples.map(|s2| bound.ratio(s2) - ratio(s2)).fold(0.0, f64::max);
        bound.c0 -= excess + 1e-6 * a;
        bound
    }

    /// b_fold / N₁ at each `s²`.
    #[inline(always)]
    pub fn ratios<const N: usize>(&self, s2: &[f64; N]) -> [f64; N] {
        match &self.pieces[..] {
            [piece] => piece.ratios(s2),
            pieces => s2.map(|s2| {
                let at = pieces.partition_point(|piece| piece.high < s2).min(pieces.len() - 1);
                pieces[at].ratios(&[s2])[0]
            }),
        }
    }
}

impl Piece {
    /// The series over a range, if it converges.
    fn smooth(ratio: &dyn Fn(f64) -> f64, low: f64, high: f64) -> Option<Self> {
        let scale = 2.0 / (high - low);
        let mut terms = 8;
        while terms <= MOST_TERMS {
            let mut series = chebyshev(&|t| ratio((t + 1.0) / scale + low), terms);
            let tail = |from: usize| series[from..].iter().map(|c| c.abs()).sum::<f64>();
            if tail(terms - 2) < 1e-10 * series[0] {
                // What the last terms add together does not matter.
                let needed = (1..terms).find(|&n| tail(n) < 1e-10 * series[0]).unwrap_or(terms);
                series.truncate(needed);
                return Some(Self { low, high, scale, series });
            }
            terms *= 2;
        }
        None
    }

    /// The smaller of the values at the ends.
    fn constant(ratio: &dyn Fn(f64) -> f64, low: f64, high: f64) -> Self {
        Self { low, high, scale: 0.0, series: vec![ratio(low).min(ratio(high))] }
    }

    /// Clenshaw's sums at each `s²` of the series and of its derivative in `s²`.
    #[inline(always)]
    fn ratios_and_slopes<const N: usize>(&self, s2: &[f64; N]) -> ([f64; N], [f64; N]) {
        let (mut t, mut b1, mut b2) = ([0.0; N], [0.0; N], [0.0; N]);
        let (mut d1, mut d2) = ([0.0; N], [0.0; N]);
        for l in 0..N {
            t[l] = (s2[l] - self.low) * self.scale - 1.0;
        }
        for &c in self.series[1..].iter().rev() {
            for l in 0..N {
                (d1[l], d2[l]) = (2.0 * (b1[l] + t[l] * d1[l]) - d2[l], d1[l]);
                (b1[l], b2[l]) = (c + 2.0 * t[l] * b1[l] - b2[l], b1[l]);
            }
        }
        for l in 0..N {
            d1[l] = (b1[l] + t[l] * d1[l] - d2[l]) * self.scale;
            b1[l] = self.series[0] + t[l] * b1[l] - b2[l];
        }
        (b1, d1)
    }

    /// Clenshaw's sum at each `s²`.
    #[inline(always)]
    fn ratios<const N: usize>(&self, s2: &[f64; N]) -> [f64; N] {
        let (mut t, mut b1, mut b2) = ([0.0; N], [0.0; N], [0.0; N]);
        for l in 0..N {
            t[l] = (s2[l] - self.low) * self.scale - 1.0;
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_follow_the_bisected_fold_through_kinks() {
        for (wall, n_wall, n_water) in [(0.06, 1.49, 1.333), (0.25, 1.49, 1.333), (0.28, 1.5, 1.36), (0.3, 1.33, 1.4)] {
            let path = Path {
                r0: 350.0,
                z0: 0.0,
                outer: 100.0,
                inner: 100.0 * (1.0 - wall),
                n_squared: [1.0, n_wall * n_wall, n_water * n_water],
            };
            let fold = Fold::new(&path, 0.74);
            assert!(fold.pieces.len() == 1 || wall > 0.1, "a thin wall's fold is one smooth piece");
            let off = |i: &u32| {
                let s = 0.74 * f64::from(*i) / 1000.0;
                let bisected = fold_by_bisection(&path, s) / (1.0 - s * s).sqrt();
                (fold.ratios(&[s * s])[0] / bisected - 1.0).abs() > 1e-8
            };
            assert_eq!((0..=1000).filter(off).count(), 0, "wall {wall}, {} pieces", fold.pieces.len());
            if fold.is_smooth() {
                for s2 in [0.0, 0.01, 0.2, 0.5] {
                    let ([ratio], [slope]) = fold.ratios_and_slopes(&[s2]);
                    let [near] = fold.ratios(&[s2 + 1e-6]);
                    assert_eq!([ratio], fold.ratios(&[s2]));
                    assert!((slope - (near - ratio) / 1e-6).abs() < 1e-4 * ratio, "{slope} at {s2}");
                }
            }
            let bound = fold.lower_bound();
            let gap = |i: u32| {
                let s2 = (0.74 * f64::from(i) / 1000.0).powi(2);
                fold.ratios(&[s2])[0] - bound.ratio(s2)
            };
            let (least, most) = (0..=1000).map(gap).fold((f64::INFINITY, 0.0), |(a, b), g| (g.min(a), g.max(b)));
            assert!(least > 0.0, "wall {wall}: the bound is {least} below");
            assert!(most < 1.0 || wall > 0.1, "wall {wall}: the bound is {most} mm below");
        }
    }
}
