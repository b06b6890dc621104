//! Estimators by order for gray views: rows in which every view shows red, green and blue alike, as photographs do
//! once they are reduced to a colour axis.
//!
//! The values are bytes, so the order statistic of rank r is found bit by bit (the largest t with at most r values
//! under it) on lanes of bytes, without sorting. All sums are of integers under 2^24 and every other operation is
//! that of the estimators on sorted values, so the bits are theirs.

use super::{Estimator, Merge};
use ndarray::{ArrayView4, ArrayViewMut1, ArrayViewMut2, Axis};
use pulp::Arch;

/// Voxels worked on abreast.
const LANES: usize = 32;
/// Counts are kept in bytes.
const MOST_VIEWS: usize = 255;

/// What is read off the sorted values of n views.
#[derive(Debug, Clone, Copy, Default)]
struct Rank {
    /// The values that are wanted whole: the lowest `whole` ones; at least 1.
    whole: u8,
    /// The part that is wanted of the next one.
    part: f32,
    /// Number of values wanted.
    wanted: f32,
}

/// The estimator, prepared for every number of views.
#[derive(Debug)]
pub(super) struct ByOrder {
    /// By number of views that see the voxel.
    ranks: Vec<Rank>,
    /// Whether the sum of the wanted values counts, or only the last ones.
    is_mean: bool,
    min_views: usize,
}

impl ByOrder {
    /// `None` where the estimator is not one by order, or not on bytes.
    pub fn new(params: &Merge, views: usize) -> Option<Self> {
        if params.metric != super::Metric::Rgb || views > MOST_VIEWS {
            return None;
        }
        let at_quantile = |q: f32, n: usize| {
            let at = q * (n - 1) as f32;
            let below = (at as usize).min(n - 1);
            Rank { whole: below as u8 + 1, part: at - below as f32, wanted: 1.0 }
        };
        let of_low_mean = |q: f32, n: usize| {
            let wanted = (q * n as f32).max(1.0);
            let whole = (wanted as usize).min(n);
            Rank { whole: whole as u8, part: wanted - whole as f32, wanted }
        };
        let rank: &dyn Fn(usize) -> Rank = match params.estimator {
            Estimator::Median => &|n| at_quantile(0.5, n),
            Estimator::Quantile => &|n| at_quantile(params.quantile, n),
            Estimator::LowMean => &|n| of_low_mean(params.quantile, n),
            Estimator::GeometricMedian | Estimator::Mean => return None,
        };
        // No rank is asked for where no view sees.
        let ranks = std::iter::once(Rank::default()).chain((1..=views).map(rank)).collect();
        Some(Self { ranks, is_mean: params.estimator == Estimator::LowMean, min_views: params.min_views })
    }

    /// Estimates the voxels of `row`; their colour (x, rgb), coverage and residual are written where known.
    pub fn estimate(
        &self,
        row: &GrayRow,
        colour: ArrayViewMut2<f32>,
        coverage: ArrayViewMut1<u8>,
        residual: ArrayViewMut1<f32>,
    ) {
        Arch::new().dispatch(Task { order: self, row, colour, coverage, residual });
    }

    /// The estimate of every lane, 0..255; anything where no view sees.
    #[inline(always)]
    fn block(&self, views: &[[u8; LANES]], count: &[u8; LANES]) -> [f32; LANES] {
        let rank = count.map(|n| self.ranks[usize::from(n)]);
        let whole = rank.map(|r| r.whole);
        // The value of the last whole one, from its highest bit down; unseen views count as 255 and are never under.
        let mut value = [0u8; LANES];
        for bit in (0..8).rev() {
            let candidate = value.map(|v| v | 1 << bit);
            let mut under = [0u8; LANES];
            for view in views {
                for i in 0..LANES {
                    under[i] += u8::from(view[i] < candidate[i]);
                }
            }
            for i in 0..LANES {
                value[i] = if under[i] < whole[i] { candidate[i] } else { value[i] };
            }
        }
        let (mut under, mut upto) = ([0u8; LANES], [0u8; LANES]);
        let (mut sum_under, mut next) = ([0u16; LANES], [255u8; LANES]);
        for view in views {
            for i in 0..LANES {
                let (v, t) = (view[i], value[i]);
                under[i] += u8::from(v < t);
                upto[i] += u8::from(v <= t);
                sum_under[i] += if v < t { u16::from(v) } else { 0 };
                next[i] = next[i].min(if v > t { v } else { 255 });
            }
        }
        let mut out = [0.0; LANES];
        for i in 0..LANES {
            let last = f32::from(value[i]);
            let next = if upto[i] > whole[i] { last } else { f32::from(next[i]) };
            // There is no next one where all are wanted.
            let next = if whole[i] < count[i] { next } else { last };
            out[i] = if self.is_mean {
                let lowest = f32::from(sum_under[i]) + f32::from(whole[i].wrapping_sub(under[i])) * last;
                let part = if whole[i] < count[i] { rank[i].part * next } else { 0.0 };
                (lowest + part) / rank[i].wanted
            } else {
                last + rank[i].part * (next - last)
            };
        }
        out
    }
}

