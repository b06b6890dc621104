//! Coarser copies of a volume, each half as fine as the one before.
//!
//! A voxel of the coarser level covers 2 x 2 x 2 of the finer; at an odd border it covers what there
//! is. Means leave NaN out and are NaN only where all is NaN; maxima keep thin roots visible.

use ndarray::{Array3, ArrayView3};
use rayon::prelude::*;

/// Half as fine by the mean of the finite values, z, y, x.
pub fn halve_mean(fine: ArrayView3<f32>) -> Array3<f32> {
    halve(fine, |values| {
        let (mut sum, mut n) = (0.0_f32, 0_u8);
        for v in values.filter(|v| !v.is_nan()) {
            sum += v;
            n += 1;
        }
        if n == 0 { f32::NAN } else { sum / f32::from(n) }
    })
}

/// Half as fine by the maximum, z, y, x; NaN only where all is NaN.
pub fn halve_max(fine: ArrayView3<f32>) -> Array3<f32> {
    halve(fine, |values| values.fold(f32::NAN, f32::max))
}

/// Half as fine by the largest label, z, y, x; 0 is background.
pub fn halve_labels(fine: ArrayView3<u32>) -> Array3<u32> {
    halve(fine, |values| values.max().unwrap_or(0))
}

fn halve<T: Copy + Default + Send + Sync>(
    fine: ArrayView3<T>,
    pool: impl Fn(&mut dyn Iterator<Item = T>) -> T + Sync,
) -> Array3<T> {
    let (depth, height, width) = fine.dim();
    let mut coarse = Array3::default((depth.div_ceil(2), height.div_ceil(2), width.div_ceil(2)));
    coarse.outer_iter_mut().into_par_iter().enumerate().for_each(|(k, mut plane)| {
        for ((j, i), out) in plane.indexed_iter_mut() {
            let block = fine.slice(ndarray::s![
                2 * k..(2 * k + 2).min(depth),
                2 * j..(2 * j + 2).min(height),
                2 * i..(2 * i + 2).min(width)
            ]);
            *out = pool(&mut block.iter().copied());
        }
    });
    coarse
}

/// Number of levels until the longest edge is at most `smallest`, the finest included.
pub fn levels(shape: [usize; 3], smallest: usize) -> usize {
    let mut longest = shape.into_iter().max().unwrap_or(0);
    let mut n = 1;
    while longest > smallest.max(1) {
        longest = longest.div_ceil(2);
        n += 1;
    }
    n
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn odd_borders_and_nan() {
        let fine = array![[[1.0, 3.0, 5.0], [1.0, f32::NAN, f32::NAN]]];
        assert_eq!(halve_mean(fine.view()), array![[[5.0 / 3.0, 5.0]]]);
        assert_eq!(halve_max(fine.view()), array![[[3.0, 5.0]]]);
        let none = array![[[f32::NAN]]];
        assert!(halve_mean(none.view())[[0, 0, 0]].is_nan() && halve_max(none.view())[[0, 0, 0]].is_nan());
        assert_eq!(halve_labels(array![[[0, 7, 2]]].view()), array![[[7, 2]]]);
        assert_eq!((levels([180, 171, 171], 64), levels([1, 1, 1], 64), levels([65, 1, 1], 64)), (3, 1, 2));
    }
}
