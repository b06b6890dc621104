//! COLMAP's camera models and the crate's lens.
//!
//! Square pixels are one focal length: fx and fy may differ by 1e-4 of their size (0.05 px at 500 px
//! from the centre) and are averaged; beyond that the model is refused.

use super::Camera;
use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens};

pub(super) fn from_camera(camera: &Camera) -> Result<Lens> {
    let p = &camera.params;
    let none = Distortion::default();
    let (fx, fy, cx, cy, distortion) = match (camera.model.as_str(), p.len()) {
        ("SIMPLE_PINHOLE", 3) => (p[0], p[0], p[1], p[2], none),
        ("PINHOLE", 4) => (p[0], p[1], p[2], p[3], none),
        ("SIMPLE_RADIAL", 4) => (p[0], p[0], p[1], p[2], Distortion { k1: p[3], ..none }),
        ("RADIAL", 5) => (p[0], p[0], p[1], p[2], Distortion { k1: p[3], k2: p[4], ..none }),
        ("OPENCV", 8) => (p[0], p[1], p[2], p[3], Distortion { k1: p[4], k2: p[5], p1: p[6], p2: p[7], k3: 0.0 }),
        ("FULL_OPENCV", 12) if p[9..].iter().all(|&k| k == 0.0) => {
            (p[0], p[1], p[2], p[3], Distortion { k1: p[4], k2: p[5], p1: p[6], p2: p[7], k3: p[8] })
        }
        (model, n) => {
            return Err(Error::failed(format!("COLMAP camera {}: model {model} with {n} parameters", camera.id)).help(
                "use SIMPLE_RADIAL, RADIAL or OPENCV (fisheye models and rational distortion are not supported)",
            ));
        }
    };
    if ((fx - fy) / fx).abs() > 1e-4 {
        return Err(Error::failed(format!("COLMAP camera {}: focal lengths {fx} and {fy} differ", camera.id))
            .help("pixels are taken as square: run COLMAP with SIMPLE_RADIAL or RADIAL"));
    }
    let lens = Lens {
        width: camera.width as usize,
        height: camera.height as usize,
        focal_px: 0.5 * (fx + fy),
        cx: cx - 0.5,
        cy: cy - 0.5,
        distortion,
    };
    lens.check()?;
    Ok(lens)
}

pub(super) fn to_camera(lens: &Lens) -> Camera {
    let d = &lens.distortion;
    let mut params = vec![lens.focal_px, lens.focal_px, lens.cx + 0.5, lens.cy + 0.5, d.k1, d.k2, d.p1, d.p2];
    let model = if d.k3 == 0.0 {
        "OPENCV"
    } else {
        params.extend([d.k3, 0.0, 0.0, 0.0]);
        "FULL_OPENCV"
    };
    Camera { id: 1, model: model.to_owned(), width: lens.width as u64, height: lens.height as u64, params }
}
