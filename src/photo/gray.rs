//! Gray photographs of 8 bits: 0.299 R + 0.587 G + 0.114 B, rounded.

use super::Picture;
use super::colour::GRAY;
use ndarray::{Array2, Axis};

/// Gray values (y, x) of a photograph.
pub fn gray(picture: &Picture) -> Array2<u8> {
    picture.map_axis(Axis(2), |p| {
        (GRAY[0] * f32::from(p[0]) + GRAY[1] * f32::from(p[1]) + GRAY[2] * f32::from(p[2])).round() as u8
    })
}
