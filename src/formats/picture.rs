//! Pictures as JPEG and PNG bytes.

use crate::error::{Error, Result};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};
use ndarray::ArrayView3;
use std::fmt::Display;

/// The picture (y, x, rgb) as JPEG of that quality (1 to 100), its colours at half resolution (4:2:0): for pictures to
/// look at, of which a run writes one per photograph.
///
/// # Errors
/// Where the picture is empty or larger than JPEG allows (65,535 px).
pub fn jpeg(picture: ArrayView3<u8>, quality: u8) -> Result<Vec<u8>> {
    let (height, width, channels) = picture.dim();
    let fault =
        |why: &dyn Display| Error::failed(format!("cannot write a picture of {width} x {height} px as JPEG: {why}"));
    let size = |n: usize| u16::try_from(n).map_err(|e| fault(&e));
    if channels != 3 {
        return Err(fault(&"it must hold RGB pixels"));
    }
    let pixels = picture.as_standard_layout();
    let pixels = pixels.as_slice().ok_or_else(|| fault(&"its pixels are not contiguous"))?;
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, quality);
    encoder.set_sampling_factor(SamplingFactor::R_4_2_0);
    encoder.encode(pixels, size(width)?, size(height)?, ColorType::Rgb).map_err(|e| fault(&e))?;
    Ok(bytes)
}

/// The picture (y, x, rgb) as PNG.
///
/// # Errors
/// Where the picture is empty.
pub fn png(picture: ArrayView3<u8>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode(picture, PngEncoder::new(&mut bytes))?;
    Ok(bytes)
}

pub(super) fn encode(picture: ArrayView3<u8>, encoder: impl ImageEncoder) -> Result<()> {
    let (height, width, channels) = picture.dim();
    let fault = |why: &dyn Display| Error::failed(format!("cannot write a picture of {width} x {height} px: {why}"));
    if channels != 3 || width == 0 || height == 0 {
        return Err(fault(&"it must hold RGB pixels"));
    }
    let size = |n: usize| u32::try_from(n).map_err(|e| fault(&e));
    let pixels = picture.as_standard_layout();
    let pixels = pixels.as_slice().ok_or_else(|| fault(&"its pixels are not contiguous"))?;
    encoder.write_image(pixels, size(width)?, size(height)?, ExtendedColorType::Rgb8).map_err(|e| fault(&e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    #[test]
    fn a_jpeg_shows_the_picture() {
        let picture = Array3::from_shape_fn((37, 50, 3), |(y, x, c)| (3 * x + y + 20 * c) as u8);
        let read = image::load_from_memory(&jpeg(picture.view(), 85).unwrap()).unwrap().into_rgb8();
        assert_eq!(read.dimensions(), (50, 37));
        for (x, y, pixel) in read.enumerate_pixels() {
            for c in 0..3 {
                assert!(pixel[c].abs_diff(picture[[y as usize, x as usize, c]]) < 12, "{x} {y} {pixel:?}");
            }
        }
    }

    #[test]
    fn pictures_that_are_none_are_refused() {
        for shape in [(0, 4, 3), (4, 0, 3), (4, 4, 2), (1, 70_000, 3)] {
            assert!(jpeg(Array3::zeros(shape).view(), 85).is_err(), "{shape:?}");
        }
    }
}
