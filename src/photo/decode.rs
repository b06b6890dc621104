//! Photographs from bytes: JPEG, PNG, TIFF of any depth and colour, as 8-bit RGB.
//!
//! Gray becomes R = G = B; alpha is dropped; 16-bit values are rounded to 8 (`(v + 128) / 257`, floating
//! point through 0..1). The pixels are taken as stored: a photograph whose EXIF orientation says that it is to
//! be turned is refused, because its calibration could mean either the stored or the turned picture.

use super::Picture;
use crate::error::{Error, Result};
use image::{DynamicImage, ImageReader};
use std::io::Cursor;

/// Decodes one photograph; `name` is what error messages call it.
///
/// # Errors
/// Where the bytes are empty, truncated, no JPEG, PNG or TIFF, or the EXIF orientation is not 1.
pub fn decode(bytes: &[u8], name: &str) -> Result<Picture> {
    if bytes.is_empty() {
        return Err(Error::failed(format!("photograph `{name}` is empty"))
            .help("the copy from the camera may have been interrupted; copy the file again"));
    }
    check_orientation(bytes, name)?;
    let reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().expect("a cursor never fails to read");
    let Some(format) = reader.format() else {
        return Err(Error::failed(format!("photograph `{name}` is not a JPEG, PNG or TIFF picture"))
            .help("convert it (camera raw files too) to TIFF or JPEG, or leave it out of the list of photographs"));
    };
    let image = reader.decode().map_err(|cause| {
        Error::failed(format!("photograph `{name}` cannot be decoded as {format:?}: {cause}"))
            .help("the file is damaged, truncated or of an unusual kind; copy it again or save it anew as TIFF or JPEG")
    })?;
    // `zune`-style decoders fill what is missing with gray: a JPEG must have its end marker.
    if format == image::ImageFormat::Jpeg && !bytes.windows(2).rev().take(4096).any(|pair| pair == [0xFF, 0xD9]) {
        return Err(Error::failed(format!("photograph `{name}` is truncated: its end-of-image marker is missing"))
            .help("copy the file again"));
    }
    let (width, height) = (image.width() as usize, image.height() as usize);
    Ok(Picture::from_shape_vec((height, width, 3), rgb8(image)).expect("three bytes a pixel"))
}

/// The pixels as R, G, B bytes.
fn rgb8(image: DynamicImage) -> Vec<u8> {
    let to8 = |v: u16| ((u32::from(v) + 128) / 257) as u8;
    match image {
        DynamicImage::ImageRgb8(rgb) => rgb.into_raw(),
        DynamicImage::ImageLuma16(gray) => gray.into_raw().into_iter().flat_map(|v| [to8(v); 3]).collect(),
        DynamicImage::ImageRgb16(rgb) => rgb.into_raw().into_iter().map(to8).collect(),
        other => other.into_rgb8().into_raw(),
    }
}

/// Refuses photographs that their EXIF data wants turned.
fn check_orientation(bytes: &[u8], name: &str) -> Result<()> {
    let Ok(exif) = exif::Reader::new().read_from_container(&mut Cursor::new(bytes)) else { return Ok(()) };
    let orientation =
        exif.get_field(exif::Tag::Orientation, exif::In::PRIMARY).and_then(|field| field.value.get_uint(0));
    match orientation {
        None | Some(0 | 1) => Ok(()),
        Some(turn) => Err(Error::failed(format!("photograph `{name}` asks to be turned (EXIF orientation {turn})"))
            .help("turn the pixels for good, e.g. `exiftran -a -i *.jpg` or `mogrify -auto-orient *.jpg`, and calibrate the turned pictures; or, if the cameras were calibrated on the pixels as stored, clear the tag: `exiftool -Orientation=1 -n *.jpg`")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{GrayImage, ImageBuffer, ImageFormat, Luma, Rgb, RgbImage};

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn colourful() -> DynamicImage {
        RgbImage::from_fn(32, 24, |x, y| Rgb([x as u8 * 7, y as u8 * 9, 40])).into()
    }

    #[test]
    fn png_tiff_and_jpeg_keep_their_pixels() {
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            let picture = decode(&encoded(&colourful(), format), "a").unwrap();
            assert_eq!(picture.dim(), (24, 32, 3));
            assert_eq!([picture[[3, 5, 0]], picture[[3, 5, 1]], picture[[3, 5, 2]]], [35, 27, 40]);
        }
        let jpeg = decode(&encoded(&colourful(), ImageFormat::Jpeg), "a").unwrap();
        assert!((i32::from(jpeg[[12, 16, 0]]) - 112).abs() < 12);
    }

    #[test]
    fn gray_and_sixteen_bits_become_rgb8() {
        let gray: DynamicImage = GrayImage::from_pixel(4, 4, Luma([77])).into();
        assert!(decode(&encoded(&gray, ImageFormat::Png), "a").unwrap().iter().all(|&v| v == 77));
        let deep: DynamicImage = ImageBuffer::<Luma<u16>, Vec<u16>>::from_pixel(4, 4, Luma([77 * 257 + 100])).into();
        assert!(decode(&encoded(&deep, ImageFormat::Tiff), "a").unwrap().iter().all(|&v| v == 77));
        let deep: DynamicImage = ImageBuffer::<Rgb<u16>, Vec<u16>>::from_pixel(4, 4, Rgb([257, 514, 65535])).into();
        let picture = decode(&encoded(&deep, ImageFormat::Png), "a").unwrap();
        assert_eq!([picture[[0, 0, 0]], picture[[0, 0, 1]], picture[[0, 0, 2]]], [1, 2, 255]);
    }

    #[test]
    fn bad_files_say_what_is_wrong() {
        assert!(decode(b"", "x.jpg").unwrap_err().message.contains("`x.jpg` is empty"));
        assert!(decode(b"hello, not a picture", "x.jpg").unwrap_err().message.contains("not a JPEG"));
        for format in [ImageFormat::Jpeg, ImageFormat::Png, ImageFormat::Tiff] {
            let whole = encoded(&colourful(), format);
            for keep in [whole.len() / 3, whole.len() / 2, whole.len() * 9 / 10] {
                assert!(decode(&whole[..keep], "x").is_err(), "{format:?} cut to {keep} of {} passed", whole.len());
            }
        }
    }

    #[test]
    fn turned_photographs_are_refused() {
        // A JPEG with an APP1 segment: little-endian TIFF header, one entry, orientation 6.
        let jpeg = encoded(&colourful(), ImageFormat::Jpeg);
        let exif = |turn: u8| {
            let mut segment = b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0".to_vec();
            segment.extend([turn, 0, 0, 0, 0, 0, 0, 0]);
            let length = (segment.len() + 2) as u16;
            let mut bytes = jpeg[..2].to_vec();
            bytes.extend([0xFF, 0xE1]);
            bytes.extend(length.to_be_bytes());
            bytes.extend(segment);
            bytes.extend(&jpeg[2..]);
            bytes
        };
        assert!(decode(&exif(1), "x.jpg").is_ok());
        let error = decode(&exif(6), "x.jpg").unwrap_err();
        assert!(error.message.contains("orientation 6") && error.help.is_some());
    }
}
