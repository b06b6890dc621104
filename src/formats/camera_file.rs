//! Cameras from and to files: our `cameras.json`, `transforms.json` of nerfstudio and instant-ngp, Metashape's XML,
//! COLMAP's models as text or binary files.

use super::colmap::{binary, from_sparse, text, to_sparse};
use super::{NamedView, cameras_json, metashape, transforms_json};
use crate::calibration::sparse::{SparseModel, SparseView};
use crate::error::{Error, Result};

/// The files of a COLMAP model, as binary and as text.
pub const COLMAP_FILES: [[&str; 3]; 2] =
    [["cameras.bin", "images.bin", "points3D.bin"], ["cameras.txt", "images.txt", "points3D.txt"]];

/// Reads one file (by its ending: `.xml` is Metashape's, all else JSON, told by its keys) or the three of a COLMAP model in the order of
/// [`COLMAP_FILES`], each as (name, content). The poses stay in the file's frame and unit; points come from COLMAP alone.
///
/// # Errors
/// Names file, place and remedy.
pub fn parse(files: &[(String, Vec<u8>)]) -> Result<SparseModel> {
    match files {
        [(name, bytes)] if name.to_ascii_lowercase().ends_with(".xml") => metashape::parse(name, utf8(name, bytes)?),
        [(name, bytes)] if transforms_json::is_one(utf8(name, bytes)?) => {
            transforms_json::parse(name, utf8(name, bytes)?)
        }
        [(name, bytes)] => {
            let views = cameras_json::parse(name, utf8(name, bytes)?)?;
            Ok(sparse(&views))
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

/// Formats that cameras are written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Our own.
    CamerasJson,
    /// COLMAP's three text files.
    Colmap,
    /// nerfstudio's and instant-ngp's.
    TransformsJson,
}

/// The files of these views by name, in their frame and unit.
///
/// # Errors
/// No view, or a lens that the format has no place for.
pub fn write(views: &[NamedView], format: Format) -> Result<Vec<(&'static str, String)>> {
    match format {
        Format::CamerasJson => Ok(vec![("cameras.json", cameras_json::write(views)?)]),
        Format::TransformsJson => Ok(vec![("transforms.json", transforms_json::write(views)?)]),
        Format::Colmap => {
            let (cameras, images, points) = text::write(&from_sparse(&sparse(views))?);
            let [cameras_name, images_name, points_name] = COLMAP_FILES[1];
            Ok(vec![(cameras_name, cameras), (images_name, images), (points_name, points)])
        }
    }
}

fn sparse(views: &[NamedView]) -> SparseModel {
    let of = |v: &NamedView| SparseView {
        file: v.file.clone(),
        lens: v.view.lens,
        rotation: v.view.rotation,
        translation: v.view.translation_mm,
    };
    SparseModel { views: views.iter().map(of).collect(), points: Vec::new() }
}

fn utf8<'a>(name: &str, bytes: &'a [u8]) -> Result<&'a str> {
    std::str::from_utf8(bytes).map_err(|_| {
        Error::failed(format!("`{name}` is no text")).help(
            "cameras.path names a cameras.json, a transforms.json, a Metashape XML, or the folder of a COLMAP model",
        )
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
    use crate::optics::{Distortion, Lens, Mat3, Vec3, View};

    #[test]
    fn what_is_written_is_read_back_in_every_format() {
        let distortion = Distortion { k1: -0.1, b1: 2.0, ..Distortion::default() };
        let lens = Lens { width: 96, height: 64, focal_px: 90.0, cx: 48.2, cy: 31.1, distortion };
        let turn = nalgebra::Rotation3::new(Vec3::new(0.1, -0.7, 0.2)).into_inner();
        let view = |lens, rotation| View { lens, rotation, translation_mm: Vec3::new(1.0, 0.25, 300.0) };
        let other = Lens { focal_px: 99.0, ..lens };
        let views = [("a b.jpg", view(lens, Mat3::identity())), ("c.jpg", view(other, turn))];
        let views = views.map(|(file, view)| NamedView { file: file.into(), view });
        for format in [Format::CamerasJson, Format::Colmap, Format::TransformsJson] {
            let files = write(&views, format).unwrap();
            let files: Vec<_> = files.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())).collect();
            let model = parse(&files).unwrap();
            for (a, b) in model.views.iter().zip(&views) {
                assert!(a.file == b.file && (a.rotation - b.view.rotation).norm() < 1e-12, "{format:?}");
                let (l, m) = (&a.lens, &b.view.lens);
                let (p, q) = (l.pixel(0.3, 0.2), m.pixel(0.3, 0.2));
                assert!((p.0 - q.0).abs() < 1e-9 && (p.1 - q.1).abs() < 1e-9 && l.width == m.width, "{format:?}");
            }
        }
    }

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
