//! One photograph at a glance: what a check keeps of it, so that it is decoded once.
//!
//! The photograph is gray, averaged over squares so that it is about 968 px wide, and that is averaged again over squares of
//! 2 x 2. Sharpness is told by the energy of horizontal slopes (central differences) at both sizes, which a random print has
//! at all sizes: their ratio is about 0.7 where the photograph is sharp, 0.44 where its blur has a standard deviation of 1 px
//! at that width, 0.37 at 1.5 px, and 0.25 at last.

use crate::photo::{Picture, gray};
use ndarray::Array2;

/// About how wide a photograph is looked at, px.
const WIDTH: usize = 968;
/// From this code on a channel is as good as clipped.
const CLIPPED: u8 = 254;

/// What is kept of a photograph.
#[derive(Debug, Clone)]
pub struct Glance {
    /// Gray values, 0..255, at half the width at which it is looked at.
    pub gray: Array2<f32>,
    /// Mean squared slope within each pixel of `gray`, before it was averaged.
    pub fine: Array2<f32>,
    /// Squared slope of `gray`.
    pub coarse: Array2<f32>,
    /// Share of the photograph's pixels with a clipped channel.
    pub clipped: f64,
    /// Pixels of the photograph per pixel of `gray`, along a side.
    pub factor: usize,
    /// BLAKE3 of the photograph's pixels: equal for equal ones.
    pub pixels: [u8; 32],
}

impl Glance {
    /// Looks at a photograph.
    pub fn at(photo: &Picture) -> Self {
        let (height, width, _) = photo.dim();
        let side = ((width as f64 / WIDTH as f64).round() as usize).max(1);
        let looked = shrunk(&gray(photo).mapv(f32::from), side);
        let small = shrunk(&looked, 2);
        let slope = |from: &Array2<f32>, y: usize, x: usize| {
            let (left, right) = (x.saturating_sub(1), (x + 1).min(from.ncols() - 1));
            (0.5 * (from[(y, right)] - from[(y, left)])).powi(2)
        };
        let fine = Array2::from_shape_fn(small.dim(), |(y, x)| {
            let four = [(0, 0), (0, 1), (1, 0), (1, 1)];
            0.25 * four.iter().map(|(dy, dx)| slope(&looked, 2 * y + dy, 2 * x + dx)).sum::<f32>()
        });
        let coarse = Array2::from_shape_fn(small.dim(), |(y, x)| slope(&small, y, x));
        let bytes = photo.as_standard_layout();
        let bytes = bytes.as_slice().unwrap_or_default();
        let clipped = bytes.chunks_exact(3).filter(|p| p.iter().any(|c| *c >= CLIPPED)).count();
        let pixels = *blake3::hash(bytes).as_bytes();
        let clipped = clipped as f64 / (height * width).max(1) as f64;
        Self { gray: small, fine, coarse, clipped, factor: 2 * side, pixels }
    }
}

/// Means over squares of `side` pixels; what is left at the right and lower edge is cut off.
fn shrunk(picture: &Array2<f32>, side: usize) -> Array2<f32> {
    let (height, width) = picture.dim();
    Array2::from_shape_fn((height / side, width / side), |(y, x)| {
        let mut sum = 0.0;
        for row in 0..side {
            for column in 0..side {
                sum += picture[(y * side + row, x * side + column)];
            }
        }
        sum / (side * side) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A random print of cells of `cell` px, blurred by a Gaussian of `sigma` px.
    fn print(cell: usize, sigma: f64) -> Picture {
        let value = |y: usize, x: usize| {
            let hash = (y / cell * 7919 + x / cell * 104_729 + 13).wrapping_mul(2_654_435_761) >> 16;
            if hash.is_multiple_of(2) { 40.0 } else { 210.0 }
        };
        let reach = (4.0 * sigma).ceil() as isize;
        let weight = |d: isize| if sigma > 0.0 { (-0.5 * (d as f64 / sigma).powi(2)).exp() } else { 1.0 };
        let sum: f64 = (-reach..=reach).map(weight).sum();
        let row = |y: usize, x: usize| {
            let at = |d: isize| (x as isize + d).clamp(0, 967) as usize;
            (-reach..=reach).map(|d| weight(d) * value(y, at(d))).sum::<f64>() / sum
        };
        Picture::from_shape_fn((90, 968, 3), |(y, x, _)| row(y, x).round() as u8)
    }

    #[test]
    fn slopes_tell_blur() {
        let ratio = |sigma: f64| {
            let glance = Glance::at(&print(5, sigma));
            glance.fine.sum() / glance.coarse.sum()
        };
        let (sharp, blurred, soft) = (ratio(0.0), ratio(1.0), ratio(2.0));
        assert!(
            sharp > 0.6 && (0.40..0.50).contains(&blurred) && (0.28..0.42).contains(&soft),
            "{sharp} {blurred} {soft}"
        );
    }

    #[test]
    fn large_photographs_are_looked_at_small() {
        let photo = Picture::from_elem((300, 3872, 3), 255);
        let glance = Glance::at(&photo);
        assert_eq!((glance.factor, glance.gray.dim(), glance.clipped), (8, (37, 484), 1.0));
        assert_eq!(glance.pixels, Glance::at(&photo.clone()).pixels);
        assert_eq!(Glance::at(&Picture::zeros((1, 1, 3))).gray.len(), 0);
    }
}
