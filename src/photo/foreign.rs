//! Formats of cameras and telephones that are not read, told by their first bytes, and what to do about them.

use super::metadata::Metadata;
use crate::error::{Error, Result};

/// Endings of camera raw files that look like TIFF, whose main picture is a thumbnail.
const TIFF_RAW: [&str; 18] = [
    "3fr", "arw", "cr2", "dcr", "dng", "erf", "fff", "iiq", "kdc", "mef", "mos", "nef", "nrw", "pef", "rwl", "sr2",
    "srf", "srw",
];

/// Refuses a photograph of such a format.
///
/// # Errors
/// Names the photograph, its format and a program that converts it.
pub(super) fn refuse(bytes: &[u8], name: &str) -> Result<()> {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    let refused = |format: &str, remedy: String| {
        Err(Error::failed(format!("photograph `{name}` is {format}, which is not read")).help(remedy))
    };
    if let Some(raw) = raw(bytes, name) {
        let remedy = format!(
            "develop it to a 16-bit TIFF, all photographs with the same settings and without lens correction or crop: \
             `darktable-cli {name} {stem}.tif --core --conf plugins/imageio/format/tiff/bpp=16`, \
             `rawtherapee-cli -t -b16 -c {name}` or `dcraw -T -6 -w {name}`"
        );
        return refused(&format!("a camera raw file ({raw})"), remedy);
    }
    let brand = if bytes.get(4..8) == Some(b"ftyp") { bytes.get(8..12).unwrap_or_default() } else { b"" };
    match brand {
        b"heic" | b"heix" | b"heim" | b"heis" | b"hevc" | b"hevx" | b"mif1" | b"msf1" => refused(
            "HEIC",
            format!("convert it, e.g. `heif-convert {name} {stem}.png`; telephones can be set to take JPEG instead"),
        ),
        b"avif" | b"avis" => refused("AVIF", format!("convert it, e.g. `avifdec {name} {stem}.png`")),
        _ if bytes.starts_with(&[0xFF, 0x0A]) || bytes.get(4..12) == Some(b"JXL \r\n\x87\n") => {
            refused("JPEG XL", format!("convert it, e.g. `djxl {name} {stem}.png`"))
        }
        _ => Ok(()),
    }
}

/// The kind of camera raw file that this is.
fn raw(bytes: &[u8], name: &str) -> Option<String> {
    let magic: [(usize, &[u8], &str); 7] = [
        (0, b"FUJIFILMCCD-RAW", "RAF"),
        (0, b"IIU\0", "RW2"),
        (0, b"IIRO", "ORF"),
        (0, b"IIRS", "ORF"),
        (0, b"MMOR", "ORF"),
        (0, b"FOVb", "X3F"),
        (4, b"ftypcrx ", "CR3"),
    ];
    if let Some((.., kind)) = magic.iter().find(|(at, magic, _)| bytes.get(*at..).is_some_and(|b| b.starts_with(magic)))
    {
        return Some((*kind).to_owned());
    }
    if !(bytes.starts_with(b"II*\0") || bytes.starts_with(b"MM\0*")) {
        return None;
    }
    let ending = name.rsplit_once('.').map(|(_, ending)| ending.to_ascii_lowercase()).unwrap_or_default();
    if TIFF_RAW.contains(&ending.as_str()) {
        return Some(ending.to_uppercase());
    }
    let metadata = Metadata::of(bytes)?;
    const NEW_SUBFILE_TYPE: u16 = 254;
    const PHOTOMETRIC_INTERPRETATION: u16 = 262;
    const DNG_VERSION: u16 = 50706;
    let is_dng = metadata.tiff(DNG_VERSION).is_some();
    // A colour filter array, or sensor values without one; or a reduced picture ahead of the real one.
    let is_mosaic = matches!(metadata.tiff(PHOTOMETRIC_INTERPRETATION), Some(32803 | 34892));
    let is_thumbnail = metadata.tiff(NEW_SUBFILE_TYPE).is_some_and(|kind| kind & 1 == 1);
    match (is_dng, is_mosaic || is_thumbnail) {
        (true, _) => Some("DNG".to_owned()),
        (false, true) => Some("in the form of a TIFF".to_owned()),
        (false, false) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::metadata::tests::exif;
    use super::*;
    use ::exif::{Context, Tag, Value};

    fn said(bytes: &[u8], name: &str) -> String {
        refuse(bytes, name).expect_err("is foreign").to_string()
    }

    #[test]
    fn every_format_is_named_with_its_remedy() {
        let ftyp = |brand: &[u8]| [b"\0\0\0\x18ftyp", brand, b"\0\0\0\0mif1"].concat();
        for (bytes, name, format, remedy) in [
            (ftyp(b"heic"), "IMG_1.HEIC", "HEIC", "heif-convert IMG_1.HEIC IMG_1.png"),
            (ftyp(b"mif1"), "IMG_1.heif", "HEIC", "heif-convert"),
            (ftyp(b"avif"), "a.avif", "AVIF", "avifdec"),
            (ftyp(b"crx "), "IMG_1.CR3", "camera raw file (CR3)", "dcraw -T -6 -w IMG_1.CR3"),
            (b"\xFF\x0A\xFA\x1F".to_vec(), "a.jxl", "JPEG XL", "djxl a.jxl a.png"),
            (b"\0\0\0\x0CJXL \r\n\x87\n\0\0".to_vec(), "a.jxl", "JPEG XL", "djxl"),
            (b"FUJIFILMCCD-RAW 0201".to_vec(), "DSCF1.RAF", "camera raw file (RAF)", "rawtherapee-cli"),
            (b"IIRO\x08\0\0\0".to_vec(), "P1.ORF", "camera raw file (ORF)", "16-bit TIFF"),
            (b"IIU\0\x18\0\0\0".to_vec(), "P1.RW2", "camera raw file (RW2)", "16-bit TIFF"),
            (b"II*\0\x10\0\0\0CR\x02\0".to_vec(), "IMG.CR2", "camera raw file (CR2)", "16-bit TIFF"),
            (b"II*\0\x08\0\0\0".to_vec(), "DSC0.ARW", "camera raw file (ARW)", "darktable-cli DSC0.ARW DSC0.tif"),
            (b"MM\0*\0\0\0\x08".to_vec(), "DSC_1.nef", "camera raw file (NEF)", "16-bit TIFF"),
        ] {
            let text = said(&bytes, name);
            assert!(text.contains(&format!("`{name}`")) && text.contains(format) && text.contains(remedy), "{text}");
        }
    }

    #[test]
    fn raw_files_under_another_name_are_known_by_their_tags() {
        let tagged = |tag, value| exif(&[(Tag(Context::Tiff, tag), value)]);
        assert!(said(&tagged(50706, Value::Byte(vec![1, 4, 0, 0])), "a.tif").contains("DNG"));
        assert!(said(&tagged(254, Value::Long(vec![1])), "a.tif").contains("camera raw"));
        assert!(said(&tagged(262, Value::Short(vec![32803])), "a.tif").contains("camera raw"));
        assert!(refuse(&tagged(254, Value::Long(vec![0])), "a.tif").is_ok());
        assert!(refuse(&tagged(262, Value::Short(vec![2])), "a.tif").is_ok());
    }
}
