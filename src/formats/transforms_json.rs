//! `transforms.json` of nerfstudio and instant-ngp.
//!
//! Per frame `file_path` and `transform_matrix`, the 4x4 matrix `world_from_cam` of a camera that looks along its own -z, x
//! right, y up; here the camera looks along +z, y down: y and z change sign. The lens stands with the frame or once for all:
//! `w`, `h`, `fl_x`, `fl_y` (or `camera_angle_x`, `camera_angle_y`, the whole angles of view, radians), `cx`, `cy`, `k1` to
//! `k4` (k4 by r⁸), `p1`, `p2`, and whether it is a fisheye (`camera_model` ending in `FISHEYE`, or `is_fisheye`). The corner
//! of the top-left pixel is (0, 0): half a pixel is taken off cx and cy on reading, and added on writing.
//!
//! `applied_transform`, `applied_scale` are left alone: poses are in the frame of the matrices.

use super::cameras_json::NamedView;
use super::json;
use crate::calibration::sparse::{SparseModel, SparseView};
use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens, Mat3, Model, Vec3};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
struct File {
    #[serde(skip_serializing_if = "Option::is_none")]
    camera_model: Option<String>,
    #[serde(flatten)]
    lens: Written,
    frames: Vec<Frame>,
}

#[derive(Serialize, Deserialize)]
struct Frame {
    file_path: String,
    #[serde(flatten)]
    lens: Written,
    transform_matrix: Vec<Vec<f64>>,
}

/// A lens, or what differs from that of all frames.
#[derive(Serialize, Deserialize, Default, Clone, Copy)]
#[serde(default)]
struct Written {
    #[serde(skip_serializing_if = "Option::is_none")]
    w: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    h: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fl_x: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    fl_y: Option<f64>,
    #[serde(skip_serializing)]
    camera_angle_x: Option<f64>,
    #[serde(skip_serializing)]
    camera_angle_y: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cx: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    cy: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    is_fisheye: Option<bool>,
}

/// Whether a JSON text is a `transforms.json`.
pub fn is_one(text: &str) -> bool {
    text.contains("\"transform_matrix\"")
}

/// Reads the content of the file `name`: a model without points, in the frame and unit of its matrices.
///
/// # Errors
/// Names file, frame and key: another form, no frame, a lens without size or focal length, a camera model that is not read,
/// a matrix that is no rigid motion.
pub fn parse(name: &str, text: &str) -> Result<SparseModel> {
    let file: File = json::parse(name, text)?;
    if file.frames.is_empty() {
        return Err(Error::failed(format!("`{name}` holds no frame")).help("`frames` lists one pose per photograph"));
    }
    let kind = file.camera_model.as_deref().unwrap_or("OPENCV");
    let model = match kind.to_ascii_uppercase().as_str() {
        "SIMPLE_PINHOLE" | "PINHOLE" | "SIMPLE_RADIAL" | "RADIAL" | "OPENCV" | "PERSPECTIVE" => Model::Brown,
        "OPENCV_FISHEYE" | "FISHEYE" | "SIMPLE_RADIAL_FISHEYE" | "RADIAL_FISHEYE" => Model::Fisheye,
        _ => {
            return Err(Error::failed(format!("`{name}`: camera_model `{kind}`"))
                .help("OPENCV, PINHOLE, RADIAL and OPENCV_FISHEYE are read"));
        }
    };
    let of = |frame: &Frame| {
        let lens = frame.lens.over(&file.lens).lens(model)?;
        let (rotation, translation) = frame.pose()?;
        Ok(SparseView { file: frame.file_path.clone(), lens, rotation, translation })
    };
    let views = file
        .frames
        .iter()
        .map(|frame| of(frame).map_err(|e: Error| e.at(format!("`{name}`, frame `{}`", frame.file_path))));
    let model = SparseModel { views: views.collect::<Result<_>>()?, points: Vec::new() };
    model.check().map_err(|e| e.at(format!("`{name}`")))?;
    Ok(model)
}

