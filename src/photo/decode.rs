//! Photographs from bytes: JPEG, PNG, TIFF (BigTIFF too), WebP of any depth and colour, as RGB of 8 or 16 bits.
//!
//! Gray becomes R = G = B; alpha is dropped; floating point goes by way of 0..1 to 16 bits. A photograph whose EXIF
//! orientation says that it is to be turned is turned: all sizes and pixels are those of the upright picture. What
//! stands behind the end of a JPEG is left alone.

use super::foreign;
use super::jpeg_end::jpeg_end;
use super::metadata::Metadata;
use super::photograph::Photograph;
use crate::error::{Error, Result};
use image::metadata::Orientation;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use ndarray::Array3;
use std::io::Cursor;

/// Memory that a photograph may ask for; a header that asks for more is damaged.
const MOST_BYTES: u64 = 8 << 30;

/// What a photograph's file says of it, without its pixels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Head {
    /// Its format, such as `16-bit TIFF`.
    pub format: String,
    /// Width and height of the upright picture, px.
    pub size: (usize, usize),
    /// How the stored pixels are to be turned, 1..=8 of the EXIF standard; 1 is upright.
    pub orientation: u8,
}

/// Reads the head of a photograph; `name` is what error messages call it.
///
/// # Errors
/// Where the bytes are empty, a truncated JPEG, or no JPEG, PNG, TIFF or WebP.
pub fn head(bytes: &[u8], name: &str) -> Result<Head> {
    let opened = open(bytes, name)?;
    let (width, height) = opened.decoder.dimensions();
    let (width, height) = (width as usize, height as usize);
    let orientation = opened.orientation.to_exif();
    let depth = 8 * u16::from(opened.decoder.color_type().bytes_per_pixel())
        / u16::from(opened.decoder.color_type().channel_count()).max(1);
    Ok(Head {
        format: if depth > 8 { format!("{depth}-bit {}", opened.format) } else { opened.format.to_owned() },
        size: if orientation >= 5 { (height, width) } else { (width, height) },
        orientation,
    })
}

/// Decodes one photograph; `name` is what error messages call it.
///
/// # Errors
/// Where the bytes are empty, truncated, or no JPEG, PNG, TIFF or WebP.
pub fn decode(bytes: &[u8], name: &str) -> Result<Photograph> {
    let Opened { decoder, format, orientation } = open(bytes, name)?;
    let mut image = DynamicImage::from_decoder(decoder).map_err(|cause| damaged(name, format, &cause))?;
    image.apply_orientation(orientation);
    Ok(rgb(image))
}

/// A photograph about to be decoded.
struct Opened<'a> {
    decoder: Box<dyn ImageDecoder + 'a>,
    format: &'static str,
    orientation: Orientation,
}

fn open<'a>(bytes: &'a [u8], name: &str) -> Result<Opened<'a>> {
    if bytes.is_empty() {
        return Err(Error::failed(format!("photograph `{name}` is empty"))
            .help("the copy from the camera may have been interrupted; copy the file again"));
    }
    foreign::refuse(bytes, name)?;
    let is_big_tiff = bytes.starts_with(b"II+\0") || bytes.starts_with(b"MM\0+");
    let guessed = if is_big_tiff { Ok(ImageFormat::Tiff) } else { image::guess_format(bytes) };
    let (kind, format) = match guessed {
        Ok(kind @ ImageFormat::Jpeg) => (kind, "JPEG"),
        Ok(kind @ ImageFormat::Png) => (kind, "PNG"),
        Ok(kind @ ImageFormat::Tiff) => (kind, "TIFF"),
        Ok(kind @ ImageFormat::WebP) => (kind, "WebP"),
        _ => {
            return Err(Error::failed(format!("photograph `{name}` is not a JPEG, PNG, TIFF or WebP picture"))
                .help("convert it to TIFF or JPEG, or leave it out of the list of photographs (photos.images)"));
        }
    };
    let mut bytes = bytes;
    if kind == ImageFormat::Jpeg {
        // Decoders fill what is missing with gray.
        let end = jpeg_end(bytes).ok_or_else(|| {
            Error::failed(format!("photograph `{name}` is truncated: its end-of-image marker is missing"))
                .help("copy the file again")
        })?;
        bytes = &bytes[..end];
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), kind);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let mut decoder = reader.into_decoder().map_err(|cause| damaged(name, format, &cause))?;
    // The decoder's own reading does not look behind a PNG's pixels, the other not into a BigTIFF.
    let told = Metadata::of(bytes).and_then(|metadata| metadata.orientation()).and_then(Orientation::from_exif);
    let orientation = told.or_else(|| decoder.orientation().ok()).unwrap_or(Orientation::NoTransforms);
    Ok(Opened { decoder: Box::new(decoder), format, orientation })
}

