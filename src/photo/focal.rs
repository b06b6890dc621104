//! The focal length that a camera wrote into its photograph (EXIF).

use std::io::Cursor;

/// Diagonal of a 35 mm film's picture, mm.
const FILM_DIAGONAL_MM: f64 = 43.267;

/// Focal length in px of a photograph of that width and height, by its FocalLengthIn35mmFilm; `None` where the camera did
/// not say. It is written in whole mm, and some cameras count by the width instead of the diagonal: good to some per cent.
pub fn focal_px(bytes: &[u8], width: usize, height: usize) -> Option<f64> {
    let exif = exif::Reader::new().read_from_container(&mut Cursor::new(bytes)).ok()?;
    let film_mm = exif.get_field(exif::Tag::FocalLengthIn35mmFilm, exif::In::PRIMARY)?.value.get_uint(0)?;
    (1..=2000).contains(&film_mm).then(|| f64::from(film_mm) / FILM_DIAGONAL_MM * (width as f64).hypot(height as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_photograph_says_nothing() {
        assert_eq!(focal_px(&[], 10, 10), None);
        assert_eq!(focal_px(b"II*\0 cut off", 10, 10), None);
    }
}
