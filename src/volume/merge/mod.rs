//! Merging the views of each voxel into one colour, robustly.  Paper 2.4.
//!
//! In: of every view a slab (z, y, x, 4) u8, red, green, blue and a mask (0 = the view does not see the
//! voxel). Out, on the same slab: the colour (z, y, x, 3) f32 in 0..1, NaN where fewer than `min_views`
//! views see the voxel; the coverage (views that see it, at most 255 are told); the residual, the mean
//! distance of the views' colours to the estimate in the metric of the estimate (NaN as the colour).
//!
//! Voxels are independent: a slab needs no halo, and any cut into slabs gives the same bits.
//!
//! | estimator | minimises | breaks down at |
//! |---|---|---|
//! | mean | Σ \|x - c\|² | one view |
//! | geometric-median | Σ \|x - c\|, the paper's | half of the views, whatever their colours |
//! | median | Σ \|x - c\| per channel | half of the views; not invariant to a turn of the colour axes |
//! | quantile q | the tilted Σ \|x - c\| per channel | a share min(q, 1-q) of views on the nearer side |
//! | low-mean q | Σ (x - c)² per channel over the lowest share q of the views | 1-q too bright, q too dark |
//!
//! A root is seen as root by nearly all views; empty water is seen as root by those views that have a
//! root before or behind it. Where roots stand out brightly against their background, the low end of
//! the views' values therefore tells roots from water when the median no longer does; the mean of
//! that end is as selective as a quantile and less noisy. The share q must leave room for views that
//! do not fit (a root that moved, a dark crossing): they dilute the mean, they do not decide it.

// Lanes read best by index.
#![allow(clippy::needless_range_loop)]

mod evidence;
mod geometric;
mod order;

use crate::error::{Error, Result};
use crate::photo::colour::{lab_of_srgb, srgb_of_lab};
pub use evidence::merge_evidence;
use ndarray::{Array3, Array4, ArrayView4, Axis};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Voxels worked on abreast.
pub(crate) const LANES: usize = 16;

/// Values of a [`Bundle`] per unit of the estimate's colour: those of the photographs' bytes, so that sums are exact.
const UNIT: f32 = 255.0;

/// One value per lane.
pub(crate) type Lane = [f32; LANES];

/// How one colour is made of many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Estimator {
    /// Minimiser of the summed distances, the paper's L1 estimator.
    GeometricMedian,
    /// Minimiser of the summed squares, the paper's L2 estimator (figure 9).
    Mean,
    /// Median of each channel.
    Median,
    /// Quantile of each channel, linear between order statistics.
    Quantile,
    /// Mean of the lowest values of each channel, the share `quantile` of the views that see the voxel.
    LowMean,
}

/// The space in which distances between colours are taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// sRGB as encoded, 0..1.
    Rgb,
    /// CIE L*a*b* (D65) over 100, so that black to white is 1 as in RGB.
    Lab,
}

/// Parameters of the merge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Merge {
    /// geometric-median (paper 2.4), mean, median, quantile or low-mean.
    pub estimator: Estimator,
    /// rgb (the paper's) or lab (its figure 9 found no evident difference).
    pub metric: Metric,
    /// Which quantile, or the share of views in the low mean, 0..1; read by these estimators alone.
    pub quantile: f32,
    /// The geometric median stops when the estimate moves less than this (RGB 0..1). 1e-3 is a quarter
    /// of one step of an 8-bit photograph.
    pub tolerance: f32,
    /// The geometric median stops after this many steps at the latest, 1..10000.
    pub max_steps: usize,
    /// Voxels seen by fewer views stay unknown, 1..255. Three views are the fewest whose median can
    /// outvote one wrong view.
    pub min_views: usize,
}

impl Default for Merge {
    fn default() -> Self {
        Self {
            estimator: Estimator::LowMean,
            metric: Metric::Rgb,
            quantile: 0.2,
            tolerance: 1e-3,
            max_steps: 200,
            min_views: 3,
        }
    }
}

impl Merge {
    /// Fails where a parameter is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        if !(0.0..=1.0).contains(&self.quantile) {
            faults.push(
                Error::usage(format!("merge.quantile is {}", self.quantile)).help("quantiles lie between 0 and 1"),
            );
        }
        if !(self.tolerance > 0.0 && self.tolerance < 1.0) {
            faults.push(
                Error::usage(format!("merge.tolerance is {}", self.tolerance))
                    .help("give a positive distance between colours of 0..1, such as 1e-3"),
            );
        }
        if !(1..=10_000).contains(&self.max_steps) {
            faults.push(Error::usage(format!("merge.max_steps is {}", self.max_steps)).help("give 1 to 10000"));
        }
        if !(1..=255).contains(&self.min_views) {
            faults.push(Error::usage(format!("merge.min_views is {}", self.min_views)).help("give 1 to 255"));
        }
        Error::many(faults)
    }
}

/// The merged slab.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged {
    /// (z, y, x, rgb), or (z, y, x, 1) of shares of root; 0..1, NaN = unknown.
    pub colour: Array4<f32>,
    /// (z, y, x): views that see the voxel.
    pub coverage: Array3<u8>,
    /// (z, y, x): mean distance of the views to the estimate, NaN = unknown.
    pub residual: Array3<f32>,
}

/// The views of `LANES` voxels, one entry per view: three channels (times [`UNIT`]) and the mask as 0 or 1.
pub(crate) struct Bundle {
    pub(crate) channel: [Vec<Lane>; 3],
    pub(crate) mask: Vec<Lane>,
}