/// The content of a `transforms.json`; lenses that differ stand with their frames.
///
/// # Errors
/// No view, ordinary lenses beside fisheyes, or a lens with a skew, a thin prism or k4 to k6 below the line.
pub fn write(views: &[NamedView]) -> Result<String> {
    let Some(first) = views.first() else { return Err(Error::failed("transforms.json: no view to write")) };
    let model = first.view.lens.distortion.model;
    if let Some(other) = views.iter().find(|v| v.view.lens.distortion.model != model) {
        return Err(Error::failed(format!(
            "transforms.json has one camera model, but of `{}` and `{}` one is a fisheye",
            first.file, other.file
        ))
        .help("write a COLMAP model instead"));
    }
    let alike = views.iter().all(|v| v.view.lens == first.view.lens);
    let frame = |v: &NamedView| {
        let lens = Written::of(&v.view.lens).map_err(|e| e.at(format!("`{}`", v.file)))?;
        let (turn, centre) = (v.view.rotation.transpose(), v.view.centre_in_tank());
        let row = |i: usize| vec![turn[(i, 0)], -turn[(i, 1)], -turn[(i, 2)], centre[i]];
        let transform_matrix = vec![row(0), row(1), row(2), vec![0.0, 0.0, 0.0, 1.0]];
        let lens = if alike { Written::default() } else { lens };
        Ok(Frame { file_path: v.file.clone(), lens, transform_matrix })
    };
    let frames = views.iter().map(frame).collect::<Result<_>>()?;
    let lens = if alike { Written::of(&first.view.lens)? } else { Written::default() };
    let camera_model = if model == Model::Fisheye { "OPENCV_FISHEYE" } else { "OPENCV" };
    serde_json::to_string_pretty(&File { camera_model: Some(camera_model.into()), lens, frames })
        .map_err(|e| Error::failed(format!("transforms.json: {e}")))
}

impl Frame {
    /// Rotation and translation of `cam_from_world`.
    fn pose(&self) -> Result<(Mat3, Vec3)> {
        let m = &self.transform_matrix;
        if !(3..=4).contains(&m.len()) || m.iter().any(|row| row.len() != 4) {
            return Err(Error::failed("`transform_matrix` is not of 4 x 4 numbers"));
        }
        // Columns: the camera's right, up and back in the world.
        let world_from_cam = Mat3::from_fn(|i, j| if j == 0 { m[i][j] } else { -m[i][j] });
        let drift = (world_from_cam * world_from_cam.transpose() - Mat3::identity()).abs().max();
        if drift.is_nan() || drift > 1e-4 || world_from_cam.determinant() < 0.0 {
            return Err(Error::failed(format!(
                "`transform_matrix` is no rigid motion: |R Rᵀ - 1| reaches {drift:.1e}"
            ))
            .help("it is world_from_cam, row by row, x right, y up, z backwards"));
        }
        let svd = world_from_cam.svd(true, true);
        let turn = svd.u.zip(svd.v_t).map_or(world_from_cam, |(u, v_t)| u * v_t).transpose();
        Ok((turn, -(turn * Vec3::new(m[0][3], m[1][3], m[2][3]))))
    }
}

impl Written {
    /// What is said here, else what is said there.
    fn over(self, all: &Self) -> Self {
        Self {
            w: self.w.or(all.w),
            h: self.h.or(all.h),
            fl_x: self.fl_x.or(all.fl_x),
            fl_y: self.fl_y.or(all.fl_y),
            camera_angle_x: self.camera_angle_x.or(all.camera_angle_x),
            camera_angle_y: self.camera_angle_y.or(all.camera_angle_y),
            cx: self.cx.or(all.cx),
            cy: self.cy.or(all.cy),
            k1: self.k1.or(all.k1),
            k2: self.k2.or(all.k2),
            k3: self.k3.or(all.k3),
            k4: self.k4.or(all.k4),
            p1: self.p1.or(all.p1),
            p2: self.p2.or(all.p2),
            is_fisheye: self.is_fisheye.or(all.is_fisheye),
        }
    }

    fn lens(&self, model: Model) -> Result<Lens> {
        let side = |given: Option<f64>, key: &str| {
            given.filter(|n| *n >= 1.0 && *n < 1e9).ok_or_else(|| {
                Error::failed(format!("the picture's size `{key}` is missing or none")).help("give `w` and `h` in px")
            })
        };
        let (w, h) = (side(self.w, "w")?, side(self.h, "h")?);
        let of_angle = |angle: Option<f64>, side: f64| angle.map(|a| 0.5 * side / (0.5 * a).tan());
        let along = self.fl_x.or_else(|| of_angle(self.camera_angle_x, w));
        let down = self.fl_y.or_else(|| of_angle(self.camera_angle_y, h));
        let Some((fx, fy)) = along.or(down).zip(down.or(along)) else {
            return Err(
                Error::failed("no focal length is given").help("give `fl_x` (px) or `camera_angle_x` (radians)")
            );
        };
        let model = if self.is_fisheye == Some(true) { Model::Fisheye } else { model };
        let of = |k: Option<f64>| k.unwrap_or(0.0);
        let (k1, k2, k3, r8) = (of(self.k1), of(self.k2), of(self.k3), of(self.k4));
        let (p1, p2) = (of(self.p1), of(self.p2));
        Ok(Lens {
            width: w as usize,
            height: h as usize,
            focal_px: fy,
            cx: self.cx.unwrap_or(0.5 * w) - 0.5,
            cy: self.cy.unwrap_or(0.5 * h) - 0.5,
            distortion: Distortion { model, k1, k2, p1, p2, k3, r8, b1: fx - fy, ..Distortion::default() },
        })
    }