/// One row of every view, gray.
#[derive(Debug, Default)]
pub(super) struct GrayRow {
    width: usize,
    views: usize,
    /// Per block of lanes, per view; 255 where the view does not see the voxel.
    values: Vec<[u8; LANES]>,
    /// As `values`: 1 where the view sees the voxel.
    seen: Vec<[u8; LANES]>,
}

impl GrayRow {
    /// Loads row (k, j) of the views (z, y, x, rgb + mask); false where a view has colour.
    pub fn load(&mut self, views: &[ArrayView4<u8>], k: usize, j: usize) -> bool {
        self.width = views[0].shape()[2];
        self.views = views.len();
        let blocks = self.width.div_ceil(LANES);
        self.values.resize(blocks * views.len(), [255; LANES]);
        self.seen.resize(blocks * views.len(), [0; LANES]);
        for (l, view) in views.iter().enumerate() {
            let row = view.index_axis(Axis(0), k).index_axis_move(Axis(0), j);
            let Some(bytes) = row.to_slice() else { return false };
            let voxels = bytes.as_chunks::<4>().0;
            let mut colour = 0;
            for (block, voxels) in voxels.chunks(LANES).enumerate() {
                let (values, seen) = (&mut self.values[block * self.views + l], &mut self.seen[block * self.views + l]);
                for (i, &[red, green, blue, mask]) in voxels.iter().enumerate() {
                    let sees = u8::from(mask != 0);
                    // All bits set where unseen.
                    values[i] = red | sees.wrapping_sub(1);
                    seen[i] = sees;
                    colour |= ((red ^ green) | (green ^ blue)) & sees.wrapping_neg();
                }
            }
            if colour != 0 {
                return false;
            }
        }
        true
    }
}

/// A row's estimation as a task for [`Arch::dispatch`].
struct Task<'a> {
    order: &'a ByOrder,
    row: &'a GrayRow,
    colour: ArrayViewMut2<'a, f32>,
    coverage: ArrayViewMut1<'a, u8>,
    residual: ArrayViewMut1<'a, f32>,
}

impl pulp::WithSimd for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        let GrayRow { width, views, values, seen } = self.row;
        for from in (0..*width).step_by(LANES) {
            let block = from / LANES * views..(from / LANES + 1) * views;
            let (values, seen) = (&values[block.clone()], &seen[block]);
            let mut count = [0u8; LANES];
            for seen in seen {
                for i in 0..LANES {
                    count[i] += seen[i];
                }
            }
            let lanes = LANES.min(width - from);
            let known = |i: usize| i < lanes && usize::from(count[i]) >= self.order.min_views;
            for i in 0..lanes {
                self.coverage[from + i] = count[i];
            }
            if !(0..lanes).any(known) {
                continue;
            }
            let estimate = self.order.block(values, &count);
            let mut spread = [0.0f32; LANES];
            for (value, seen) in values.iter().zip(seen) {
                for i in 0..LANES {
                    let d = f32::from(value[i]) - estimate[i];
                    spread[i] += f32::from(seen[i]) * (d * d + d * d + d * d).sqrt();
                }
            }
            for i in (0..lanes).filter(|&i| known(i)) {
                for channel in 0..3 {
                    self.colour[[from + i, channel]] = estimate[i] / 255.0;
                }
                self.residual[from + i] = spread[i] / f32::from(count[i]) / 255.0;
            }
        }
    }
}