/// Merges the same slab of every view.
///
/// # Errors
/// Where a parameter is out of range, no view is given, or the views' shapes differ.
pub fn merge(views: &[ArrayView4<u8>], params: &Merge) -> Result<Merged> {
    let [nz, ny, nx] = checked_shape(views, params)?;
    let mut colour = Array4::from_elem((nz, ny, nx, 3), f32::NAN);
    let mut coverage = Array3::zeros((nz, ny, nx));
    let mut residual = Array3::from_elem((nz, ny, nx), f32::NAN);
    colour
        .axis_iter_mut(Axis(0))
        .into_par_iter()
        .zip(coverage.axis_iter_mut(Axis(0)))
        .zip(residual.axis_iter_mut(Axis(0)))
        .enumerate()
        .for_each(|(k, ((mut colour, mut coverage), mut residual))| {
            let lanes = || vec![[0.0; LANES]; views.len()];
            let mut bundle = Bundle { channel: [lanes(), lanes(), lanes()], mask: lanes() };
            for j in 0..ny {
                for from in (0..nx).step_by(LANES) {
                    let width = LANES.min(nx - from);
                    let count = bundle.fill(views, k, j, from, width, params.metric);
                    let known = count.map(|n| n >= params.min_views as f32);
                    for i in 0..width {
                        coverage[[j, from + i]] = count[i].min(255.0) as u8;
                    }
                    if !known.contains(&true) {
                        continue;
                    }
                    let estimate = match params.estimator {
                        Estimator::GeometricMedian => {
                            geometric::median(&bundle, &count, &known, params.tolerance * UNIT, params.max_steps)
                        }
                        Estimator::Mean => bundle.mean(&count),
                        Estimator::Median => order::per_channel(&bundle, &count, |v| order::quantile(v, 0.5)),
                        Estimator::Quantile => {
                            order::per_channel(&bundle, &count, |v| order::quantile(v, params.quantile))
                        }
                        Estimator::LowMean => {
                            order::per_channel(&bundle, &count, |v| order::low_mean(v, params.quantile))
                        }
                    };
                    let spread = bundle.mean_distance(&estimate, &count);
                    for i in (0..width).filter(|&i| known[i]) {
                        let c = [0, 1, 2].map(|c| estimate[c][i] / UNIT);
                        let rgb = match params.metric {
                            Metric::Rgb => c,
                            Metric::Lab => srgb_of_lab(c.map(|x| x * 100.0)),
                        };
                        for (channel, value) in rgb.into_iter().enumerate() {
                            colour[[j, from + i, channel]] = value;
                        }
                        residual[[j, from + i]] = spread[i] / UNIT;
                    }
                }
            }
        });
    Ok(Merged { colour, coverage, residual })
}

/// Planes, rows and columns of the views' slabs.
fn checked_shape(views: &[ArrayView4<u8>], params: &Merge) -> Result<[usize; 3]> {
    params.check()?;
    let Some(first) = views.first() else {
        return Err(Error::failed("merge: no view given").help("at least one photograph is needed"));
    };
    let shape = first.shape();
    for (l, view) in views.iter().enumerate() {
        if view.shape() != shape || shape[3] != 4 {
            return Err(Error::failed(format!(
                "merge: view {l} has shape {:?}, view 0 {shape:?}; (z, y, x, 4) expected of all",
                view.shape()
            )));
        }
    }
    Ok([shape[0], shape[1], shape[2]])
}

impl Bundle {
    /// Loads `width` voxels of row (k, j) from `from` on and returns how many views see each.
    fn fill(
        &mut self,
        views: &[ArrayView4<u8>],
        k: usize,
        j: usize,
        from: usize,
        width: usize,
        metric: Metric,
    ) -> Lane {
        let mut count = [0.0; LANES];
        for (l, view) in views.iter().enumerate() {
            let mut rgb = [[0.0; LANES]; 3];
            let mut mask = [0.0; LANES];
            for i in 0..width {
                if view[[k, j, from + i, 3]] != 0 {
                    mask[i] = 1.0;
                    for c in 0..3 {
                        rgb[c][i] = f32::from(view[[k, j, from + i, c]]);
                    }
                    if metric == Metric::Lab {
                        let lab = lab_of_srgb([0, 1, 2].map(|c| rgb[c][i] / UNIT));
                        for c in 0..3 {
                            rgb[c][i] = lab[c] / 100.0 * UNIT;
                        }
                    }
                }
                count[i] += mask[i];
            }
            for c in 0..3 {
                self.channel[c][l] = rgb[c];
            }
            self.mask[l] = mask;
        }
        count
    }

    /// Mean colour; 0 where no view sees the voxel.
    fn mean(&self, count: &Lane) -> [Lane; 3] {
        let mut sum = [[0.0; LANES]; 3];
        for l in 0..self.mask.len() {
            for c in 0..3 {
                for i in 0..LANES {
                    sum[c][i] += self.channel[c][l][i] * self.mask[l][i];
                }
            }
        }
        for channel in &mut sum {
            for i in 0..LANES {
                channel[i] /= count[i].max(1.0);
            }
        }
        sum
    }

    fn mean_distance(&self, estimate: &[Lane; 3], count: &Lane) -> Lane {
        let mut sum = [0.0; LANES];
        for l in 0..self.mask.len() {
            for i in 0..LANES {
                let [r, g, b] = [0, 1, 2].map(|c| self.channel[c][l][i] - estimate[c][i]);
                sum[i] += self.mask[l][i] * (r * r + g * g + b * b).sqrt();
            }
        }
        for i in 0..LANES {
            sum[i] /= count[i].max(1.0);
        }
        sum
    }
}

#[cfg(test)]
mod tests;
