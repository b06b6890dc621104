//! Pictures made smaller, to look at.

use super::Picture;
use crate::error::{Error, Result};
use image::RgbImage;
use image::imageops::{FilterType, resize};
use ndarray::Array3;

/// The picture with a longer side of `longest_px` at most; as it is where it is no longer. Each new pixel is the mean of those
/// about its place, weighted by a triangle.
///
/// # Errors
/// Where the picture does not hold RGB pixels.
pub fn shrink(picture: Picture, longest_px: usize) -> Result<Picture> {
    let (height, width, channels) = picture.dim();
    let longest = height.max(width);
    if longest <= longest_px {
        return Ok(picture);
    }
    let fault = || Error::failed(format!("a picture of {width} x {height} px and {channels} channels is not RGB"));
    let size = |n: usize| u32::try_from(n).map_err(|_| fault());
    let side = |n: usize| size(((n * longest_px + longest / 2) / longest).max(1));
    let pixels = picture.as_standard_layout().into_owned().into_raw_vec_and_offset().0;
    let whole = RgbImage::from_raw(size(width)?, size(height)?, pixels).filter(|_| channels == 3).ok_or_else(fault)?;
    let small = resize(&whole, side(width)?, side(height)?, FilterType::Triangle);
    let shape = (small.height() as usize, small.width() as usize, 3);
    Array3::from_shape_vec(shape, small.into_raw()).map_err(|_| fault())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_and_mean_are_kept() {
        let picture = Array3::from_shape_fn((30, 80, 3), |(y, x, c)| (2 * x + y + 5 * c) as u8);
        assert_eq!(shrink(picture.clone(), 80).unwrap(), picture);
        let small = shrink(picture.clone(), 40).unwrap();
        assert_eq!(small.dim(), (15, 40, 3));
        for ((y, x, c), &value) in
            small.indexed_iter().filter(|((y, x, _), _)| (1..14).contains(y) && (1..39).contains(x))
        {
            // The middle of the 2 x 2 pixels that it covers, of a slope of 2 per column and 1 per row.
            let mean = 2.0 * (2 * x) as f64 + 1.0 + (2 * y) as f64 + 0.5 + 5.0 * c as f64;
            assert!((f64::from(value) - mean).abs() <= 1.0, "{y} {x} {c}: {value} against {mean}");
        }
        assert_eq!(shrink(Array3::zeros((1, 900, 3)), 100).unwrap().dim(), (1, 100, 3));
        assert!(shrink(Array3::zeros((9, 9, 2)), 4).is_err());
    }
}
