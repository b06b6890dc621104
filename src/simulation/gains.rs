//! How bright each photograph comes out, per channel: exposure that jumps, exposure and white balance that drift, views
//! in another light.
//!
//! A drift is a random walk over the views, shifted and scaled to mean 0 and the standard deviation asked for; the gain is
//! its exponential.

use super::CaptureParams;
use super::noise::{hash, normal_pair};

/// Gains of linear light (red, green, blue), one per view.
pub fn gains(params: &CaptureParams, views: usize, seed: u64) -> Vec<[f64; 3]> {
    let exposure = walk(views, hash(seed, &[71, 0]));
    let (red, blue) = (walk(views, hash(seed, &[71, 1])), walk(views, hash(seed, &[71, 2])));
    let balance = params.white_balance_walk;
    (0..views)
        .map(|i| {
            let jump = (params.exposure_drift * normal_pair(hash(seed, &[31, i as u64])).0).exp();
            let drift = (params.exposure_walk * exposure[i]).exp();
            let colour = [(balance * red[i]).exp(), 1.0, (balance * blue[i]).exp()];
            let light = params.other_light.iter().find(|l| l.views.contains(&i)).map_or([1.0; 3], |l| l.gain);
            [0, 1, 2].map(|k| jump * drift * colour[k] * light[k])
        })
        .collect()
}

/// A random walk of that many steps with mean 0 and standard deviation 1; all zero for a single step.
fn walk(steps: usize, seed: u64) -> Vec<f64> {
    let mut at = 0.0;
    let mut path: Vec<f64> = (0..steps as u64)
        .map(|i| {
            at += normal_pair(hash(seed, &[i])).0;
            at
        })
        .collect();
    let mean = path.iter().sum::<f64>() / path.len().max(1) as f64;
    path.iter_mut().for_each(|x| *x -= mean);
    let sd = (path.iter().map(|x| x * x).sum::<f64>() / path.len().max(1) as f64).sqrt();
    if sd > 0.0 {
        path.iter_mut().for_each(|x| *x /= sd);
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::OtherLight;

    #[test]
    fn drifts_are_slow_and_as_large_as_asked_for() {
        let params = CaptureParams { exposure_walk: 0.2, ..Default::default() };
        let logs: Vec<f64> = gains(&params, 40, 3).iter().map(|g| g[0].ln()).collect();
        let sd = (logs.iter().map(|x| x * x).sum::<f64>() / 40.0).sqrt();
        let step = (logs.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / 39.0).sqrt();
        assert!((sd - 0.2).abs() < 1e-9 && step < 0.12, "{sd} {step}");
        let params = CaptureParams { white_balance_walk: 0.1, ..Default::default() };
        for k in 0..3 {
            let logs: Vec<f64> = gains(&params, 40, 3).iter().map(|g| g[k].ln()).collect();
            let sd = (logs.iter().map(|x| x * x).sum::<f64>() / 40.0).sqrt();
            assert!((sd - if k == 1 { 0.0 } else { 0.1 }).abs() < 1e-9, "{k} {sd}");
        }
        assert_eq!(gains(&CaptureParams { exposure_walk: 0.2, ..Default::default() }, 1, 3), [[1.0; 3]]);
    }

    #[test]
    fn views_in_another_light_have_its_gain_and_no_other() {
        let light = OtherLight { views: vec![0, 3], gain: [1.5, 1.2, 0.8], lamp_direction: None };
        let params = CaptureParams { other_light: vec![light], ..Default::default() };
        let gains = gains(&params, 5, 1);
        for (i, gain) in gains.iter().enumerate() {
            assert_eq!(*gain, if i % 3 == 0 { [1.5, 1.2, 0.8] } else { [1.0; 3] });
        }
    }
}
