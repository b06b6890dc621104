//! Median of the clear pixels in a square window, by a running histogram (Huang 1979).

use ndarray::{Array2, ArrayView2, Axis};
use rayon::prelude::*;

/// Values are below it: sixteenths of a code.
pub const STEPS: usize = 16 * 256;

/// At every pixel of which the window (half width `radius`, cut at the picture's border) holds a clear
/// pixel: the median of the clear ones, all below [`STEPS`], between steps by the share of the middle one (so that
/// single steps do not show); NaN elsewhere.
pub fn median(values: ArrayView2<u16>, clear: ArrayView2<bool>, radius: usize) -> Array2<f32> {
    let (height, width) = values.dim();
    let mut out = Array2::from_elem((height, width), f32::NAN);
    out.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(y, mut row)| {
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let mut window = Window { bins: vec![0; STEPS], count: 0, middle: 0, below: 0 };
        for x in 0..width + radius {
            if x < width {
                rows.clone().filter(|&y| clear[[y, x]]).for_each(|y| window.add(values[[y, x]]));
            }
            if let Some(gone) = x.checked_sub(2 * radius + 1) {
                rows.clone().filter(|&y| clear[[y, gone]]).for_each(|y| window.remove(values[[y, gone]]));
            }
            if let Some(centre) = x.checked_sub(radius).filter(|_| window.count > 0) {
                row[centre] = window.median();
            }
        }
    });
    out
}

struct Window {
    bins: Vec<u32>,
    count: u32,
    /// The median's step as of the last question, and how many values lie below it.
    middle: usize,
    below: u32,
}

impl Window {
    fn add(&mut self, step: u16) {
        self.bins[usize::from(step)] += 1;
        self.count += 1;
        self.below += u32::from(usize::from(step) < self.middle);
    }

    fn remove(&mut self, step: u16) {
        self.bins[usize::from(step)] -= 1;
        self.count -= 1;
        self.below -= u32::from(usize::from(step) < self.middle);
    }

    fn median(&mut self) -> f32 {
        while 2 * self.below > self.count {
            self.middle -= 1;
            self.below -= self.bins[self.middle];
        }
        while 2 * (self.below + self.bins[self.middle]) <= self.count && self.middle + 1 < self.bins.len() {
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
            state
        };
        let values = Array2::from_shape_simple_fn((13, 17), || (next() >> 20) as u16);
        let clear = Array2::from_shape_simple_fn((13, 17), || next() >> 24 > 120);
        for radius in [0, 1, 3, 20] {
            let got = median(values.view(), clear.view(), radius);
            for y in 0..13usize {
                for x in 0..17usize {
                    let mut window: Vec<u16> = values
                        .indexed_iter()
                        .filter(|((v, u), _)| v.abs_diff(y) <= radius && u.abs_diff(x) <= radius && clear[[*v, *u]])
                        .map(|(_, &c)| c)
                        .collect();
                    window.sort_unstable();
                    if window.is_empty() {
                        assert!(got[[y, x]].is_nan());
                    } else {
                        // Within half a step of a middle value.
                        let (a, b) = (window[(window.len() - 1) / 2], window[window.len() / 2]);
                        assert!(got[[y, x]] >= f32::from(a) - 0.5 && got[[y, x]] <= f32::from(b) + 0.5);
                    }
                }
            }
        }
    }
}
