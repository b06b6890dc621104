//! How much of its share of root a tube gives a pixel, by the pixel's distance across the tube.
//!
//! A tube of radius r, blurred by a Gaussian σ, covers `½ [erf((x + r) / σ√2) − erf((x − r) / σ√2)]` of a pixel at distance x.
//! Evidence counts from none to [`FULL`] and no further, so the share is that over `FULL`, at most 1.

use crate::photo::evidence::share::FULL;
use crate::roots::diameter::bar::normal_below;

/// Steps of the table per standard deviation, and its end.
const STEPS: f32 = 64.0;
const END: f32 = 6.0;
/// Steps of the areas' table, px, and its end.
const AREA_STEP_PX: f32 = 0.05;
const AREA_END_PX: f32 = 40.0;

/// Covers for one point spread.
#[derive(Debug, Clone)]
pub struct Cover {
    /// Point spread, px.
    spread_px: f32,
    /// Distribution of the normal law at multiples of 1 / STEPS.
    normal: Vec<f32>,
    /// Sum of the share across tubes of radius k · AREA_STEP_PX, px.
    areas: Vec<f32>,
}

impl Cover {
    /// Covers for the point spread, px.
    pub fn new(spread_px: f64) -> Self {
        let table = (0..=(STEPS * END) as usize).map(|k| normal_below(k as f64 / f64::from(STEPS)) as f32).collect();
        let mut cover = Self { spread_px: spread_px.max(0.1) as f32, normal: table, areas: Vec::new() };
        let area = |radius: f32| -> f32 {
            let step = 0.1;
            let n = ((radius + 4.0 * cover.spread_px) / step) as i32;
            (-n..=n).map(|k| step * cover.share(k as f32 * step, radius)).sum()
        };
        cover.areas = (0..(AREA_END_PX / AREA_STEP_PX) as usize).map(|k| area(k as f32 * AREA_STEP_PX)).collect();
        cover
    }

    fn below(&self, x: f32) -> f32 {
        let upper = self.normal.get((x.abs() * STEPS) as usize).copied().unwrap_or(1.0);
        if x < 0.0 { 1.0 - upper } else { upper }
    }

    /// Share, 0..1, at a distance across a tube of that radius, px.
    pub fn share(&self, across_px: f32, radius_px: f32) -> f32 {
        let s = self.spread_px.recip();
        let covered = self.below((across_px + radius_px) * s) - self.below((across_px - radius_px) * s);
        (covered / FULL).min(1.0)
    }

    /// How far from the middle of a tube it gives a share, px.
    pub fn reach_px(&self, radius_px: f32) -> f32 {
        radius_px + 2.0 * self.spread_px
    }

    /// Radius, px, of the tube whose shares across sum up to `area_px`.
    pub fn radius_px(&self, area_px: f32) -> f32 {
        self.areas.partition_point(|&area| area < area_px) as f32 * AREA_STEP_PX
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sum_across_gives_the_radius_back() {
        for spread in [0.3, 0.6, 1.5] {
            let cover = Cover::new(spread);
            for radius in [0.3_f32, 0.8, 2.0, 7.5] {
                let area: f32 = (-400..=400).map(|k| 0.05 * cover.share(k as f32 * 0.05, radius)).sum();
                assert!((cover.radius_px(area) - radius).abs() < 0.11, "{spread} {radius} {}", cover.radius_px(area));
            }
        }
    }

    #[test]
    fn a_wide_tube_is_full_within_and_nothing_beyond() {
        let cover = Cover::new(0.6);
        assert_eq!(cover.share(0.0, 3.0), 1.0);
        assert_eq!(cover.share(2.5, 3.0), 1.0);
        assert!(cover.share(3.0 + 3.0 * 0.6, 3.0) < 0.01);
        assert!(cover.share(0.0, 0.1) < 0.25, "a thin one fills no pixel");
    }
}
