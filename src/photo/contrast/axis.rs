//! The colour axis on which roots differ from their background, learned from the photographs.
//!
//! Roots may be brighter than the room, darker, or of its brightness but another colour. Among the
//! contrasts of all clear pixels, noise is the inner half: its covariance N is estimated robustly by
//! repeated trimming at the median Mahalanobis distance (corrected by 0.4069, the share of its variance that
//! a 3-D normal distribution keeps inside its median distance). Pixels farther than
//! `significance` noise deviations are something: roots, for the most part, since the background is
//! gone. With μ and S their mean and covariance, Fisher's discriminant w = (N + S)⁻¹ μ is the axis
//! that sets them best apart from noise, for what they vary in (shading, say) as well; its sign is
//! that of roots by w·μ > 0. It is scaled so that noise has unit deviation: features are in units
//! of the photographs' own noise.

use super::Contrast;
use crate::error::{Error, Result};
use crate::optics::{Mat3, Vec3};
use crate::photo::colour::GRAY;
use serde::{Deserialize, Serialize};

/// Pixels that one photograph gives, at most.
const SAMPLES: usize = 12_000;
/// Variance that the inner half of a 3-D normal distribution keeps.
const INNER_HALF: f64 = 0.406_939_47;
/// Fewer significant pixels than this share are not trusted to be roots.
const LEAST_SHARE: f64 = 1e-4;
/// Deviations from the background that make a pixel significant: one in 65 000 of pure noise.
pub const SIGNIFICANCE: f64 = 5.0;
/// A pixel counts when it is clear so many pixels around: the border's contrast is half water, half wall.
const MARGIN_PX: usize = 4;

/// The axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ColourAxis {
    /// Feature per code of contrast in R, G, B: noise deviations, in steps of 1/`STEPS` of the greatest's octave, so
    /// that a photograph exchanged among many usually leaves the axis, and with it the other views, alone.
    pub weights: [f64; 3],
}

/// Steps of an octave.
const STEPS: f64 = 32.0;

/// The axis and what it was learned from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Learned {
    /// The axis.
    pub axis: ColourAxis,
    /// Mean feature of the significant pixels, noise deviations.
    pub contrast: f64,
    /// Share of significant pixels among the clear ones.
    pub share: f64,
    /// Noise deviation of each channel's contrast, codes.
    pub noise_codes: [f64; 3],
}

impl Learned {
    /// Learns the axis from the [`samples`] of all photographs of a capture. Without significant pixels
    /// it is gray.
    ///
    /// # Errors
    /// Where there are hardly any samples.
    pub fn new(samples: impl IntoIterator<Item = [f32; 3]>) -> Result<Self> {
        let samples: Vec<Vec3> = samples.into_iter().map(|x| Vec3::from(x.map(f64::from))).collect();
        if samples.len() < 100 {
            return Err(Error::failed("no photograph shows the water")
                .help("check the tank's belts and height, and whether the cameras belong to the photographs"));
        }
        let mut noise = covariance(&samples, &Vec3::zeros());
        for _ in 0..20 {
            let mut distances = mahalanobis(&samples, &noise);
            let inner: Vec<Vec3> = {
                let mut sorted = distances.clone();
                let half = sorted.len() / 2;
                let median = *sorted.select_nth_unstable_by(half, f64::total_cmp).1;
                distances.drain(..).zip(&samples).filter(|(d, _)| *d < median).map(|(_, x)| *x).collect()
            };
            noise = covariance(&inner, &Vec3::zeros()) / INNER_HALF;
        }
        let significant: Vec<Vec3> = mahalanobis(&samples, &noise)
            .into_iter()
            .zip(&samples)
            .filter(|(d, _)| *d > SIGNIFICANCE * SIGNIFICANCE)
            .map(|(_, x)| *x)
            .collect();
        let share = significant.len() as f64 / samples.len() as f64;
        let mean = significant.iter().sum::<Vec3>() / (significant.len().max(1) as f64);
        let direction = if share < LEAST_SHARE {
            Vec3::from(GRAY.map(f64::from))
        } else {
            (noise + covariance(&significant, &mean)).try_inverse().map_or(mean, |inverse| inverse * mean)
        };
        let weights = direction / (direction.transpose() * noise * direction)[0].sqrt().max(1e-12);
        Ok(Self {
            axis: ColourAxis { weights: in_steps(weights).into() },
            contrast: weights.dot(&mean),
            share,
            noise_codes: [0, 1, 2].map(|c| noise[(c, c)].sqrt()),
        })
    }
}

impl Learned {
    /// Whether too few pixels stood out to learn from.
    pub fn is_gray(&self) -> bool {
        self.share < LEAST_SHARE
    }
}

/// Rounded to steps of the greatest weight's octave.
fn in_steps(weights: Vec3) -> Vec3 {
    let octave = weights.amax().log2().floor().exp2();
    if octave.is_finite() && octave > 0.0 {
        weights.map(|w| (w / octave * STEPS).round() / STEPS * octave)
    } else {
        weights
    }
}

/// Contrasts (R, G, B) of up to `SAMPLES` clear pixels of a photograph, evenly spread over those that are clear around.
pub fn samples(photograph: &Contrast) -> Vec<[f32; 3]> {
    let clear = &photograph.clear;
    let (height, width) = clear.dim();
    let inner = |(y, x): (usize, usize)| {
        (MARGIN_PX..height.saturating_sub(MARGIN_PX)).contains(&y)
            && (MARGIN_PX..width.saturating_sub(MARGIN_PX)).contains(&x)
            && clear[[y, x]]
            && clear[[y - MARGIN_PX, x]]
            && clear[[y + MARGIN_PX, x]]
            && clear[[y, x - MARGIN_PX]]
            && clear[[y, x + MARGIN_PX]]
    };
    let pixels: Vec<(usize, usize)> = clear.indexed_iter().map(|(at, _)| at).filter(|&at| inner(at)).collect();
    let step = pixels.len().div_ceil(SAMPLES).max(1);
    pixels.into_iter().step_by(step).map(|(y, x)| [0, 1, 2].map(|c| photograph.values[[y, x, c]])).collect()
}

/// Covariance about `mean`; never singular: rounding to codes leaves at least 1/12.
fn covariance(samples: &[Vec3], mean: &Vec3) -> Mat3 {
    let sum: Mat3 = samples.iter().map(|x| (x - mean) * (x - mean).transpose()).sum();
    sum / (samples.len().max(1) as f64) + Mat3::identity() / 12.0
}

/// Squared distances from 0 in units of `covariance`.
fn mahalanobis(samples: &[Vec3], covariance: &Mat3) -> Vec<f64> {
    let inverse = covariance.try_inverse().unwrap_or_else(Mat3::identity);
    samples.iter().map(|x| (x.transpose() * inverse * x)[0]).collect()
}
