//! Contrast of a photograph against its local background: what is left when room, veil and reflections
//! of large extent are taken away.
//!
//! The photograph shows roots before a room whose brightness differs by view and place, and the merge
//! asks all views for one value per point. So the background is removed first: per channel the median
//! of the clear pixels (those that look into the water, [`clear`]) in a window several roots wide, which steps in the
//! background pass and roots do not as long as they fill less than half of it. The window is reduced
//! to about 16 blocks across (block means), the medians are interpolated between block centres. The
//! difference is then smoothed by a Gaussian over the clear pixels alone (normalised convolution):
//! noise below the width of the thinnest roots is averaged away.
//!
//! The picture is an undistorted photograph, `view` has its ideal lens. A length at the tank's axis in
//! pixels is `focal_px * length / distance`.

pub mod axis;
pub mod clear;
pub mod feature;
mod median;

use super::{Depth, Photograph};
use crate::error::{Error, Result};
use crate::optics::{Tank, View};
use ndarray::{Array2, Array3, ArrayView2, Axis, Zip};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of the contrast.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContrastParams {
    /// Merge the contrast against the background instead of the photographs' colours. `false` is the paper's way.
    pub enabled: bool,
    /// Edge of the background's window, mm at the tank's axis, 2..100. Several times the thickest root,
    /// so that no root fills half of it.
    pub window_mm: f64,
    /// Standard deviation of the smoothing, mm at the tank's axis, 0..5; well below the radius of the
    /// thinnest roots (0.25 mm), so that it takes the noise of fine photographs and leaves roots. Coarser
    /// averaging is the rendering's.
    pub blur_mm: f64,
}

impl Default for ContrastParams {
    fn default() -> Self {
        Self { enabled: true, window_mm: 15.0, blur_mm: 0.15 }
    }
}

impl ContrastParams {
    /// Fails where a parameter is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        if !(2.0..=100.0).contains(&self.window_mm) {
            faults.push(
                Error::usage(format!("contrast.window_mm is {}", self.window_mm))
                    .help("give 2 to 100 mm, several times the thickest root"),
            );
        }
        if !(0.0..=5.0).contains(&self.blur_mm) {
            faults.push(
                Error::usage(format!("contrast.blur_mm is {}", self.blur_mm))
                    .help("give 0 to 5 mm, less than the thinnest root's diameter"),
            );
        }
        Error::many(faults)
    }
}

/// A photograph's contrast.
#[derive(Debug, Clone, PartialEq)]
pub struct Contrast {
    /// (y, x, rgb) photograph minus background, smoothed, in codes of 0..255; 0 where not clear.
    pub values: Array3<f32>,
    /// (y, x): pixels that look into the water.
    pub clear: Array2<bool>,
}

/// Half the number of blocks across the window.
const HALF_WINDOW: usize = 8;

/// Contrast of an undistorted photograph, in the photograph's own depth.
///
/// # Errors
/// Where a parameter is out of range or the photograph is not of the lens's size.
pub fn contrast(photo: &Photograph, view: &View, tank: &Tank, params: &ContrastParams) -> Result<Contrast> {
    match photo {
        Photograph::Eight(codes) => contrast_in(codes, view, tank, params),
        Photograph::Sixteen(steps) => contrast_in(steps, view, tank, params),
    }
}

fn contrast_in<T: Depth>(photo: &Array3<T>, view: &View, tank: &Tank, params: &ContrastParams) -> Result<Contrast> {
    params.check()?;
    let (height, width, _) = photo.dim();
    if (height, width) != (view.lens.height, view.lens.width) {
        return Err(Error::failed(format!(
            "contrast: photograph of {width} x {height} px, lens of {} x {}",
            view.lens.width, view.lens.height
        ))
        .help("the lens must be that of the photograph"));
    }
    let centre = view.centre_in_tank();
    let px_per_mm = view.lens.focal_px / centre.x.hypot(centre.y);
    let clear = clear::clear_pixels(&view.ideal(), tank);
    let block = ((params.window_mm * px_per_mm / 2.0 / HALF_WINDOW as f64).round() as usize).max(1);
    let radius = ((params.window_mm * px_per_mm / 2.0 / block as f64).round() as usize).max(1);
    let planes: Vec<Array2<f32>> = (0..3usize)
        .into_par_iter()
        .map(|c| {
            let values = photo.index_axis(Axis(2), c);
            let (means, known) = block_means(values, &clear, block);
            let per_code = f32::from(T::STEPS);
            let background = median::median(means.view(), known.view(), radius) / per_code;
            let mut plane = Array2::zeros((height, width));
            for ((y, x), value) in plane.indexed_iter_mut() {
                if clear[[y, x]] {
                    *value = f32::from(values[[y, x]].steps()) / per_code - between(&background, y, x, block);
                }
            }
            plane
        })
        .collect();
    let weight = smooth(&clear.mapv(|c| f32::from(u8::from(c))), params.blur_mm * px_per_mm);
    let mut values = Array3::zeros((height, width, 3));
    for (c, plane) in planes.iter().enumerate() {
        let smoothed = smooth(plane, params.blur_mm * px_per_mm);
        Zip::from(values.index_axis_mut(Axis(2), c)).and(&smoothed).and(&weight).and(&clear).for_each(
            |out, &sum, &weight, &clear| {
                if clear && weight > 0.0 {
                    *out = sum / weight;
                }
            },
        );
    }
    Ok(Contrast { values, clear })
}

