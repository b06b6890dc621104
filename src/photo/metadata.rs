//! What a camera wrote beside its picture (EXIF): which way is up, the focal length, the time.

use exif::{Context, DateTime, Exif, Field, In, Reader, Tag, Value};
use std::fmt;
use std::io::Cursor;

/// Diagonal of a 35 mm film's picture, mm.
const FILM_DIAGONAL_MM: f64 = 43.267;

/// The EXIF data of a JPEG, PNG, TIFF, WebP or HEIF file, as far as they can be read.
pub struct Metadata(Exif);

impl Metadata {
    /// `None` where the file holds none.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let read = Reader::new().continue_on_error(true).read_from_container(&mut Cursor::new(bytes));
        read.or_else(|e| e.distill_partial_result(|_| ())).ok().map(Self)
    }

    fn field(&self, tag: Tag) -> Option<&Field> {
        self.0.get_field(tag, In::PRIMARY)
    }

    fn number(&self, tag: Tag) -> Option<u32> {
        self.field(tag)?.value.get_uint(0)
    }

    /// The number under a TIFF tag of the main picture.
    pub(super) fn tiff(&self, tag: u16) -> Option<u32> {
        self.number(Tag(Context::Tiff, tag))
    }

    /// How the stored pixels are to be turned, 1..=8 of the EXIF standard.
    pub fn orientation(&self) -> Option<u8> {
        self.number(Tag::Orientation).and_then(|turn| u8::try_from(turn).ok()).filter(|turn| (1..=8).contains(turn))
    }

    /// Focal length in px of a photograph of that width and height, by its FocalLengthIn35mmFilm; `None` where the
    /// camera did not say. It is written in whole mm, and some cameras count by the width instead of the diagonal:
    /// good to some per cent.
    pub fn focal_px(&self, width: usize, height: usize) -> Option<f64> {
        let film_mm = self.number(Tag::FocalLengthIn35mmFilm)?;
        let diagonal_px = (width as f64).hypot(height as f64);
        (1..=2000).contains(&film_mm).then(|| f64::from(film_mm) / FILM_DIAGONAL_MM * diagonal_px)
    }

    /// When the photograph was taken, by the camera's clock.
    pub fn taken(&self) -> Option<Moment> {
        let text = |tag: Tag| match &self.field(tag)?.value {
            Value::Ascii(lines) => lines.first().cloned(),
            _ => None,
        };
        // A clock that was never set leaves blanks or zeros.
        let t = DateTime::from_ascii(&text(Tag::DateTimeOriginal)?).ok().filter(|t| t.month > 0)?;
        let fraction = text(Tag::SubSecTimeOriginal).or_else(|| text(Tag::SubSecTime)).unwrap_or_default();
        // Digits after the point: 5 and 500 are the same half second.
        let digits = fraction.iter().take_while(|d| d.is_ascii_digit()).map(|d| u32::from(d - b'0'));
        let nanosecond = digits.chain(std::iter::repeat(0)).take(9).fold(0, |n, d| 10 * n + d);
        Some(Moment { date: (t.year, t.month, t.day), time: (t.hour, t.minute, t.second), nanosecond })
    }
}

/// A time as a camera writes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment {
    date: (u16, u8, u8),
    time: (u8, u8, u8),
    nanosecond: u32,
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ((year, month, day), (hour, minute, second)) = (self.date, self.time);
        write!(f, "{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}")?;
        if self.nanosecond > 0 { write!(f, ".{:03}", self.nanosecond / 1_000_000) } else { Ok(()) }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use exif::experimental::Writer;

    /// EXIF data (a TIFF structure) with these fields.
    pub(crate) fn exif(fields: &[(Tag, Value)]) -> Vec<u8> {
        let fields: Vec<Field> =
            fields.iter().map(|(tag, value)| Field { tag: *tag, ifd_num: In::PRIMARY, value: value.clone() }).collect();
        let mut writer = Writer::new();
        fields.iter().for_each(|field| writer.push_field(field));
        let mut tiff = Cursor::new(Vec::new());
        writer.write(&mut tiff, true).unwrap();
        tiff.into_inner()
    }

    fn moment(time: &str, fraction: Option<&str>) -> Option<Moment> {
        let ascii = |text: &str| Value::Ascii(vec![text.as_bytes().to_vec()]);
        let mut fields = vec![(Tag::DateTimeOriginal, ascii(time))];
        fields.extend(fraction.map(|f| (Tag::SubSecTimeOriginal, ascii(f))));
        Metadata::of(&exif(&fields)).unwrap().taken()
    }

    #[test]
    fn no_photograph_says_nothing() {
        assert!(Metadata::of(&[]).is_none());
        assert!(Metadata::of(b"II*\0 cut off").is_none_or(|m| m.focal_px(10, 10).is_none()));
    }

    #[test]
    fn the_focal_length_does_not_ask_which_way_is_up() {
        let metadata = Metadata::of(&exif(&[(Tag::FocalLengthIn35mmFilm, Value::Short(vec![50]))])).unwrap();
        let focal_px = metadata.focal_px(3000, 2000).unwrap();
        assert!((focal_px - 50.0 / 43.267 * 13e6_f64.sqrt()).abs() < 1e-9, "{focal_px}");
        assert_eq!(metadata.focal_px(2000, 3000), Some(focal_px));
    }

    #[test]
    fn times_compare_by_fractions_of_a_second() {
        let at = |fraction| moment("2024:05:01 12:00:03", fraction).unwrap();
        assert!(at(None) < at(Some("05")) && at(Some("05")) < at(Some("5")) && at(Some("5")) < at(Some("51")));
        assert_eq!(at(Some("5")), at(Some("500  ")));
        assert!(at(Some("999")) < moment("2024:05:01 12:00:04", None).unwrap());
        assert_eq!(at(Some("25")).to_string(), "2024-05-01 12:00:03.250");
        assert_eq!(moment("0000:00:00 00:00:00", None).map(|m| m.to_string()), None);
        assert_eq!(moment("    :  :     :  :  ", None), None);
    }
}
