//! Median of the clear pixels in a square window, by a running histogram (Huang 1979).

use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;

/// At every pixel of which the window (half width `radius`, cut at the picture's border) holds a clear
/// pixel: the median of the clear ones, between codes by the share of the middle code (so that steps
/// of one code do not show); NaN elsewhere.
pub fn median(codes: ArrayView2<u8>, clear: ArrayView2<bool>, radius: usize) -> Array2<f32> {
    let (height, width) = codes.dim();
    let mut out = Array2::from_elem((height, width), f32::NAN);
    out.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(y, mut row)| {
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let mut window = Window { bins: [0; 256], count: 0, middle: 0, below: 0 };
        for x in 0..width + radius {
            if x < width {
                rows.clone().filter(|&y| clear[[y, x]]).for_each(|y| window.add(codes[[y, x]]));
            }
            if let Some(gone) = x.checked_sub(2 * radius + 1) {
                rows.clone().filter(|&y| clear[[y, gone]]).for_each(|y| window.remove(codes[[y, gone]]));
            }
            if let Some(centre) = x.checked_sub(radius).filter(|_| window.count > 0) {
                row[centre] = window.median();
            }
        }
    });
    out
}

struct Window {
    bins: [u32; 256],
    count: u32,
    /// The median's code as of the last question, and how many codes lie below it.
    middle: usize,
    below: u32,
}

impl Window {
    fn add(&mut self, code: u8) {
        self.bins[usize::from(code)] += 1;
        self.count += 1;
        self.below += u32::from(usize::from(code) < self.middle);
    }

    fn remove(&mut self, code: u8) {
        self.bins[usize::from(code)] -= 1;
        self.count -= 1;
        self.below -= u32::from(usize::from(code) < self.middle);
    }

    fn median(&mut self) -> f32 {
        while 2 * self.below > self.count {
            self.middle -= 1;
            self.below -= self.bins[self.middle];
        }
        while 2 * (self.below + self.bins[self.middle]) <= self.count && self.middle < 255 {
            self.below += self.bins[self.middle];
            self.middle += 1;
        }
        let within = (0.5 * self.count as f32 - self.below as f32) / self.bins[self.middle].max(1) as f32;
        self.middle as f32 + within - 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equals_sorting_the_window() {
        let mut state = 5u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let codes = Array2::from_shape_simple_fn((13, 17), || next() / 8 + 90);
        let clear = Array2::from_shape_simple_fn((13, 17), || next() > 120);
        for radius in [0, 1, 3, 20] {
            let got = median(codes.view(), clear.view(), radius);
            for y in 0..13usize {
                for x in 0..17usize {
                    let mut window: Vec<u8> = codes
                        .indexed_iter()
                        .filter(|((v, u), _)| v.abs_diff(y) <= radius && u.abs_diff(x) <= radius && clear[[*v, *u]])
                        .map(|(_, &c)| c)
                        .collect();
                    window.sort_unstable();
                    if window.is_empty() {
                        assert!(got[[y, x]].is_nan());
                    } else {
                        // Within half a code of a middle value.
                        let (a, b) = (window[(window.len() - 1) / 2], window[window.len() / 2]);
                        assert!(got[[y, x]] >= f32::from(a) - 0.5 && got[[y, x]] <= f32::from(b) + 0.5);
                    }
                }
            }
        }
    }
}