    fn of(lens: &Lens) -> Result<Self> {
        let d = &lens.distortion;
        let lost = d
            .named()
            .into_iter()
            .find(|(key, value)| *value != 0.0 && ["k4", "k5", "k6", "s1", "s2", "s3", "s4", "b2"].contains(key));
        if let Some((key, value)) = lost {
            return Err(Error::failed(format!("transforms.json has no place for the lens's {key} = {value}"))
                .help("write a COLMAP model instead"));
        }
        Ok(Self {
            w: Some(lens.width as f64),
            h: Some(lens.height as f64),
            fl_x: Some(lens.focal_px + d.b1),
            fl_y: Some(lens.focal_px),
            cx: Some(lens.cx + 0.5),
            cy: Some(lens.cy + 0.5),
            k1: Some(d.k1),
            k2: Some(d.k2),
            k3: Some(d.k3),
            k4: Some(d.r8),
            p1: Some(d.p1),
            p2: Some(d.p2),
            is_fisheye: (d.model == Model::Fisheye).then_some(true),
            ..Self::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::View;
    use nalgebra::Rotation3;

    fn views() -> Vec<NamedView> {
        let distortion = Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, b1: 19.68, ..Distortion::default() };
        let lens = Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.2, cy: 320.1, distortion };
        let view = |k: u32| {
            let rotation = Rotation3::new(Vec3::new(0.2, 0.5 * f64::from(k), -0.1)).into_inner();
            let view = View { lens, rotation, translation_mm: Vec3::new(1.0, -2.0, 400.0 + f64::from(k)) };
            NamedView { file: format!("{k:03}.jpg"), view }
        };
        (0..3).map(view).collect()
    }

    fn close(found: &SparseModel, want: &[NamedView]) {
        assert_eq!(found.views.len(), want.len());
        for (a, b) in found.views.iter().zip(want) {
            let (l, m) = (a.lens.pixel(0.3, -0.2), b.view.lens.pixel(0.3, -0.2));
            assert!((l.0 - m.0).abs() < 1e-9 && (l.1 - m.1).abs() < 1e-9, "{l:?} {m:?}");
            assert!((a.rotation - b.view.rotation).abs().max() < 1e-12 && a.file == b.file);
            assert!((a.translation - b.view.translation_mm).norm() < 1e-9);
        }
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut views = views();
        close(&parse("t.json", &write(&views).unwrap()).unwrap(), &views);
        views[1].view.lens.focal_px = 700.0;
        close(&parse("t.json", &write(&views).unwrap()).unwrap(), &views);
        views.iter_mut().for_each(|v| v.view.lens.distortion.model = Model::Fisheye);
        let text = write(&views).unwrap();
        assert!(text.contains("OPENCV_FISHEYE") && is_one(&text));
        close(&parse("t.json", &text).unwrap(), &views);
    }

    /// A camera at (0, 0, 5) that looks along the world's -z, x right, y up, as the format has it: the identity turned.
    #[test]
    fn axes_and_pixel_centres_are_converted() {
        let text = r#"{"camera_angle_x": 1.5707963267948966, "w": 200, "h": 100, "frames": [{"file_path": "./train/r_0",
            "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 5], [0, 0, 0, 1]]}]}"#;
        let model = parse("transforms.json", text).unwrap();
        let view = &model.views[0];
        // A point in front, to the right and above the axis.
        let x = view.rotation * Vec3::new(1.0, 0.5, 0.0) + view.translation;
        assert!((x - Vec3::new(1.0, -0.5, 5.0)).norm() < 1e-12, "{x}");
        let (u, v) = view.lens.pixel(x.x / x.z, x.y / x.z);
        assert!((u - (100.0 + 20.0 - 0.5)).abs() < 1e-9 && (v - (50.0 - 10.0 - 0.5)).abs() < 1e-9, "{u} {v}");
    }

    #[test]
    fn faults_are_named() {
        let good = write(&views()).unwrap();
        let says = |text: &str, word: &str| {
            let e = parse("t.json", text).unwrap_err().to_string();
            assert!(e.contains("t.json") && e.contains(word), "{e}");
        };
        says("{}", "frames");
        says(r#"{"frames": []}"#, "no frame");
        says(&good.replace("OPENCV", "EQUIRECTANGULAR"), "EQUIRECTANGULAR");
        says(&good.replace("\"w\"", "\"width\""), "`w`");
        says(&good.replace("fl_x", "f").replace("fl_y", "g"), "focal length");
        says(&good.replacen("\"transform_matrix\": [", "\"transform_matrix\": [[9, 0, 0, 0],", 1), "000.jpg");
        let mut views = views();
        views[2].view.lens.distortion.k5 = 0.1;
        assert!(write(&views).unwrap_err().to_string().contains("k5"));
        views[2].view.lens.distortion = Distortion { model: Model::Fisheye, ..Distortion::default() };
        assert!(write(&views).unwrap_err().to_string().contains("fisheye"));
    }
}
