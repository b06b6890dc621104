//! What the background is likely to be where its pixels do not tell: the mean of the sure ones around.
//!
//! The smallest window of a growing series that holds enough sure pixels is taken; sums over windows come from summed
//! areas. The variance of the sure pixels in it says how far the guess may be off.

use ndarray::{Array2, Array3};

/// Half edges of the windows, px.
const HALF: [usize; 7] = [2, 4, 7, 12, 22, 42, 80];
/// Share of a window that must be sure.
const ENOUGH: f64 = 0.15;

/// Sums over the area above and to the left: count, colours, squares.
pub(super) struct Areas {
    sums: Vec<[f64; 7]>,
    width: usize,
    height: usize,
}

impl Areas {
    /// Of the sure pixels' colours.
    pub fn new(colours: &Array3<f32>, sure: &Array2<bool>) -> Self {
        let (height, width) = sure.dim();
        let mut sums = vec![[0.0; 7]; (height + 1) * (width + 1)];
        for y in 0..height {
            let mut row = [0.0; 7];
            for x in 0..width {
                if sure[[y, x]] {
                    let [r, g, b] = [0, 1, 2].map(|c| f64::from(colours[[y, x, c]]));
                    for (sum, value) in row.iter_mut().zip([1.0, r, g, b, r * r, g * g, b * b]) {
                        *sum += value;
                    }
                }
                let above = sums[y * (width + 1) + x + 1];
                let here = &mut sums[(y + 1) * (width + 1) + x + 1];
                for n in 0..7 {
                    here[n] = above[n] + row[n];
                }
            }
        }
        Self { sums, width, height }
    }

    /// Mean and variance of the sure pixels around a pixel, by channel; `None` where there is none within reach.
    pub fn around(&self, y: usize, x: usize) -> Option<([f32; 3], [f32; 3])> {
        for (n, half) in HALF.into_iter().enumerate() {
            let (top, left) = (y.saturating_sub(half), x.saturating_sub(half));
            let (bottom, right) = ((y + half + 1).min(self.height), (x + half + 1).min(self.width));
            let at = |y: usize, x: usize| &self.sums[y * (self.width + 1) + x];
            let (a, b, c, d) = (at(top, left), at(top, right), at(bottom, left), at(bottom, right));
            let sum: [f64; 7] = std::array::from_fn(|n| a[n] + d[n] - b[n] - c[n]);
            let edge = (2 * half + 1) as f64;
            let wanted = if n + 1 == HALF.len() { 1.0 } else { ENOUGH * edge * edge };
            if sum[0] >= wanted {
                let mean = [1, 2, 3].map(|c| sum[c] / sum[0]);
                let variance = [0, 1, 2].map(|c| (sum[4 + c] / sum[0] - mean[c] * mean[c]).max(0.0) as f32);
                return Some((mean.map(|m| m as f32), variance));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_sure_pixels_are_taken() {
        let colours = Array3::from_shape_fn((50, 60, 3), |(_, x, c)| if x < 30 { 10.0 } else { 90.0 + c as f32 });
        let sure = Array2::from_shape_fn((50, 60), |(y, x)| !(15..25).contains(&y) && x != 12);
        let areas = Areas::new(&colours, &sure);
        assert_eq!(areas.around(20, 5), Some(([10.0; 3], [0.0; 3])));
        assert_eq!(areas.around(20, 55), Some(([90.0, 91.0, 92.0], [0.0; 3])));
        let (mean, variance) = areas.around(20, 30).unwrap();
        assert!(mean[0] > 20.0 && mean[0] < 80.0 && variance[0] > 500.0);
        assert!(Areas::new(&colours, &Array2::from_elem((50, 60), false)).around(3, 3).is_none());
    }
}
