//! Photographs of a simulated capture as files of a camera: JPEG or PNG with the focal length in their EXIF data.

use super::picture;
use crate::error::{Error, Result};
use crate::simulation::PictureFormat;
use exif::experimental::Writer;
use exif::{Field, In, Rational, Tag, Value};
use image::ImageEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::png::PngEncoder;
use ndarray::ArrayView3;
use std::io::Cursor;

/// The photograph (y, x, rgb) as bytes of a file. The EXIF data say that the sensor is 36 mm wide, so that
/// FocalLength and FocalLengthIn35mmFilm agree. JPEG keeps full colour resolution (4:4:4).
///
/// # Errors
/// Where the picture is empty or too large for the format.
pub fn photograph(picture: ArrayView3<u8>, format: PictureFormat, quality: u8, focal_35mm: f64) -> Result<Vec<u8>> {
    let exif = exif_of(focal_35mm)?;
    let refused = |e| Error::failed(format!("cannot write EXIF data: {e}"));
    let mut bytes = Vec::new();
    match format {
        PictureFormat::Jpeg => {
            let mut encoder = JpegEncoder::new_with_quality(&mut bytes, quality);
            encoder.set_exif_metadata(exif).map_err(refused)?;
            picture::encode(picture, encoder)?;
        }
        PictureFormat::Png => {
            let mut encoder = PngEncoder::new(&mut bytes);
            encoder.set_exif_metadata(exif).map_err(refused)?;
            picture::encode(picture, encoder)?;
        }
    }
    Ok(bytes)
}

/// EXIF data (a TIFF structure) that hold the focal length.
fn exif_of(focal_35mm: f64) -> Result<Vec<u8>> {
    let hundredths = Rational { num: (focal_35mm * 100.0).round() as u32, denom: 100 };
    let fields = [
        Field { tag: Tag::Software, ifd_num: In::PRIMARY, value: Value::Ascii(vec![b"rootvox simulate".to_vec()]) },
        Field { tag: Tag::FocalLength, ifd_num: In::PRIMARY, value: Value::Rational(vec![hundredths]) },
        Field {
            tag: Tag::FocalLengthIn35mmFilm,
            ifd_num: In::PRIMARY,
            value: Value::Short(vec![focal_35mm.round().clamp(1.0, 65535.0) as u16]),
        },
    ];
    let mut writer = Writer::new();
    for field in &fields {
        writer.push_field(field);
    }
    let mut tiff = Cursor::new(Vec::new());
    writer.write(&mut tiff, true).map_err(|e| Error::failed(format!("cannot write EXIF data: {e}")))?;
    Ok(tiff.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    #[test]
    fn pixels_and_focal_length_come_back() {
        let picture = Array3::from_shape_fn((20, 30, 3), |(y, x, c)| (y * 7 + x * 3 + c * 40) as u8);
        for format in [PictureFormat::Png, PictureFormat::Jpeg] {
            let bytes = photograph(picture.view(), format, 95, 36.5).unwrap();
            let read = image::load_from_memory(&bytes).unwrap().to_rgb8();
            let worst = read.as_raw().iter().zip(picture.iter()).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
            assert!(worst <= if format == PictureFormat::Png { 0 } else { 24 }, "{worst}");
            let data = exif::Reader::new().read_from_container(&mut Cursor::new(&bytes)).unwrap();
            let focal = data.get_field(Tag::FocalLength, In::PRIMARY).unwrap();
            assert!(matches!(&focal.value, Value::Rational(v) if (v[0].to_f64() - 36.5).abs() < 1e-9));
        }
    }
}