fn damaged(name: &str, format: &str, cause: &image::ImageError) -> Error {
    Error::failed(format!("photograph `{name}` cannot be decoded as {format}: {cause}"))
        .help("the file is damaged, truncated or of an unusual kind; copy it again or save it anew as TIFF or JPEG")
}

/// The pixels as R, G, B, in 8 bits where the picture has no more.
fn rgb(image: DynamicImage) -> Photograph {
    let shape = (image.height() as usize, image.width() as usize, 3);
    match image {
        DynamicImage::ImageRgb8(_)
        | DynamicImage::ImageRgba8(_)
        | DynamicImage::ImageLuma8(_)
        | DynamicImage::ImageLumaA8(_) => {
            let pixels = image.into_rgb8().into_raw();
            Photograph::Eight(Array3::from_shape_vec(shape, pixels).expect("three values a pixel"))
        }
        deeper => {
            let pixels = deeper.into_rgb16().into_raw();
            Photograph::Sixteen(Array3::from_shape_vec(shape, pixels).expect("three values a pixel"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::metadata::tests::exif;
    use super::*;
    use ::exif::{Tag, Value};
    use image::codecs::png::PngEncoder;
    use image::{GrayImage, ImageBuffer, ImageEncoder, Luma, Rgb, RgbImage};

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        image.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    fn colourful() -> DynamicImage {
        RgbImage::from_fn(32, 24, |x, y| Rgb([x as u8 * 7, y as u8 * 9, 40])).into()
    }

    #[test]
    fn png_tiff_webp_and_jpeg_keep_their_pixels() {
        for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP] {
            let Photograph::Eight(picture) = decode(&encoded(&colourful(), format), "a").unwrap() else { panic!() };
            assert_eq!(picture.dim(), (24, 32, 3));
            assert!(picture.iter().eq(colourful().into_rgb8().as_raw()));
        }
        let jpeg = decode(&encoded(&colourful(), ImageFormat::Jpeg), "a").unwrap().into_picture();
        assert!((i32::from(jpeg[[12, 16, 0]]) - 112).abs() < 12);
    }

    #[test]
    fn gray_and_sixteen_bits_become_rgb() {
        let gray: DynamicImage = GrayImage::from_pixel(4, 4, Luma([77])).into();
        let Photograph::Eight(picture) = decode(&encoded(&gray, ImageFormat::Png), "a").unwrap() else { panic!() };
        assert!(picture.iter().all(|&v| v == 77));
        for format in [ImageFormat::Png, ImageFormat::Tiff] {
            let gray: DynamicImage = ImageBuffer::<Luma<u16>, Vec<u16>>::from_pixel(4, 4, Luma([19_889])).into();
            let Photograph::Sixteen(gray) = decode(&encoded(&gray, format), "a").unwrap() else { panic!() };
            assert!(gray.iter().all(|&v| v == 19_889));
            let deep =
                ImageBuffer::<Rgb<u16>, Vec<u16>>::from_fn(4, 4, |x, y| Rgb([257, 514 + x as u16, 65535 - y as u16]));
            let values = deep.as_raw().clone();
            let bytes = encoded(&deep.into(), format);
            assert!(head(&bytes, "a").unwrap().format.starts_with("16-bit"));
            let Photograph::Sixteen(deep) = decode(&bytes, "a").unwrap() else { panic!() };
            assert!(deep.iter().eq(&values));
        }
        let bright: DynamicImage = ImageBuffer::<Rgb<f32>, Vec<f32>>::from_pixel(4, 4, Rgb([0.25, 1.5, -1.0])).into();
        let Photograph::Sixteen(bright) = decode(&encoded(&bright, ImageFormat::Tiff), "a").unwrap() else { panic!() };
        assert_eq!([bright[[0, 0, 0]], bright[[0, 0, 1]], bright[[0, 0, 2]]], [16_384, 65_535, 0]);
    }

    #[test]
    fn bad_files_say_what_is_wrong() {
        assert!(decode(b"", "x.jpg").unwrap_err().message.contains("`x.jpg` is empty"));
        assert!(decode(b"hello, not a picture", "x.jpg").unwrap_err().message.contains("not a JPEG"));
        for format in [ImageFormat::Jpeg, ImageFormat::Png, ImageFormat::Tiff, ImageFormat::WebP] {
            let whole = encoded(&colourful(), format);
            for keep in [whole.len() / 3, whole.len() / 2, whole.len() * 9 / 10] {
                assert!(decode(&whole[..keep], "x").is_err(), "{format:?} cut to {keep} of {} passed", whole.len());
            }
        }
    }

    #[test]
    fn what_stands_behind_a_jpeg_is_left_alone() {
        let jpeg = encoded(&colourful(), ImageFormat::Jpeg);
        let alone = decode(&jpeg, "x").unwrap();
        for behind in [vec![0; 100_000], jpeg.clone(), b"\0\0\0\x18ftypmp42".repeat(9000)] {
            assert_eq!(decode(&[jpeg.clone(), behind].concat(), "x").unwrap(), alone);
        }
        // A whole picture behind a truncated one mends nothing.
        let cut = [&jpeg[..jpeg.len() / 2], &[0; 9000]].concat();
        assert!(decode(&cut, "x").unwrap_err().message.contains("truncated"));
    }

    /// Pixel (y, x) of the upright picture among the stored ones of `width` x `height`: the EXIF standard's words.
    fn stored_at(orientation: u8, y: usize, x: usize, width: usize, height: usize) -> (usize, usize) {
        match orientation {
            // Row 0 and column 0 of what is stored are at the visual ...
            1 => (y, x),                          // top, left
            2 => (y, width - 1 - x),              // top, right
            3 => (height - 1 - y, width - 1 - x), // bottom, right
            4 => (height - 1 - y, x),             // bottom, left
            5 => (x, y),                          // left, top
            6 => (height - 1 - x, y),             // right, top
            7 => (height - 1 - x, width - 1 - y), // right, bottom
            _ => (x, width - 1 - y),              // left, bottom
        }
    }

    #[test]
    fn photographs_are_turned_upright() {
        let stored = colourful().into_rgb8();
        for orientation in 1..=8 {
            let data = exif(&[(Tag::Orientation, Value::Short(vec![orientation.into()]))]);
            let mut bytes = Vec::new();
            let mut encoder = PngEncoder::new(&mut bytes);
            encoder.set_exif_metadata(data).unwrap();
            encoder.write_image(stored.as_raw(), 32, 24, image::ExtendedColorType::Rgb8).unwrap();
            let Photograph::Eight(upright) = decode(&bytes, "x.png").unwrap() else { panic!() };
            let size = if orientation >= 5 { (24, 32) } else { (32, 24) };
            assert_eq!(head(&bytes, "x").unwrap(), Head { format: "PNG".into(), size, orientation });
            assert_eq!(upright.dim(), (size.1, size.0, 3));
            for ((y, x, c), &value) in upright.indexed_iter() {
                let (v, u) = stored_at(orientation, y, x, 32, 24);
                assert_eq!(value, stored.get_pixel(u as u32, v as u32)[c], "{orientation}: {y} {x}");
            }
        }
    }
}
