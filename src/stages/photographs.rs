//! Photographs as stages take them: from files, or undistorted (member `photo`), in 8 or in 16 bits.

use super::read3;
use crate::error::{Error, Result};
use crate::optics::Lens;
use crate::photo::{self, Metadata, Photograph, Picture};
use crate::store::{Artefact, Dtype};

/// The photograph in a file, upright.
///
/// # Errors
/// As [`photo::decode`], naming the file.
pub(super) fn decoded(file: &Artefact) -> Result<Photograph> {
    photo::decode(&file.bytes("file")?, &file.path("file")?.display().to_string())
}

/// An undistorted photograph in the depth that it was taken in.
pub(super) fn undistorted(artefact: &Artefact) -> Result<Photograph> {
    let dtype = artefact.members().iter().find(|member| member.name == "photo").and_then(|member| member.dtype);
    match dtype {
        Some(Dtype::Uint16) => Ok(Photograph::Sixteen(read3(artefact, "photo")?)),
        _ => Ok(Photograph::Eight(read3(artefact, "photo")?)),
    }
}

/// An undistorted photograph in 8 bits.
pub(super) fn picture(artefact: &Artefact) -> Result<Picture> {
    undistorted(artefact).map(Photograph::into_picture)
}

/// Fails where a photograph, from a file with those bytes, is not of its lens's size.
pub(super) fn check_size(name: &str, bytes: &[u8], photograph: &Photograph, lens: &Lens) -> Result<()> {
    let (width, height) = photograph.size();
    if (width, height) == (lens.width, lens.height) {
        return Ok(());
    }
    let fault = Error::failed(format!(
        "photograph `{name}` has {width} x {height} px, but the cameras are for {} x {} px",
        lens.width, lens.height
    ));
    let turn = Metadata::of(bytes).and_then(|metadata| metadata.orientation()).unwrap_or(1);
    if turn > 1 && (height, width) == (lens.width, lens.height) {
        return Err(fault.help(format!(
            "these are sizes upright, as EXIF orientation {turn} says: give cameras for the upright picture, or, where \
             they were calibrated on the pixels as stored, clear the tag: `exiftool -Orientation=1 -n {name}`"
        )));
    }
    Err(fault.help("all photographs of a study come from one camera at one size; do not crop, scale or turn them"))
}

/// Most photographs that a message names.
const MOST_NAMED: usize = 5;

/// Fails where photographs, by name with width and height, are not all of one size.
pub(super) fn check_one_size(sizes: &[(String, (usize, usize))]) -> Result<()> {
    let count = |size: &(usize, usize)| sizes.iter().filter(|(_, other)| other == size).count();
    // Of two sizes equally frequent, that of the first photograph.
    let Some((_, (width, height))) = sizes.iter().rev().max_by_key(|(_, size)| count(size)) else { return Ok(()) };
    let odd: Vec<String> = sizes
        .iter()
        .filter(|(_, size)| size != &(*width, *height))
        .map(|(name, (w, h))| format!("`{name}` has {w} x {h} px"))
        .collect();
    if odd.is_empty() {
        return Ok(());
    }
    let more = odd.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let named = odd[..odd.len().min(MOST_NAMED)].join(", ");
    let most = count(&(*width, *height));
    Err(Error::failed(format!("{most} of {} photographs have {width} x {height} px, but {named}{more}", sizes.len()))
        .help("all photographs of a study come from one camera at one size; do not crop, scale or turn them"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Distortion;

    #[test]
    fn photographs_of_another_size_are_named() {
        let sizes = |all: &[(usize, usize)]| -> Vec<_> {
            all.iter().enumerate().map(|(n, size)| (format!("{n}.jpg"), *size)).collect()
        };
        assert!(check_one_size(&[]).is_ok() && check_one_size(&sizes(&[(6, 4); 9])).is_ok());
        let e = check_one_size(&sizes(&[(4, 6), (6, 4), (6, 4), (3, 2)])).unwrap_err().message;
        assert_eq!(e, "2 of 4 photographs have 6 x 4 px, but `0.jpg` has 4 x 6 px, `3.jpg` has 3 x 2 px");
        let e = check_one_size(&sizes(&[(6, 4), (4, 6)])).unwrap_err().message;
        assert_eq!(e, "1 of 2 photographs have 6 x 4 px, but `1.jpg` has 4 x 6 px");
        let many = [vec![(6, 4); 9], vec![(1, 1); 7]].concat();
        assert!(check_one_size(&sizes(&many)).unwrap_err().message.ends_with("`13.jpg` has 1 x 1 px and 2 more"));
    }

    #[test]
    fn a_turned_photograph_of_the_stored_size_is_told_of_the_tag() {
        let lens = Lens { width: 8, height: 6, focal_px: 9.0, cx: 3.5, cy: 2.5, distortion: Distortion::default() };
        let photograph = |width, height| Photograph::Eight(Picture::zeros((height, width, 3)));
        // Little-endian EXIF data of one entry: orientation 6.
        let turned = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0";
        assert!(check_size("a.jpg", turned, &photograph(8, 6), &lens).is_ok());
        let e = check_size("a.jpg", turned, &photograph(6, 8), &lens).unwrap_err().to_string();
        assert!(e.contains("6 x 8") && e.contains("orientation 6") && e.contains("exiftool"), "{e}");
        for (bytes, width) in [(&turned[..], 9), (b"", 6)] {
            let e = check_size("a.jpg", bytes, &photograph(width, 8), &lens).unwrap_err().to_string();
            assert!(e.contains("one camera at one size"), "{e}");
        }
    }
}
