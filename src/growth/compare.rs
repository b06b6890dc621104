//! Groups of plants side by side: how much they differ, how sure that is, and which plant is unlike its group.
//!
//! The ratio of two means has the interval of its logarithm by the delta method with Welch's degrees of freedom:
//! `ln(m₂/m₁) ± t √(s₁²/(n₁m₁²) + s₂²/(n₂m₂²))`. The standardised difference is Hedges' g: the difference of means over the
//! pooled standard deviation, corrected for small samples. A value is odd where it lies over 3.5 robust standard deviations
//! (1.4826 · median absolute deviation) from the median of its group (Iglewicz and Hoaglin 1993).

use crate::math::robust::{median, spread};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Robust standard deviations beyond which a value is odd.
pub const ODD: f64 = 3.5;
/// Fewer plants of a group say nothing of what is usual in it.
const LEAST: usize = 4;
/// Robust standard deviations are taken as this share of the median at least.
const LEAST_SPREAD: f64 = 0.1;

/// Two groups against each other in one number per plant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Effect {
    /// Plants of the group that is compared with, and of the other.
    pub count: [usize; 2],
    /// Their means.
    pub mean: [f64; 2],
    /// Their standard deviations.
    pub sd: [f64; 2],
    /// The second mean over the first, minus 1; NaN where the means are not both above 0.
    pub change: f64,
    /// 95 % interval of the change.
    pub interval: [f64; 2],
    /// Hedges' g.
    pub hedges_g: f64,
}

/// Compares the values of two groups; NaN values are left out. `None` where a group has fewer than two.
pub fn effect(reference: &[f64], other: &[f64]) -> Option<Effect> {
    let [a, b] = [reference, other].map(|v| v.iter().copied().filter(|x| x.is_finite()).collect::<Vec<f64>>());
    if a.len() < 2 || b.len() < 2 {
        return None;
    }
    let (count, n) = ([a.len(), b.len()], [a.len() as f64, b.len() as f64]);
    let mean = [&a, &b].map(|v| v.iter().sum::<f64>() / v.len() as f64);
    let variance = |v: &[f64], m: f64| v.iter().map(|x| (x - m) * (x - m)).sum::<f64>() / (v.len() as f64 - 1.0);
    let var = [variance(&a, mean[0]), variance(&b, mean[1])];
    let pooled = (((n[0] - 1.0) * var[0] + (n[1] - 1.0) * var[1]) / (n[0] + n[1] - 2.0)).sqrt();
    let small = 1.0 - 3.0 / (4.0 * (n[0] + n[1]) - 9.0);
    let hedges_g = if pooled > 0.0 { (mean[1] - mean[0]) / pooled * small } else { f64::NAN };
    let sd = var.map(f64::sqrt);
    let (mut change, mut interval) = (f64::NAN, [f64::NAN; 2]);
    if mean.iter().all(|m| *m > 0.0) {
        let part = [0, 1].map(|k| var[k] / (n[k] * mean[k] * mean[k]));
        let (spread, log) = ((part[0] + part[1]).sqrt(), (mean[1] / mean[0]).ln());
        let freedom = (part[0] + part[1]).powi(2) / (part[0].powi(2) / (n[0] - 1.0) + part[1].powi(2) / (n[1] - 1.0));
        change = log.exp_m1();
        interval = match StudentsT::new(0.0, 1.0, freedom) {
            Ok(t) => {
                let reach = t.inverse_cdf(0.975) * spread;
                [(log - reach).exp_m1(), (log + reach).exp_m1()]
            }
            // Groups without any spread.
            Err(_) => [change; 2],
        };
    }
    Some(Effect { count, mean, sd, change, interval, hedges_g })
}

/// How many robust standard deviations each value lies from the median of all; NaN for values that are none, 0 throughout
/// where there are too few.
pub fn oddness(values: &[f64]) -> Vec<f64> {
    let sound: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    if sound.len() < LEAST {
        return vec![0.0; values.len()];
    }
    let middle = median(&mut sound.clone());
    // A third more or less is no oddity, however alike a few others are.
    let spread = spread(sound.iter().map(|x| x - middle)).max(LEAST_SPREAD * middle.abs());
    values.iter().map(|x| if spread > 0.0 { (x - middle) / spread } else { 0.0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_groups_are_compared_as_r_does() {
        // R: t.test(log-ratio by the delta method); g by effsize::cohen.d(hedges.correction = TRUE).
        let e = effect(&[10.0, 11.0, 9.0, 10.5, 9.5], &[12.0, 13.0, 11.0, 12.5, 11.5, f64::NAN]).unwrap();
        assert_eq!(e.count, [5, 5]);
        assert!((e.change - 0.2).abs() < 1e-12 && (e.sd[0] - 0.790_569).abs() < 1e-6);
        assert!((e.hedges_g - 2.0 / 0.790_569_4 * (1.0 - 3.0 / 31.0)).abs() < 1e-6);
        // Spread of the logarithm 0.04602, 7.737 degrees of freedom, t = 2.3200.
        let spread = (0.625f64 / 500.0 + 0.625 / 720.0).sqrt();
        let reach = (1.2f64.ln() - e.interval[0].ln_1p()) / spread;
        assert!((reach - 2.320).abs() < 2e-3, "{reach}");
        assert!(effect(&[1.0], &[1.0, 2.0]).is_none());
        assert!(effect(&[-1.0, 1.0], &[1.0, 2.0]).unwrap().change.is_nan());
        assert_eq!(effect(&[1.0, 1.0], &[2.0, 2.0]).unwrap().interval, [1.0, 1.0]);
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let draw = |seed: u64, mean: f64| -> Vec<f64> {
            let uniform = |k: u64| {
                let x = (seed * 977 + k * 7919 + 13).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                ((x ^ (x >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9) >> 11) as f64 / (1u64 << 53) as f64
            };
            (0..6).map(|n| mean * (0.7 + 0.05 * (0..12).map(|k| uniform(n * 12 + k)).sum::<f64>())).collect()
        };
        let holds = |seed: u64| {
            let e = effect(&draw(2 * seed, 10.0), &draw(2 * seed + 1, 12.0)).unwrap();
            e.interval[0] <= 0.2 && 0.2 <= e.interval[1]
        };
        let held = (0..400).filter(|&seed| holds(seed)).count();
        assert!((365..=396).contains(&held), "{held} of 400");
    }

    #[test]
    fn one_unlike_the_others_is_odd() {
        let odd = oddness(&[10.0, 11.0, 9.0, 10.0, 30.0, f64::NAN]);
        assert!(odd[4] > ODD && odd[0].abs() < 1.0 && odd[5].is_nan());
        assert_eq!(oddness(&[1.0, 2.0, 90.0]), [0.0; 3]);
        // Nine roots where all others have eight.
        assert!(oddness(&[8.0, 8.0, 8.0, 8.0, 8.0, 9.0])[5] < ODD);
    }
}
