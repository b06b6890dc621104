//! The background from the photograph itself: the median of a window several roots wide.
//!
//! Per channel the median of the clear pixels in a window around each pixel, which steps in the background pass and
//! roots do not as long as they fill less than half of it. The window is reduced to about 16 blocks across (block
//! means), the medians are interpolated between block centres.

use super::{Codes, median};
use ndarray::{Array2, Array3, Axis};
use rayon::prelude::*;

/// Half the number of blocks across the window.
const HALF_WINDOW: usize = 8;

/// Background (y, x, rgb) of the clear pixels of a photograph, 0 elsewhere; `window_px` is the window's edge.
pub fn background(codes: &Codes, clear: &Array2<bool>, window_px: f64) -> Codes {
    let (height, width, _) = codes.dim();
    let block = ((window_px / 2.0 / HALF_WINDOW as f64).round() as usize).max(1);
    let radius = ((window_px / 2.0 / block as f64).round() as usize).max(1);
    let planes: Vec<Array2<f32>> = (0..3usize)
        .into_par_iter()
        .map(|c| {
            let codes = codes.index_axis(Axis(2), c);
            let (means, known) = block_means(codes, clear, block);
            let medians = median::median(means.view(), known.view(), radius);
            let mut plane = Array2::zeros((height, width));
            for ((y, x), value) in plane.indexed_iter_mut() {
                if clear[[y, x]] {
                    *value = between(&medians, y, x, block) / SIXTEENTHS;
                }
            }
            plane
        })
        .collect();
    Array3::from_shape_fn((height, width, 3), |(y, x, c)| planes[c][[y, x]])
}
/// Steps of a block's mean per code.
const SIXTEENTHS: f32 = 16.0;

/// Mean, in sixteenths of a code, of the clear pixels of every block, and whether a block has any.
fn block_means(codes: ndarray::ArrayView2<f32>, clear: &Array2<bool>, block: usize) -> (Array2<u16>, Array2<bool>) {
    let (height, width) = codes.dim();
    let shape = (height.div_ceil(block), width.div_ceil(block));
    let mut means = Array2::zeros(shape);
    let mut known = Array2::from_elem(shape, false);
    for ((by, bx), mean) in means.indexed_iter_mut() {
        let (mut sum, mut count) = (0.0f32, 0u32);
        for y in by * block..((by + 1) * block).min(height) {
            for x in bx * block..((bx + 1) * block).min(width) {
                if clear[[y, x]] {
                    sum += codes[[y, x]];
                    count += 1;
                }
            }
        }
        if count > 0 {
            // Evened out, a bright view's codes may lie beyond 255.
            *mean = ((sum / count as f32 * SIXTEENTHS + 0.5) as u16).min(median::STEPS as u16 - 1);
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