/// Mean of the clear pixels of every block, to the nearest step, and whether a block has any.
fn block_means<T: Depth>(values: ArrayView2<T>, clear: &Array2<bool>, block: usize) -> (Array2<T>, Array2<bool>) {
    let (height, width) = values.dim();
    let shape = (height.div_ceil(block), width.div_ceil(block));
    let mut means = Array2::from_elem(shape, T::default());
    let mut known = Array2::from_elem(shape, false);
    for ((by, bx), mean) in means.indexed_iter_mut() {
        let (mut sum, mut count) = (0u64, 0u64);
        for y in by * block..((by + 1) * block).min(height) {
            for x in bx * block..((bx + 1) * block).min(width) {
                if clear[[y, x]] {
                    sum += u64::from(values[[y, x]].steps());
                    count += 1;
                }
            }
        }
        if let Some(rounded) = (sum + count / 2).checked_div(count) {
            *mean = T::nearest(rounded as f32);
            known[[by, bx]] = true;
        }
    }
    (means, known)
}

/// The blocks' value at pixel (y, x), bilinear between block centres over those that have one.
fn between(blocks: &Array2<f32>, y: usize, x: usize, block: usize) -> f32 {
    let at = |p: usize, n: usize| {
        let t = ((p as f32 + 0.5) / block as f32 - 0.5).clamp(0.0, (n - 1) as f32);
        let low = (t as usize).min(n.saturating_sub(2));
        (low, t - low as f32)
    };
    let ((v, fv), (u, fu)) = (at(y, blocks.nrows()), at(x, blocks.ncols()));
    let (mut sum, mut weight) = (0.0, 0.0);
    for (dv, wv) in [(0, 1.0 - fv), (1, fv)] {
        for (du, wu) in [(0, 1.0 - fu), (1, fu)] {
            if let Some(&value) = blocks.get([v + dv, u + du]).filter(|value| !value.is_nan()) {
                // A trace of weight keeps a lone known block usable where its share is 0.
                let w = wv * wu + 1e-6;
                sum += w * value;
                weight += w;
            }
        }
    }
    if weight > 0.0 { sum / weight } else { blocks[[y / block, x / block]] }
}

/// Gaussian smoothing with kernel radius ceil(3σ) and zeros beyond the border; unchanged at σ = 0.
fn smooth(plane: &Array2<f32>, sigma_px: f64) -> Array2<f32> {
    let radius = (3.0 * sigma_px).ceil() as usize;
    if radius == 0 {
        return plane.clone();
    }
    let g: Vec<f32> = (0..=radius).map(|x| (-0.5 * (x as f64 / sigma_px).powi(2)).exp() as f32).collect();
    let total = g[0] + 2.0 * g[1..].iter().sum::<f32>();
    let g: Vec<f32> = g.iter().map(|x| x / total).collect();
    let (height, width) = plane.dim();
    let mut along_x = Array2::<f32>::zeros((height + 2 * radius, width));
    let mut padded = vec![0.0; width + 2 * radius];
    for (row, mut out) in plane.rows().into_iter().zip(along_x.rows_mut().into_iter().skip(radius)) {
        padded[radius..radius + width].iter_mut().zip(row).for_each(|(p, &v)| *p = v);
        for x in 0..width {
            let mut sum = g[0] * padded[radius + x];
            for r in 1..=radius {
                sum += g[r] * (padded[radius + x - r] + padded[radius + x + r]);
            }
            out[x] = sum;
        }
    }
    let mut out = Array2::zeros((height, width));
    for (y, mut row) in out.rows_mut().into_iter().enumerate() {
        for x in 0..width {
            let mut sum = g[0] * along_x[[radius + y, x]];
            for r in 1..=radius {
                sum += g[r] * (along_x[[radius + y - r, x]] + along_x[[radius + y + r, x]]);
            }
            row[x] = sum;
        }
    }
    out
}

#[cfg(test)]
mod tests;
