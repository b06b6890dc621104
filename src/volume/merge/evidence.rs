//! Merging shares of root by how sure each view is: the weighted forms of the estimators.
//!
//! In: of every view a slab (z, y, x, 4) u8: share, confidence, nothing, mask. A view's weight is its confidence over 255, 0
//! where it is masked; W is their sum, the number of views that can judge the voxel. Below `min_views` the
//! voxel is unknown, however many views see it.
//!
//! | estimator | weighted form; at equal weights |
//! |---|---|
//! | mean | Σ w x / W; the mean |
//! | median, geometric-median (the same for one channel) | the quantile ½ |
//! | quantile q | linear between sorted values placed at (mᵢ - m₀) / (mₙ - m₀), mᵢ the weight under value i and half its own; q (n - 1) |
//! | low-mean q | mean of the lowest weight max(q W, 1), the last value by its part; the lowest q n values |
//!
//! The low mean of many voxels is found without sorting: its last value bit by bit (the largest t with less than the
//! wanted weight under it), then by sums of integers.

use super::{Estimator, Merge, Merged};
use crate::error::Result;
use ndarray::{Array3, Array4, ArrayView4, ArrayViewMut1, ArrayViewMut2, Axis};
use pulp::Arch;
use rayon::prelude::*;

/// Voxels worked on abreast.
const LANES: usize = 32;
/// Weight of a view that is sure.
const SURE: f32 = 255.0;

/// Merges the same slab of every view's share of root; the result has one channel.
///
/// # Errors
/// As [`super::merge`].
pub fn merge_evidence(views: &[ArrayView4<u8>], params: &Merge) -> Result<Merged> {
    let [nz, ny, nx] = super::checked_shape(views, params)?;
    let mut colour = Array4::from_elem((nz, ny, nx, 1), f32::NAN);
    let mut coverage = Array3::zeros((nz, ny, nx));
    let mut residual = Array3::from_elem((nz, ny, nx), f32::NAN);
    colour
        .axis_iter_mut(Axis(0))
        .into_par_iter()
        .zip(coverage.axis_iter_mut(Axis(0)))
        .zip(residual.axis_iter_mut(Axis(0)))
        .enumerate()
        .for_each(|(k, ((mut colour, mut coverage), mut residual))| {
            let mut row = Row::default();
            for j in 0..ny {
                let (colour, coverage) = (colour.index_axis_mut(Axis(0), j), coverage.index_axis_mut(Axis(0), j));
                let residual = residual.index_axis_mut(Axis(0), j);
                Arch::new().dispatch(Task { views, k, j, row: &mut row, params, colour, coverage, residual });
            }
        });
    Ok(Merged { colour, coverage, residual })
}

/// One row of every view.
#[derive(Debug, Default)]
struct Row {
    width: usize,
    views: usize,
    /// Per block of lanes, per view.
    shares: Vec<[u8; LANES]>,
    weights: Vec<[u8; LANES]>,
}

impl Row {
    #[inline(always)]
    fn load(&mut self, views: &[ArrayView4<u8>], k: usize, j: usize) {
        self.width = views[0].shape()[2];
        self.views = views.len();
        let blocks = self.width.div_ceil(LANES);
        self.shares.clear();
        self.shares.resize(blocks * views.len(), [0; LANES]);
        self.weights.clear();
        self.weights.resize(blocks * views.len(), [0; LANES]);
        for (l, view) in views.iter().enumerate() {
            let row = view.index_axis(Axis(0), k).index_axis_move(Axis(0), j);
            let row = row.as_standard_layout();
            let voxels = row.as_slice().expect("standard layout").as_chunks::<4>().0;
            for (block, voxels) in voxels.chunks(LANES).enumerate() {
                let at = block * self.views + l;
                let lanes = self.shares[at].iter_mut().zip(&mut self.weights[at]);
                for ((share, weight), &[value, confidence, _, mask]) in lanes.zip(voxels) {
                    *share = value;
                    *weight = if mask != 0 { confidence } else { 0 };
                }
            }
        }
    }
}

