//! COLMAP's camera models and the crate's lens.
//!
//! `FOV` and `RAD_TAN_THIN_PRISM_FISHEYE` have no counterpart here and are refused by name.

use super::Camera;
use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens, Model};

pub(super) fn from_camera(camera: &Camera) -> Result<Lens> {
    let p = &camera.params;
    let brown = Distortion::default();
    let fisheye = Distortion { model: Model::Fisheye, ..brown };
    // (fx, fy, cx, cy) and the rest.
    let (own, d) = match (camera.model.as_str(), p.as_slice()) {
        ("SIMPLE_PINHOLE", &[f, cx, cy]) => ([f, f, cx, cy], brown),
        ("PINHOLE", &[fx, fy, cx, cy]) => ([fx, fy, cx, cy], brown),
        ("SIMPLE_RADIAL", &[f, cx, cy, k1]) => ([f, f, cx, cy], Distortion { k1, ..brown }),
        ("RADIAL", &[f, cx, cy, k1, k2]) => ([f, f, cx, cy], Distortion { k1, k2, ..brown }),
        ("OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2]) => ([fx, fy, cx, cy], Distortion { k1, k2, p1, p2, ..brown }),
        ("FULL_OPENCV", &[fx, fy, cx, cy, k1, k2, p1, p2, k3, k4, k5, k6]) => {
            ([fx, fy, cx, cy], Distortion { k1, k2, p1, p2, k3, k4, k5, k6, ..brown })
        }
        ("SIMPLE_RADIAL_FISHEYE", &[f, cx, cy, k1]) => ([f, f, cx, cy], Distortion { k1, ..fisheye }),
        ("RADIAL_FISHEYE", &[f, cx, cy, k1, k2]) => ([f, f, cx, cy], Distortion { k1, k2, ..fisheye }),
        ("OPENCV_FISHEYE", &[fx, fy, cx, cy, k1, k2, k3, r8]) => {
            ([fx, fy, cx, cy], Distortion { k1, k2, k3, r8, ..fisheye })
        }
        ("THIN_PRISM_FISHEYE", &[fx, fy, cx, cy, k1, k2, p1, p2, k3, r8, sx1, sy1]) => {
            let s = [sx1, 0.0, sy1, 0.0];
            ([fx, fy, cx, cy], Distortion { k1, k2, p1, p2, k3, r8, s, ..fisheye })
        }
        (model, given) => {
            let n = given.len();
            return Err(Error::failed(format!("COLMAP camera {}: model {model} with {n} parameters", camera.id)).help(
                "use one of SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL, OPENCV, FULL_OPENCV, SIMPLE_RADIAL_FISHEYE, \
                 RADIAL_FISHEYE, OPENCV_FISHEYE, THIN_PRISM_FISHEYE",
            ));
        }
    };
    let [fx, fy, cx, cy] = own;
    let lens = Lens {
        width: camera.width as usize,
        height: camera.height as usize,
        focal_px: fy,
        cx: cx - 0.5,
        cy: cy - 0.5,
        distortion: Distortion { b1: fx - fy, ..d },
    };
    lens.check().map_err(|e| e.at(format!("COLMAP camera {}", camera.id)))?;
    Ok(lens)
}

/// The simplest of COLMAP's models that holds the lens.
pub(super) fn to_camera(lens: &Lens, id: u32) -> Result<Camera> {
    let d = &lens.distortion;
    let mut params = vec![lens.focal_px + d.b1, lens.focal_px, lens.cx + 0.5, lens.cy + 0.5];
    let [s1, s2, s3, s4] = d.s;
    let zero = |values: &[f64]| values.iter().all(|v| *v == 0.0);
    let model = match d.model {
        _ if !zero(&[d.b2, s2, s4]) => None,
        Model::Brown if !zero(&[d.r8, s1, s3]) => None,
        Model::Brown if zero(&[d.k3, d.k4, d.k5, d.k6]) => {
            params.extend([d.k1, d.k2, d.p1, d.p2]);
            Some("OPENCV")
        }
        Model::Brown => {
            params.extend([d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6]);
            Some("FULL_OPENCV")
        }
        Model::Fisheye if zero(&[d.p1, d.p2, s1, s3]) => {
            params.extend([d.k1, d.k2, d.k3, d.r8]);
            Some("OPENCV_FISHEYE")
        }
        Model::Fisheye => {
            params.extend([d.k1, d.k2, d.p1, d.p2, d.k3, d.r8, s1, s3]);
            Some("THIN_PRISM_FISHEYE")
        }
    };
    let model = model.ok_or_else(|| {
        Error::failed("COLMAP has no camera model with a skew (b2), r8 of an ordinary lens, or these thin prism terms")
            .help(
                "write transforms.json of the undistorted photographs instead, or calibrate with OPENCV or FULL_OPENCV",
            )
    })?;
    Ok(Camera { id, model: model.to_owned(), width: lens.width as u64, height: lens.height as u64, params })
}
