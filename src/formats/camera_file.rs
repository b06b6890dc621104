//! Cameras from files: our `cameras.json`, Metashape's XML, COLMAP's models as text or binary files.

use super::colmap::{binary, text, to_sparse};
use super::{cameras_json, metashape};
use crate::calibration::sparse::{SparseModel, SparseView};
use crate::error::{Error, Result};

/// The files of a COLMAP model, as binary and as text.
pub const COLMAP_FILES: [[&str; 3]; 2] =
    [["cameras.bin", "images.bin", "points3D.bin"], ["cameras.txt", "images.txt", "points3D.txt"]];

/// Reads one file (by its ending: `.xml` is Metashape's, all else our JSON) or the three of a COLMAP model in the order of
/// [`COLMAP_FILES`], each as (name, content). The poses stay in the file's frame and unit; points come from COLMAP alone.
///
/// # Errors
/// Names file, place and remedy.
pub fn parse(files: &[(String, Vec<u8>)]) -> Result<SparseModel> {
    match files {
        [(name, bytes)] if name.to_ascii_lowercase().ends_with(".xml") => metashape::parse(name, utf8(name, bytes)?),
        [(name, bytes)] => {
            let views = cameras_json::parse(name, utf8(name, bytes)?)?;
            let lens = views[0].view.lens;
            let of = |v: cameras_json::NamedView| SparseView {
                file: v.file,
                rotation: v.view.rotation,
                translation: v.view.translation_mm,
            };
            Ok(SparseModel { lens, views: views.into_iter().map(of).collect(), points: Vec::new() })
        }
        [cameras, images, points] => {
            let model = if cameras.0.ends_with(".txt") {
                let of = |f: &(String, Vec<u8>)| utf8(&f.0, &f.1).map(str::to_owned);
                text::parse(&of(cameras)?, &of(images)?, &of(points)?)
            } else {
                binary::parse(&cameras.1, &images.1, &points.1)
            };
            model.and_then(|m| to_sparse(&m, None)).map_err(|e| e.at(format!("the COLMAP model of `{}`", cameras.0)))
        }
        _ => Err(Error::failed(format!("{} camera files are given", files.len()))
            .help("one JSON or XML file, or the three files of a COLMAP model")),
    }
}

fn utf8<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str> {
    std::str::from_utf8(bytes).map_err(|_| {
        Error::failed(format!("`{name}` is no text"))
            .help("cameras.path names a cameras.json, a Metashape XML, or the folder of a COLMAP model")
    })
}

/// Whether a camera file's name of a view means that photograph: the same name, folders aside; Metashape's labels may
/// lack the ending.
pub fn means(file: &str, photo: &str) -> bool {
    let file = file.rsplit(['/', '\\']).next().unwrap_or(file);
    file == photo || photo.rsplit_once('.').is_some_and(|(stem, _)| stem == file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_their_endings() {
        let file = |name: &str, text: &str| (name.to_owned(), text.as_bytes().to_vec());
        let says = |files: &[(String, Vec<u8>)], word: &str| {
            let e = parse(files).unwrap_err().to_string();
            assert!(e.contains(word), "{e}");
        };
        says(&[file("a.xml", "<document></document>")], "aligned");
        says(&[file("a.json", "{")], "a.json");
        says(&[file("cameras.txt", "x"), file("images.txt", ""), file("points3D.txt", "")], "cameras.txt");
        says(&[file("cameras.bin", "x"), file("images.bin", ""), file("points3D.bin", "")], "cameras.bin");
        says(&[("a.json".into(), vec![0xff, 0xfe])], "no text");
        says(&[file("a", ""), file("b", "")], "2 camera files");
    }

    #[test]
    fn names_are_compared_without_folders_and_endings() {
        assert!(means("images/003.jpg", "003.jpg") && means("003", "003.jpg") && means("C:\\p\\003.JPG", "003.JPG"));
        assert!(!means("03.jpg", "003.jpg") && !means("003.png", "003.jpg"));
    }
}
