//! Photographs as the COLMAP program is handed them: it neither turns them upright nor reads every format.

use crate::error::Result;
use crate::flow::Inputs;
use crate::formats::colmap::command::Intrinsics;
use crate::formats::picture;
use crate::photo::{self, Metadata};
use std::path::Path;

/// A photograph to be handed over.
pub(super) struct Handed {
    /// Its name in the study.
    pub name: String,
    /// Ending that its bytes deserve.
    pub ending: String,
    /// Its file: as it is where the program can take it so, else a PNG of the upright picture.
    pub bytes: Vec<u8>,
}

/// The photographs of a study.
pub(super) struct Photographs {
    /// In capture order.
    pub photos: Vec<Handed>,
    /// The camera to begin with: told where files were written anew without their EXIF data.
    pub lens: Intrinsics,
}

impl Photographs {
    /// Those of the port `photos`, by the study's names.
    ///
    /// # Errors
    /// Where one cannot be read.
    pub(super) fn of(names: &[String], inputs: &Inputs) -> Result<Self> {
        let (mut photos, mut lens) = (Vec::with_capacity(names.len()), None);
        for (name, file) in names.iter().zip(inputs.many("photos")) {
            let (handed, begin) = handed(name, file.bytes("file")?)?;
            lens = lens.or(begin);
            photos.push(handed);
        }
        Ok(Self { photos, lens: lens.map_or(Intrinsics::Exif, Intrinsics::Begin) })
    }
}

fn handed(name: &str, bytes: Vec<u8>) -> Result<(Handed, Option<[f64; 4]>)> {
    let head = photo::head(&bytes, name)?;
    let name = name.to_owned();
    if head.orientation == 1 && !head.format.ends_with("WebP") {
        let ending = Path::new(&name).extension().map_or_else(|| "jpg".into(), |e| e.to_string_lossy().to_lowercase());
        return Ok((Handed { name, ending, bytes }, None));
    }
    let (width, height) = head.size;
    let focal_px = Metadata::of(&bytes).and_then(|metadata| metadata.focal_px(width, height));
    let lens = focal_px.map(|focal_px| [focal_px, width as f64 / 2.0, height as f64 / 2.0, 0.0]);
    let upright = photo::decode(&bytes, &name)?.into_picture();
    Ok((Handed { name, ending: "png".into(), bytes: picture::png(upright.view())? }, lens))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photo::Picture;
    use crate::photo::metadata::tests::exif;
    use exif::{Tag, Value};
    use image::codecs::png::PngEncoder;
    use image::{ExtendedColorType, ImageEncoder};

    fn png(picture: &Picture, orientation: u16) -> Vec<u8> {
        let tags = [(Tag::Orientation, orientation), (Tag::FocalLengthIn35mmFilm, 50)];
        let (mut bytes, (height, width, _)) = (Vec::new(), picture.dim());
        let mut encoder = PngEncoder::new(&mut bytes);
        encoder.set_exif_metadata(exif(&tags.map(|(tag, n)| (tag, Value::Short(vec![n]))))).unwrap();
        let pixels = picture.as_slice().unwrap();
        encoder.write_image(pixels, width as u32, height as u32, ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    #[test]
    fn only_what_must_be_is_written_anew() {
        let picture = Picture::from_shape_fn((4, 6, 3), |(y, x, c)| (y * 7 + x * 3 + c * 40) as u8);
        let (same, lens) = handed("a.PNG", png(&picture, 1)).unwrap();
        assert!(same.bytes == png(&picture, 1) && same.ending == "png" && lens.is_none());

        let (upright, lens) = handed("a.PNG", png(&picture, 6)).unwrap();
        assert_eq!(photo::head(&upright.bytes, "a").unwrap().orientation, 1);
        let read = photo::decode(&upright.bytes, "a").unwrap().into_picture();
        assert_eq!(read.dim(), (6, 4, 3));
        for ((y, x, c), value) in read.indexed_iter() {
            assert_eq!(*value, picture[[3 - x, y, c]]);
        }
        let [focal_px, cx, cy, k] = lens.unwrap();
        assert!((focal_px - 50.0 / 43.267 * 52_f64.sqrt()).abs() < 1e-9);
        assert_eq!([cx, cy, k], [2.0, 3.0, 0.0]);
    }
}
