//! Quantiles of each channel, linear between order statistics (position q (n - 1) among n, from 0).
//!
//! Values are sorted per voxel and channel by insertion, which for some dozens of views beats cleverer
//! sorts.

use super::{Bundle, LANES, Lane};

/// The q-quantile of every channel per lane; 0 where no view sees the voxel.
pub(super) fn quantile(bundle: &Bundle, count: &Lane, q: f32) -> [Lane; 3] {
    let mut out = [[0.0; LANES]; 3];
    let mut values = Vec::with_capacity(bundle.mask.len());
    for i in (0..LANES).filter(|&i| count[i] > 0.0) {
        for (channel, out) in bundle.channel.iter().zip(&mut out) {
            values.clear();
            values.extend((0..bundle.mask.len()).filter(|&l| bundle.mask[l][i] != 0.0).map(|l| channel[l][i]));
            out[i] = of_values(&mut values, q);
        }
    }
    out
}

/// The q-quantile of at least one value; reorders them.
fn of_values(values: &mut [f32], q: f32) -> f32 {
    values.sort_unstable_by(f32::total_cmp);
    let at = q * (values.len() - 1) as f32;
    let below = (at as usize).min(values.len() - 1);
    let above = (below + 1).min(values.len() - 1);
    values[below] + (at - below as f32) * (values[above] - values[below])
}
