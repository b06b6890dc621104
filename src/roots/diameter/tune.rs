//! Point spread and fall of light towards the limbs, from the photographs themselves.
//!
//! Both change the width that fits best, and both differ from camera to camera and room to room. On a sample of
//! stations every combination of [`SPREADS`] and [`LIMBS`] is fitted at the widths about the one that is expected; the combination
//! with the least sum of `n ln RSS`, each photograph's rise above its own least limited, is taken.

use super::bar::Bars;
use super::profile::Profile;
use super::width::{LIMIT, fit};
use rayon::prelude::*;

/// Point spreads tried, as multiples of the one that is expected. No wider ones: they would take up the veil and the
/// neighbours beside a root, at the cost of its width.
const SPREADS: [f64; 4] = [0.5, 0.7, 1.0, 1.4];
/// Falls of light tried.
const LIMBS: [f64; 3] = [0.0, 0.5, 1.0];
/// Widths tried, as multiples of the one that is expected.
const WIDTHS: [f64; 7] = [0.72, 0.8, 0.9, 1.0, 1.12, 1.25, 1.4];

/// The bars that fit the sampled profiles (with the expected diameter, mm) best; `bars` itself for an empty sample.
pub fn tune(samples: &[(Vec<Profile>, f64)], bars: Bars) -> Bars {
    let tried: Vec<Bars> = SPREADS
        .iter()
        .flat_map(|s| LIMBS.iter().map(move |l| (s, l)))
        .map(|(s, l)| Bars::new(s * bars.spread_px(), *l))
        .collect();
    let cost = |profile: &Profile, bars: &Bars, width_mm: f64| {
        profile.pixels.len() as f64 * fit(profile, 0.0, width_mm * profile.scale, bars).rss.ln()
    };
    let rises: Vec<Vec<f64>> = samples
        .par_iter()
        .map(|(profiles, expected)| {
            // Per profile the costs of all combinations at all widths, above its own least one.
            let mut total = vec![0.0; tried.len() * WIDTHS.len()];
            for profile in profiles {
                let costs: Vec<f64> =
                    tried.iter().flat_map(|t| WIDTHS.map(|w| cost(profile, t, w * expected))).collect();
                let least = costs.iter().copied().fold(f64::INFINITY, f64::min);
                total.iter_mut().zip(&costs).for_each(|(sum, cost)| *sum += (cost - least).min(LIMIT));
            }
            total.chunks(WIDTHS.len()).map(|c| c.iter().copied().fold(f64::INFINITY, f64::min)).collect()
        })
        .collect();
    let sum = |k: usize| rises.iter().map(|r| r[k]).sum::<f64>();
    let best = (0..tried.len()).filter(|_| !rises.is_empty()).min_by(|&a, &b| sum(a).total_cmp(&sum(b)));
    best.map_or(bars, |k| tried[k].clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Vec3;

    #[test]
    fn finds_the_light_that_made_the_profiles() {
        for (spread, limb) in [(0.4, 0.0), (0.56, 1.0), (0.28, 0.5)] {
            let truth = Bars::new(spread, limb);
            let profile = |view: i32| {
                let pixels = (0..80)
                    .map(|k| {
                        let x = 0.17 * f64::from(k) - 6.8;
                        let noise = (f64::from(k * 13 + view) * 12.9898).sin() * 43758.5453 % 1.0;
                        (x, 0.1 + 0.2 * truth.light_and_shade(x, 1.4 * 2.5).0 + 0.002 * noise)
                    })
                    .collect();
                Profile { pixels, scale: 2.5, across: Vec3::x(), half_px: 6.8 }
            };
            let samples = vec![((0..12).map(profile).collect::<Vec<_>>(), 1.4)];
            let found = tune(&samples, Bars::new(0.4, 0.5));
            assert!((found.spread_px() - spread).abs() < 1e-9 && (found.limb() - limb).abs() < 1e-9, "{spread} {limb}");
        }
    }
}