/// A row's estimation.
struct Task<'a> {
    views: &'a [ArrayView4<'a, u8>],
    k: usize,
    j: usize,
    row: &'a mut Row,
    params: &'a Merge,
    colour: ArrayViewMut2<'a, f32>,
    coverage: ArrayViewMut1<'a, u8>,
    residual: ArrayViewMut1<'a, f32>,
}

impl pulp::WithSimd for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(mut self, _: S) {
        self.row.load(self.views, self.k, self.j);
        let Row { width, views, shares, weights } = &*self.row;
        let least = SURE * self.params.min_views as f32;
        let mut sorted = Vec::with_capacity(*views);
        for from in (0..*width).step_by(LANES) {
            let block = from / LANES * views..(from / LANES + 1) * views;
            let (shares, weights) = (&shares[block.clone()], &weights[block]);
            let mut total = [0u32; LANES];
            for weights in weights {
                for i in 0..LANES {
                    total[i] += u32::from(weights[i]);
                }
            }
            let lanes = LANES.min(width - from);
            let known = |i: usize| i < lanes && total[i] as f32 >= least;
            for i in 0..lanes {
                self.coverage[from + i] = ((total[i] + 127) / 255).min(255) as u8;
            }
            if !(0..lanes).any(known) {
                continue;
            }
            let estimate = match self.params.estimator {
                Estimator::LowMean => low_means(shares, weights, &total, self.params.quantile),
                estimator => {
                    let mut out = [0.0; LANES];
                    for i in (0..lanes).filter(|&i| known(i)) {
                        sorted.clear();
                        sorted.extend((0..*views).map(|l| (shares[l][i], weights[l][i])).filter(|v| v.1 > 0));
                        sorted.sort_unstable();
                        out[i] = match estimator {
                            Estimator::Mean => low_mean(&sorted, 1.0),
                            Estimator::Quantile => quantile(&sorted, self.params.quantile),
                            _ => quantile(&sorted, 0.5),
                        };
                    }
                    out
                }
            };
            let mut spread = [0.0f32; LANES];
            for (share, weight) in shares.iter().zip(weights) {
                for i in 0..LANES {
                    spread[i] += f32::from(weight[i]) * (f32::from(share[i]) - estimate[i]).abs();
                }
            }
            for i in (0..lanes).filter(|&i| known(i)) {
                self.colour[[from + i, 0]] = estimate[i] / 255.0;
                self.residual[from + i] = spread[i] / total[i] as f32 / 255.0;
            }
        }
    }
}

/// Weighted low means of all lanes, 0..255.
#[inline(always)]
fn low_means(shares: &[[u8; LANES]], weights: &[[u8; LANES]], total: &[u32; LANES], q: f32) -> [f32; LANES] {
    let mut wanted = [0.0f32; LANES];
    for i in 0..LANES {
        wanted[i] = wanted_weight(total[i], q);
    }
    let mut value = [0u8; LANES];
    for bit in (0..8).rev() {
        let mut candidate = [0u8; LANES];
        let mut under = [0u32; LANES];
        for i in 0..LANES {
            candidate[i] = value[i] | 1 << bit;
        }
        for (share, weight) in shares.iter().zip(weights) {
            for i in 0..LANES {
                under[i] += u32::from(weight[i] & all_if(share[i] < candidate[i]));
            }
        }
        for i in 0..LANES {
            value[i] = if (under[i] as f32) < wanted[i] { candidate[i] } else { value[i] };
        }
    }
    let (mut under, mut sum) = ([0u32; LANES], [0u32; LANES]);
    for (share, weight) in shares.iter().zip(weights) {
        for i in 0..LANES {
            let w = u32::from(weight[i] & all_if(share[i] < value[i]));
            under[i] += w;
            sum[i] += w * u32::from(share[i]);
        }
    }
    let mut out = [0.0; LANES];
    for i in 0..LANES {
        out[i] = (sum[i] as f32 + (wanted[i] - under[i] as f32) * f32::from(value[i])) / wanted[i];
    }
    out
}

