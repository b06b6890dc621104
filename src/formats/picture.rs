//! Pictures as JPEG and PNG bytes.

use crate::error::{Error, Result};
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use ndarray::ArrayView3;

/// The picture (y, x, rgb) as JPEG of that quality (1 to 100).
///
/// # Errors
/// Where the picture is empty or larger than JPEG allows (65,535 px).
pub fn jpeg(picture: ArrayView3<u8>, quality: u8) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    encode(picture, JpegEncoder::new_with_quality(&mut bytes, quality))?;
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
    let fault =
        |why: &dyn std::fmt::Display| Error::failed(format!("cannot write a picture of {width} x {height} px: {why}"));
    if channels != 3 || width == 0 || height == 0 {
        return Err(fault(&"it must hold RGB pixels"));
    }
    let size = |n: usize| u32::try_from(n).map_err(|e| fault(&e));
    let pixels = picture.as_standard_layout();
    let pixels = pixels.as_slice().ok_or_else(|| fault(&"its pixels are not contiguous"))?;
    encoder.write_image(pixels, size(width)?, size(height)?, ExtendedColorType::Rgb8).map_err(|e| fault(&e))
}
