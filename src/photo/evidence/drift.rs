//! Exposure and white balance that drift from view to view, taken out.
//!
//! Per view and channel one gain in linear light, against the middle of all views at the same pixels of the still room:
//! the mean of the middle half of log ratios, so that what moves in some pixels does not count and codes' steps average out.

use crate::photo::Picture;
use crate::photo::colour::{linear_of_srgb, srgb_of_linear};

/// Codes beyond which a channel is too dark or clipped to tell a gain.
const TOLD: std::ops::RangeInclusive<u8> = 12..=243;
/// Fewer pixels than these tell no gain.
const FEWEST: usize = 200;

/// Gains (R, G, B) of every view against their middle, from the room's pixels (y, x); ones where these are too few.
pub fn gains(photos: &[Picture], room: &[(usize, usize)]) -> Vec<[f64; 3]> {
    let mut gains = vec![[1.0; 3]; photos.len()];
    for c in 0..3 {
        let told: Vec<Vec<f64>> = room
            .iter()
            .filter(|&&(y, x)| photos.iter().all(|p| TOLD.contains(&p[[y, x, c]])))
            .map(|&(y, x)| {
                photos.iter().map(|p| f64::from(linear_of_srgb(f32::from(p[[y, x, c]]) / 255.0)).ln()).collect()
            })
            .collect();
        if told.len() < FEWEST {
            continue;
        }
        let mut log_gain = vec![0.0; photos.len()];
        for _ in 0..2 {
            let middle: Vec<f64> = told
                .iter()
                .map(|logs| middle_half(logs.iter().zip(&log_gain).map(|(log, gain)| log - gain).collect()))
                .collect();
            for (v, gain) in log_gain.iter_mut().enumerate() {
                *gain = middle_half(told.iter().zip(&middle).map(|(logs, middle)| logs[v] - middle).collect());
            }
        }
        for (gain, log) in gains.iter_mut().zip(&log_gain) {
            gain[c] = log.exp();
        }
    }
    gains
}

/// Mean of the middle half of the values.
fn middle_half(mut values: Vec<f64>) -> f64 {
    values.sort_unstable_by(f64::total_cmp);
    let quarter = values.len() / 4;
    let middle = &values[quarter..values.len() - quarter];
    middle.iter().sum::<f64>() / middle.len().max(1) as f64
}

/// Codes of a view as they would be at gain 1.
#[derive(Debug, Clone)]
pub struct Even([Vec<f32>; 3]);

impl Even {
    /// For a view of these gains.
    pub fn new(gains: [f64; 3]) -> Self {
        Self(gains.map(|gain| {
            let even = |code: usize| 255.0 * srgb_of_linear(linear_of_srgb(code as f32 / 255.0) / gain as f32);
            (0..=256).map(|code| if gain == 1.0 { code as f32 } else { even(code) }).collect()
        }))
    }

    /// The colour of a pixel of a photograph of 8 bits.
    pub fn pixel(&self, photo: &Picture, y: usize, x: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.0[c][usize::from(photo[[y, x, c]])])
    }

    /// A code with its fraction, of channel `c`.
    pub fn code(&self, c: usize, code: f32) -> f32 {
        let below = (code.max(0.0) as usize).min(255);
        let part = code - below as f32;
        self.0[c][below] + part * (self.0[c][below + 1] - self.0[c][below])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_found_beside_things_that_move() {
        let of_view = [1.0f32, 1.3, 0.8, 1.0, 0.9];
        let photos: Vec<Picture> = of_view
            .iter()
            .enumerate()
            .map(|(v, gain)| {
                Picture::from_shape_fn((40, 40, 3), |(y, x, c)| {
                    let room = 0.05 + 0.2 * ((3 * x + 7 * y + 11 * c) % 40) as f32 / 40.0;
                    let moved = if (x + 8 * v) % 40 < 5 { 2.0 } else { 1.0 };
                    (255.0 * srgb_of_linear(room * gain * moved)).round() as u8
                })
            })
            .collect();
        let room: Vec<_> = (0..40).flat_map(|y| (0..40).map(move |x| (y, x))).collect();
        let found = gains(&photos, &room);
        for (gain, expected) in found.iter().zip(of_view) {
            let ratio = gain[1] / found[0][1] / f64::from(expected);
            assert!((ratio - 1.0).abs() < 0.01, "{gain:?} for {expected}");
        }
        let (a, b) = (Even::new(found[0]).pixel(&photos[0], 20, 30), Even::new(found[2]).pixel(&photos[2], 20, 30));
        assert!((a[0] - b[0]).abs() < 1.5, "{a:?} {b:?}");
    }

    #[test]
    fn a_gain_of_one_changes_nothing() {
        let even = Even::new([1.0; 3]);
        assert!((0..=255u16).all(|code| even.code(0, f32::from(code)) == f32::from(code)));
        assert_eq!(even.code(2, 17.25), 17.25);
    }
}