/// All bits or none: a choice between values is compiled into branches, which do not vectorise.
#[inline(always)]
fn all_if(is: bool) -> u8 {
    u8::from(is).wrapping_neg()
}

/// Weight, in units of 1/255, that the low mean takes.
#[inline(always)]
fn wanted_weight(total: u32, q: f32) -> f32 {
    let whole = total as f32;
    let wanted = q * whole;
    let wanted = if wanted > SURE { wanted } else { SURE };
    if wanted < whole {
        wanted
    } else if whole > 0.0 {
        whole
    } else {
        1.0
    }
}

/// Low mean of sorted values with their weights.
fn low_mean(sorted: &[(u8, u8)], q: f32) -> f32 {
    let wanted = wanted_weight(sorted.iter().map(|v| u32::from(v.1)).sum(), q);
    let (mut under, mut sum) = (0u32, 0u32);
    for &(share, weight) in sorted {
        if (under + u32::from(weight)) as f32 >= wanted {
            return (sum as f32 + (wanted - under as f32) * f32::from(share)) / wanted;
        }
        under += u32::from(weight);
        sum += u32::from(weight) * u32::from(share);
    }
    sum as f32 / wanted
}

/// Quantile of sorted values with their weights.
fn quantile(sorted: &[(u8, u8)], q: f32) -> f32 {
    let (Some(first), Some(last)) = (sorted.first(), sorted.last()) else { return 0.0 };
    let total: f32 = sorted.iter().map(|v| f32::from(v.1)).sum();
    let start = 0.5 * f32::from(first.1);
    let at = start + q * (total - start - 0.5 * f32::from(last.1));
    let mut below = (0.0f32, start, f32::from(first.0));
    for &(share, weight) in sorted {
        let middle = below.0 + 0.5 * f32::from(weight);
        if middle >= at {
            let step = middle - below.1;
            let part = if step > 0.0 { (at - below.1) / step } else { 0.0 };
            return below.2 + part * (f32::from(share) - below.2);
        }
        below = (below.0 + f32::from(weight), middle, f32::from(share));
    }
    below.2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::merge::merge;
    use proptest::prelude::*;

    fn volumes(views: &[Vec<(u8, u8)>], mask: u8) -> Vec<Array4<u8>> {
        let volume = |view: &Vec<(u8, u8)>| {
            Array4::from_shape_fn((1, 1, view.len(), 4), |(_, _, i, c)| [view[i].0, view[i].1, 0, mask][c])
        };
        views.iter().map(volume).collect()
    }

    fn merged(volumes: &[Array4<u8>], params: &Merge) -> Merged {
        let views: Vec<_> = volumes.iter().map(|v| v.view()).collect();
        merge_evidence(&views, params).unwrap()
    }

    /// Low mean in f64: the weight is taken in steps of 1/255 from the lowest values.
    fn slow_low_mean(views: &[(u8, u8)], q: f32) -> f64 {
        let mut units: Vec<u8> = views.iter().flat_map(|&(v, w)| std::iter::repeat_n(v, usize::from(w))).collect();
        units.sort_unstable();
        let wanted = f64::from(wanted_weight(units.len() as u32, q));
        let whole = wanted as usize;
        let sum: f64 = units[..whole].iter().map(|&v| f64::from(v)).sum();
        (sum + (wanted - whole as f64) * units.get(whole).map_or(0.0, |&v| f64::from(v))) / wanted
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]
        #[test]
        fn low_means_are_those_of_units_of_weight(
            views in prop::collection::vec(prop::collection::vec((0u8..12, 0u8..=255), 37), 1..40), q in 0.0f32..=1.0,
        ) {
            let params = Merge { estimator: Estimator::LowMean, quantile: q, min_views: 1, ..Merge::default() };
            let out = merged(&volumes(&views, 255), &params);
            for i in 0..37 {
                let voxel: Vec<_> = views.iter().map(|v| v[i]).collect();
                let total: u32 = voxel.iter().map(|v| u32::from(v.1)).sum();
                let got = out.colour[[0, 0, i, 0]];
                prop_assert_eq!(got.is_nan(), total < 255);
                if !got.is_nan() {
                    prop_assert!((f64::from(got) * 255.0 - slow_low_mean(&voxel, q)).abs() < 1e-3);
                    let mut sorted: Vec<_> = voxel.into_iter().filter(|v| v.1 > 0).collect();
                    sorted.sort_unstable();
                    prop_assert!((got - low_mean(&sorted, q) / 255.0).abs() < 1e-5);
                }
            }
        }

        #[test]
        fn equal_weights_are_no_weights(
            values in prop::collection::vec(prop::collection::vec(0u8..=255, 33), 3..30), q in 0.0f32..=1.0, which in 0usize..5,
        ) {
            let estimator = [
                Estimator::Mean, Estimator::Median, Estimator::Quantile, Estimator::LowMean, Estimator::GeometricMedian,
            ][which];
            let params = Merge { estimator, quantile: q, ..Merge::default() };
            let sure: Vec<Vec<_>> = values.iter().map(|v| v.iter().map(|&x| (x, 255)).collect()).collect();
            let gray: Vec<Array4<u8>> = values
                .iter()
                .map(|v| Array4::from_shape_fn((1, 1, 33, 4), |(_, _, i, c)| if c < 3 { v[i] } else { 255 }))
                .collect();
            let gray: Vec<_> = gray.iter().map(|v| v.view()).collect();
            // The geometric median of one channel is its median; the iteration of colours comes near it only.
            let plain = if estimator == Estimator::GeometricMedian { Estimator::Median } else { estimator };
            let plain = merge(&gray, &Merge { estimator: plain, ..params.clone() }).unwrap();
            let weighted = merged(&volumes(&sure, 255), &params);
            for i in 0..33 {
                let (a, b) = (plain.colour[[0, 0, i, 1]], weighted.colour[[0, 0, i, 0]]);
                prop_assert!((a - b).abs() < 1e-5, "{estimator:?} {i}: {a} {b}");
            }
            prop_assert_eq!(plain.coverage, weighted.coverage);
        }

        #[test]
        fn a_view_counts_as_often_as_its_weight_says(
            values in prop::collection::vec((0u8..=255, 1u8..4), 3..12), q in 0.01f32..0.99,
        ) {
            // The mean by definition; a quantile lies between the lowest and the greatest and rises with q.
            let views: Vec<Vec<_>> = values.iter().map(|&(v, w)| vec![(v, 80 * w)]).collect();
            let of = |estimator, quantile| {
                let params = Merge { estimator, quantile, min_views: 1, ..Merge::default() };
                merged(&volumes(&views, 255), &params).colour[[0, 0, 0, 0]] * 255.0
            };
            let weight: f32 = values.iter().map(|v| f32::from(v.1)).sum();
            if weight * 80.0 >= 255.0 {
                let mean = values.iter().map(|v| f32::from(v.0) * f32::from(v.1)).sum::<f32>() / weight;
                prop_assert!((of(Estimator::Mean, 0.0) - mean).abs() < 1e-3);
                let (low, high) = (of(Estimator::Quantile, 0.5 * q), of(Estimator::Quantile, q));
                prop_assert!(low <= high + 1e-3);
            }
        }
    }

    #[test]
    fn views_without_a_say_leave_a_voxel_unknown() {
        let views = vec![vec![(200, 100)]; 5];
        let out = merged(&volumes(&views, 255), &Merge::default());
        assert!(out.colour[[0, 0, 0, 0]].is_nan() && out.residual[[0, 0, 0]].is_nan());
        assert_eq!(out.coverage[[0, 0, 0]], 2);
        assert!(merged(&volumes(&views, 0), &Merge { min_views: 1, ..Merge::default() }).colour[[0, 0, 0, 0]].is_nan());
    }
}
