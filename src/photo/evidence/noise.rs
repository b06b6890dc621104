//! The photographs' own noise: variance against the code, read noise and photon noise.
//!
//! σ²(code) = read + photon code, both from the variances that pixels of the still background show over the views: the
//! middle of each of eight levels, and a line through them by least squares, never falling.

use serde::{Deserialize, Serialize};

/// Variance of a code by its level; codes².
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Noise {
    /// At code 0.
    pub read: f32,
    /// More per code.
    pub photon: f32,
}

/// Rounding alone leaves a twelfth.
const ROUNDING: f32 = 1.0 / 12.0;
const LEVELS: usize = 8;

impl Noise {
    /// From pairs of level and variance.
    pub fn fit(pairs: &[(f32, f32)]) -> Self {
        let mut levels: Vec<Vec<(f32, f32)>> = vec![Vec::new(); LEVELS];
        for &(code, variance) in pairs {
            levels[((code / 256.0 * LEVELS as f32) as usize).min(LEVELS - 1)].push((code, variance));
        }
        // Weighted by the number of pixels; the middle of a level is not moved by roots that some of them show.
        let (mut n, mut x, mut y, mut xx, mut xy) = (0.0f64, 0.0, 0.0, 0.0, 0.0);
        for level in levels.iter_mut().filter(|level| level.len() >= 20) {
            let middle = level.len() / 2;
            let weight = level.len() as f64;
            let code = f64::from(level.select_nth_unstable_by(middle, |a, b| a.0.total_cmp(&b.0)).1.0);
            let variance = f64::from(level.select_nth_unstable_by(middle, |a, b| a.1.total_cmp(&b.1)).1.1);
            (n, x, y) = (n + weight, x + weight * code, y + weight * variance);
            (xx, xy) = (xx + weight * code * code, xy + weight * code * variance);
        }
        if n == 0.0 {
            return Self { read: 4.0, photon: 0.0 };
        }
        let spread = xx - x * x / n;
        let slope = if spread > n { ((xy - x * y / n) / spread).max(0.0) } else { 0.0 };
        let slope = slope.min(y / x.max(1e-9));
        Self { read: ((y - slope * x) / n) as f32, photon: slope as f32 }
    }

    /// Variance at a code, codes².
    pub fn variance(&self, code: f32) -> f32 {
        (self.read + self.photon * code.max(0.0)).max(ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_and_outliers_are_not_followed() {
        let pairs: Vec<_> = (0..2000)
            .map(|n| {
                let code = (n % 200) as f32;
                (code, if n % 5 == 0 { 900.0 } else { 3.0 + 0.05 * code })
            })
            .collect();
        let noise = Noise::fit(&pairs);
        assert!((noise.variance(0.0) - 3.0).abs() < 1.0 && (noise.variance(180.0) - 12.0).abs() < 1.5, "{noise:?}");
        assert!(Noise::fit(&[]).variance(100.0) > 0.0);
    }
}
