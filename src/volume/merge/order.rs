//! Estimators of each channel by the order of its values.

use super::{Bundle, LANES, Lane};

/// Applies `estimate` to the sorted values of every channel per lane; 0 where no view sees the voxel.
pub(super) fn per_channel(bundle: &Bundle, count: &Lane, estimate: impl Fn(&[f32]) -> f32) -> [Lane; 3] {
    let mut out = [[0.0; LANES]; 3];
    let mut values = Vec::with_capacity(bundle.mask.len());
    for i in (0..LANES).filter(|&i| count[i] > 0.0) {
        for (c, channel) in bundle.channel.iter().enumerate() {
            values.clear();
            for (values_of_view, mask) in channel.iter().zip(&bundle.mask) {
                if mask[i] != 0.0 {
                    insert(&mut values, values_of_view[i]);
                }
            }
            out[c][i] = estimate(&values);
        }
    }
    out
}

/// Inserts into sorted values: for some dozens of views this beats cleverer sorts.
fn insert(sorted: &mut Vec<f32>, value: f32) {
    sorted.push(value);
    let mut at = sorted.len() - 1;
    while at > 0 && sorted[at - 1] > value {
        sorted[at] = sorted[at - 1];
        at -= 1;
    }
    sorted[at] = value;
}

/// The q-quantile of sorted values, linear between order statistics (position q (n - 1) among n, from 0).
pub(super) fn quantile(sorted: &[f32], q: f32) -> f32 {
    let at = q * (sorted.len() - 1) as f32;
    let below = (at as usize).min(sorted.len() - 1);
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (at - below as f32) * (sorted[above] - sorted[below])
}

/// Mean of the lowest q n of n sorted values, the last one by its part; the lowest alone at q n ≤ 1.
pub(super) fn low_mean(sorted: &[f32], q: f32) -> f32 {
    let wanted = (q * sorted.len() as f32).max(1.0);
    let whole = (wanted as usize).min(sorted.len());
    let mut sum = 0.0;
    for value in &sorted[..whole] {
        sum += value;
    }
    let part = wanted - whole as f32;
    if let Some(last) = sorted.get(whole) {
        sum += part * last;
    }
    sum / wanted
}
