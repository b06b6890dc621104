//! `cameras.json`: a lens and, per photograph, the pose `x_cam = R x_tank + t`; a view may have `intrinsics` of its own.
//!
//! The camera looks along +z, x right, y down; the centre of the top-left pixel is (0, 0); distortion as in
//! [`crate::optics::distortion`]; t in mm; R is written row by row.

use super::json;
use crate::error::{Error, Result};
use crate::optics::{Lens, Mat3, Vec3, View};
use serde::{Deserialize, Serialize};

/// A view with the name of its photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NamedView {
    /// Path of the photograph as the camera file gives it.
    pub file: String,
    /// Lens and pose.
    pub view: View,
}

#[derive(Serialize, Deserialize)]
struct File {
    #[serde(default)]
    convention: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    intrinsics: Option<Lens>,
    views: Vec<Pose>,
}

#[derive(Serialize, Deserialize)]
struct Pose {
    file: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    intrinsics: Option<Lens>,
    #[serde(rename = "R")]
    r: [[f64; 3]; 3],
    t: [f64; 3],
}

const CONVENTION: &str = "x_cam = R x_tank + t; camera looks along +z, x right, y down; the centre of the \
                          top-left pixel is (0, 0); OpenCV distortion k1 k2 p1 p2 k3";

/// Reads the content of a `cameras.json`; rotations are made orthonormal to the last digit.
///
/// # Errors
/// Names file, view and number: another form, no view, a number that is not finite, an R that is no
/// rotation, one photograph named twice.
pub fn parse(name: &str, text: &str) -> Result<Vec<NamedView>> {
    let f: File = json::parse(name, text)?;
    if f.views.is_empty() {
        return Err(Error::failed(format!("`{name}` holds no view")).help("`views` lists one pose per photograph"));
    }
    let mut views: Vec<NamedView> = Vec::with_capacity(f.views.len());
    let mut faults = Vec::new();
    for pose in f.views {
        let rotation = Mat3::from_fn(|i, j| pose.r[i][j]);
        let Some(lens) = pose.intrinsics.or(f.intrinsics) else {
            let none = format!("`{name}`, view `{}`: it has no `intrinsics`, nor has the file", pose.file);
            faults.push(Error::failed(none).help("give the lens once for all views, or with each of them"));
            continue;
        };
        let view = View { lens, rotation, translation_mm: Vec3::from(pose.t) };
        if let Err(e) = view.check() {
            faults.push(e.at(format!("`{name}`, view `{}`", pose.file)));
            continue;
        }
        if views.iter().any(|v| v.file == pose.file) {
            faults.push(Error::failed(format!("`{name}` names the photograph `{}` twice", pose.file)));
            continue;
        }
        let svd = rotation.svd(true, true);
        let rotation = match (svd.u, svd.v_t) {
            (Some(u), Some(v_t)) => u * v_t,
            _ => rotation,
        };
        views.push(NamedView { file: pose.file, view: View { rotation, ..view } });
    }
    Error::many(faults)?;
    Ok(views)
}

/// The content of a `cameras.json`; the first view's lens stands for all that have the same.
///
/// # Errors
/// Where there is no view.
pub fn write(views: &[NamedView]) -> Result<String> {
    let Some(first) = views.first() else {
        return Err(Error::failed("cameras.json: no view to write"));
    };
    let common = first.view.lens;
    let file = File {
        convention: CONVENTION.to_owned(),
        intrinsics: Some(common),
        views: views
            .iter()
            .map(|v| Pose {
                file: v.file.clone(),
                intrinsics: (v.view.lens != common).then_some(v.view.lens),
                r: std::array::from_fn(|i| std::array::from_fn(|j| v.view.rotation[(i, j)])),
                t: v.view.translation_mm.into(),
            })
            .collect(),
    };
    serde_json::to_string_pretty(&file).map_err(|e| Error::failed(format!("cameras.json: {e}")))
}

/// Pairs (true, found) of the views of the same photographs: equal file names, folders aside.
pub fn in_pairs(truth: &[NamedView], found: &[NamedView]) -> Vec<(View, View)> {
    let name = |v: &NamedView| v.file.rsplit(['/', '\\']).next().unwrap_or_default().to_owned();
    truth
        .iter()
        .filter_map(|t| Some((t.view.clone(), found.iter().find(|f| name(f) == name(t))?.view.clone())))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(r00: &str) -> String {
        format!(
            r#"{{"intrinsics": {{"width": 8, "height": 6, "f": 9.0, "cx": 3.5, "cy": 2.5, "k1": 0, "k2": 0, "p1": 0, "p2": 0, "k3": 0}},
            "views": [{{"file": "a.jpg", "R": [[{r00}, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 400]}}]}}"#
        )
    }

    #[test]
    fn what_is_written_is_read_back() {
        let views = parse("c.json", &text("1")).unwrap();
        assert_eq!(parse("c.json", &write(&views).unwrap()).unwrap(), views);
    }

    #[test]
    fn a_view_may_have_a_lens_of_its_own() {
        let mut views = parse("c.json", &text("1")).unwrap();
        let mut other = views[0].clone();
        other.file = "b.jpg".into();
        other.view.lens.focal_px = 10.0;
        other.view.lens.distortion.b1 = 0.5;
        views.push(other);
        let written = write(&views).unwrap();
        assert_eq!(written.matches("intrinsics").count(), 2, "{written}");
        assert_eq!(parse("c.json", &written).unwrap(), views);
        let none = text("1").replace("intrinsics", "lens");
        assert!(parse("c.json", &none).unwrap_err().message.contains("a.jpg"));
    }

    #[test]
    fn faults_name_file_and_view() {
        let e = parse("c.json", &text("2")).unwrap_err();
        assert!(e.message.contains("c.json") && e.message.contains("a.jpg") && e.message.contains("rotation"), "{e}");
        assert!(parse("c.json", &text("NaN")).is_err());
        assert!(parse("c.json", &text("1e999")).is_err());
    }
}
