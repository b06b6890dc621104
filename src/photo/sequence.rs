//! What photographs say of themselves, held against each other: one camera, one format, one order.

use super::decode::{Head, head};
use super::metadata::{Metadata, Moment};
use crate::error::Result;
use std::collections::BTreeMap;
use std::path::Path;

/// What one photograph says.
#[derive(Debug, Clone)]
pub struct Told {
    /// Its file's name.
    pub name: String,
    /// Format, size, orientation.
    pub head: Head,
    /// When it was taken, where the camera said.
    pub taken: Option<Moment>,
}

impl Told {
    /// What the photograph at `path`, whose last part is its name, says.
    ///
    /// # Errors
    /// Where its head cannot be read.
    pub fn of(bytes: &[u8], path: &Path) -> Result<Self> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let taken = Metadata::of(bytes).and_then(|metadata| metadata.taken());
        Ok(Self { name, head: head(bytes, &path.display().to_string())?, taken })
    }
}

/// Photographs of a rarer format that a warning names.
const MOST_NAMED: usize = 5;

/// What a person should know of photographs in capture order; `has_camera_file` where lens and poses come from
/// elsewhere and could mean the pixels as stored.
pub fn doubts(photographs: &[Told], has_camera_file: bool) -> Vec<String> {
    let turned = if has_camera_file { turned(photographs) } else { None };
    [order(photographs), formats(photographs), turned].into_iter().flatten().collect()
}

/// The first photograph that was taken before the one ahead of it.
fn order(photographs: &[Told]) -> Option<String> {
    let mut before: Option<(&Told, Moment)> = None;
    for told in photographs {
        let Some(taken) = told.taken else { continue };
        if let Some((ahead, time)) = before.filter(|(_, time)| taken < *time) {
            return Some(format!(
                "names and times disagree: `{}` ({taken}) was taken before `{}` ({time}), but its name comes after; \
                 photographs are used in the order of their names, which must be that of the turning table",
                told.name, ahead.name
            ));
        }
        before = Some((told, taken));
    }
    None
}

/// Formats or depths that differ: often pictures that are not the camera's.
fn formats(photographs: &[Told]) -> Option<String> {
    let mut by_format: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for told in photographs {
        by_format.entry(&told.head.format).or_default().push(&told.name);
    }
    if by_format.len() < 2 {
        return None;
    }
    let (most, _) = by_format.iter().max_by_key(|(_, names)| names.len())?;
    let most = *most;
    let of = |(format, names): (&&str, &Vec<&str>)| {
        if *format == most {
            return format!("{} {format}", names.len());
        }
        let named: Vec<String> = names.iter().take(MOST_NAMED).map(|name| format!("`{name}`")).collect();
        let more = if names.len() > MOST_NAMED { ", ..." } else { "" };
        format!("{} {format} ({}{more})", names.len(), named.join(", "))
    };
    let listed: Vec<String> = by_format.iter().map(of).collect();
    Some(format!("the photographs are of several formats: {}; do all come from the camera alike?", listed.join(", ")))
}

/// Orientations that turn a picture and leave its size.
fn turned(photographs: &[Told]) -> Option<String> {
    let first = photographs.iter().find(|told| (2..=4).contains(&told.head.orientation))?;
    Some(format!(
        "`{}` is turned upright, as its EXIF orientation {} says: the camera file must speak of the upright picture",
        first.name, first.head.orientation
    ))
}

#[cfg(test)]
mod tests {
    use super::super::Metadata;
    use super::super::metadata::tests::exif;
    use super::*;
    use ::exif::{Tag, Value};

    fn told(name: &str, format: &str, orientation: u8, time: Option<&str>) -> Told {
        let taken = time.and_then(|time| {
            let time = Value::Ascii(vec![format!("2024:05:01 {time}").into_bytes()]);
            Metadata::of(&exif(&[(Tag::DateTimeOriginal, time)]))?.taken()
        });
        Told { name: name.into(), head: Head { format: format.into(), size: (6, 4), orientation }, taken }
    }

    #[test]
    fn the_first_that_is_out_of_time_is_named() {
        let shot = |name: &str, time: &str| told(name, "JPEG", 1, Some(time));
        // A counter that began anew.
        let wrapped = [
            shot("DSC1.jpg", "12:00:09"),
            shot("DSC2.jpg", "12:00:12"),
            shot("DSC9.jpg", "12:00:05"),
            shot("E.jpg", "1:00:00"),
        ];
        let doubts = doubts(&wrapped, false);
        assert_eq!(doubts.len(), 1);
        assert!(
            doubts[0].contains("`DSC9.jpg` (2024-05-01 12:00:05) was taken before `DSC2.jpg` (2024-05-01 12:00:12)")
        );
        // Photographs in one second, and such as do not say, disagree with nothing.
        let even = [shot("a", "12:00:05"), told("b", "JPEG", 1, None), shot("c", "12:00:05"), shot("d", "12:00:06")];
        assert!(super::doubts(&even, true).is_empty());
        let across = [shot("a", "12:00:05"), told("b", "JPEG", 1, None), shot("c", "12:00:04")];
        assert!(super::doubts(&across, true)[0].contains("before `a`"));
    }

    #[test]
    fn rarer_formats_are_named() {
        let mut all: Vec<Told> = (0..9).map(|n| told(&format!("{n}.jpg"), "JPEG", 1, None)).collect();
        assert!(doubts(&all, true).is_empty());
        all.push(told("x.tif", "16-bit TIFF", 1, None));
        let doubts = doubts(&all, true);
        assert!(doubts[0].contains("1 16-bit TIFF (`x.tif`), 9 JPEG;"), "{doubts:?}");
    }

    #[test]
    fn a_turn_that_keeps_the_size_is_told_of_where_a_file_gives_the_cameras() {
        let all = [told("a.jpg", "JPEG", 1, None), told("b.jpg", "JPEG", 3, None)];
        assert!(doubts(&all, false).is_empty());
        assert!(doubts(&all, true)[0].contains("`b.jpg`") && doubts(&all, true)[0].contains("orientation 3"));
        // Where width and height change places the sizes tell.
        assert!(doubts(&[told("a.jpg", "JPEG", 6, None)], true).is_empty());
    }
}
