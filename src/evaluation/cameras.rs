//! Found cameras against true ones.
//!
//! Two questions. Where is the found tank frame? The similarity x_true = s R x_found + t that brings the
//! found camera centres best onto the true ones (least squares, Umeyama 1991) gives the scale s, the tilt of the axis
//! (angle between R z and z), the offset of the axis at half depth and the shift in height. And what matters in the
//! end: how far apart are the pixels at which both camera sets see the same water points? The reconstruction
//! knows its frame only up to a turn about z, so the found set is first turned by the angle that brings the
//! centres nearest, and the differences are pixels through the refraction, each set with its own lens and tank.

use crate::error::{Error, Result};
use crate::math::umeyama::fit;
use crate::optics::{Lens, Mat3, Tank, Vec3, View, ViewMap};
use serde::{Deserialize, Serialize};

/// Errors of a camera set.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraErrors {
    /// Views compared.
    pub views: usize,
    /// Turn about z that was left free, degrees.
    pub turn_deg: f64,
    /// Tilt of the found axis, degrees.
    pub axis_tilt_deg: f64,
    /// Offset of the found axis at half the tank's depth, mm.
    pub axis_offset_mm: f64,
    /// Shift of the found frame along z, mm; positive: found origin too deep.
    pub height_mm: f64,
    /// Scale of the found frame: true over found lengths, less 1.
    pub scale: f64,
    /// Found over true focal length, less 1.
    pub focal: f64,
    /// Found less true principal point, px.
    pub principal_point_px: [f64; 2],
    /// Found less true k1, k2, p1, p2, k3.
    pub distortion: [f64; 5],
    /// Found less true angle of the cameras' optical axes against the tank's, degrees (mean over the views).
    pub pitch_deg: f64,
    /// Rms distance of the camera centres after the turn alone, mm.
    pub centre_rms_mm: f64,
    /// Rms distance of the pixels of water points after the turn alone, px.
    pub water_rms_px: f64,
    /// 95th percentile of the same.
    pub water_p95_px: f64,
}

/// Compares pairs (true, found) of views of the same photographs.
///
/// # Errors
/// Where there are fewer than three pairs, a view or tank is unusable, or no water point is seen by both.
pub fn camera_errors(pairs: &[(View, View)], true_tank: &Tank, found_tank: &Tank) -> Result<CameraErrors> {
    if pairs.len() < 3 {
        return Err(Error::failed(format!("{} cameras in common: too few to compare", pairs.len()))
            .help("at least three photographs must have a camera on both sides; look at their file names"));
    }
    let n = pairs.len() as f64;
    let truth: Vec<Vec3> = pairs.iter().map(|(t, _)| t.centre_in_tank()).collect();
    let found: Vec<Vec3> = pairs.iter().map(|(_, f)| f.centre_in_tank()).collect();
    let (sin, cos) = truth
        .iter()
        .zip(&found)
        .fold((0.0, 0.0), |(s, c), (t, f)| (s + f.x * t.y - f.y * t.x, c + f.x * t.x + f.y * t.y));
    let turn = sin.atan2(cos);
    let turned = |p: &Vec3| Vec3::new(turn.cos() * p.x - turn.sin() * p.y, turn.sin() * p.x + turn.cos() * p.y, p.z);
    let centre_rms_mm = (truth.iter().zip(&found).map(|(t, f)| (t - turned(f)).norm_squared()).sum::<f64>() / n).sqrt();
    let (scale, rotation, shift) = similarity(&found, &truth)?;
    // The true axis' direction and middle, seen from the found frame brought home.
    let axis = rotation * Vec3::z();
    let middle = rotation * Vec3::new(0.0, 0.0, 0.5 * true_tank.height_mm / scale) * scale + shift;
    let origin = shift;
    let offset = middle - axis * ((middle.z - 0.5 * true_tank.height_mm) / axis.z);
    let mut apart = water_differences(pairs, true_tank, found_tank, turn)?;
    apart.sort_by(f64::total_cmp);
    let mean = |of: &dyn Fn(&Lens) -> f64| pairs.iter().map(|(t, f)| of(&f.lens) - of(&t.lens)).sum::<f64>() / n;
    // The optical axis is the third row of cam_from_tank, the tank's axis its third column.
    let pitch = |view: &View| view.rotation[(2, 2)].clamp(-1.0, 1.0).asin();
    let p95 = apart[((apart.len() as f64 * 0.95) as usize).min(apart.len() - 1)];
    Ok(CameraErrors {
        views: pairs.len(),
        turn_deg: turn.to_degrees(),
        axis_tilt_deg: axis.xy().norm().atan2(axis.z).to_degrees(),
        axis_offset_mm: offset.xy().norm(),
        height_mm: origin.z,
        scale: scale - 1.0,
        focal: pairs.iter().map(|(t, f)| f.lens.focal_px / t.lens.focal_px).sum::<f64>() / n - 1.0,
        principal_point_px: [mean(&|l| l.cx), mean(&|l| l.cy)],
        distortion: [
            mean(&|l| l.distortion.k1),
            mean(&|l| l.distortion.k2),
            mean(&|l| l.distortion.p1),
            mean(&|l| l.distortion.p2),
            mean(&|l| l.distortion.k3),
        ],
        pitch_deg: (pairs.iter().map(|(t, f)| pitch(f) - pitch(t)).sum::<f64>() / n).to_degrees(),
        centre_rms_mm,
        water_rms_px: (apart.iter().map(|d| d * d).sum::<f64>() / apart.len() as f64).sqrt(),
        water_p95_px: p95,
    })
}

/// Least-squares similarity `to ≈ s R from + t`.
fn similarity(from: &[Vec3], to: &[Vec3]) -> Result<(f64, Mat3, Vec3)> {
    let found = fit(from, to)
        .ok_or_else(|| Error::failed("the camera centres lie on one line").help("give views from around the tank"))?;
    Ok((found.scale, found.rotation, found.translation(found.scale)))
}

/// Pixel distances of water points that both sets see: rings of points at 5 radii and 6 depths.
fn water_differences(pairs: &[(View, View)], true_tank: &Tank, found_tank: &Tank, turn: f64) -> Result<Vec<f64>> {
    let (top, bottom) = (true_tank.water_level_mm + 16.0, true_tank.floor_mm() - 20.0);
    let mut apart = Vec::new();
    for (view, (truth, found)) in pairs.iter().enumerate() {
        let at = |e: Error| e.at(format!("view {view}"));
        let (truth, found) =
            (ViewMap::new(truth, true_tank).map_err(at)?, ViewMap::new(found, found_tank).map_err(at)?);
        for i in 0..5 {
            for j in 0..6 {
                for k in 0..12 {
                    let rho = (true_tank.inner_radius_mm() - 2.0) * f64::from(i) / 5.0;
                    let z = top + (bottom - top) * f64::from(j) / 5.0;
                    let azimuth = std::f64::consts::TAU * f64::from(k) / 12.0;
                    let p = Vec3::new(rho * azimuth.cos(), rho * azimuth.sin(), z);
                    let q = Vec3::new(rho * (azimuth - turn).cos(), rho * (azimuth - turn).sin(), z);
                    let (Some(a), Some(b)) = (truth.project(&p), found.project(&q)) else { continue };
                    // Only points that regular rays reach: the others are seen nowhere.
                    if a.clear && a.distance_mm < 0.01 && b.distance_mm < 0.01 {
                        apart.push((a.u - b.u).hypot(a.v - b.v));
                    }
                }
            }
        }
    }
    if apart.is_empty() {
        return Err(Error::failed("no water point is seen by both camera sets")
            .help("the found cameras or tank are far from the true ones"));
    }
    Ok(apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use crate::simulation::{CaptureParams, capture};

    fn tank() -> Tank {
        Tank {
            radius_mm: 60.0,
            height_mm: 180.0,
            wall_mm: 4.0,
            water_level_mm: 14.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 24.0], [154.0, 180.0]],
        }
    }

    fn views() -> Vec<View> {
        capture(&CaptureParams { views: 12, ..Default::default() }, &tank(), 2).unwrap()
    }

    /// The views as they look from a frame in which the tank frame's points lie at `scale (R x + t)`.
    fn moved(views: &[View], r: Mat3, t: Vec3, scale: f64) -> Vec<View> {
        let moved = |v: &View| View {
            lens: v.lens,
            rotation: v.rotation * r.transpose(),
            translation_mm: (v.translation_mm - v.rotation * r.transpose() * t) * scale,
        };
        views.iter().map(moved).collect()
    }

    fn about(axis: Vec3, degrees: f64) -> Mat3 {
        *nalgebra::Rotation3::from_axis_angle(&nalgebra::Unit::new_normalize(axis), degrees.to_radians()).matrix()
    }

    #[test]
    fn a_mere_turn_is_no_error() {
        let found = moved(&views(), about(Vec3::z(), 40.0), Vec3::zeros(), 1.0);
        let pairs: Vec<_> = views().into_iter().zip(found).collect();
        let e = camera_errors(&pairs, &tank(), &tank()).unwrap();
        assert!((e.turn_deg + 40.0).abs() < 1e-9, "{e:?}");
        assert!(e.water_rms_px < 1e-6 && e.axis_tilt_deg < 1e-6 && e.axis_offset_mm < 1e-6, "{e:?}");
    }

    #[test]
    fn tilt_height_and_scale_are_told_apart() {
        let one = |r: Mat3, t: Vec3, s: f64| {
            let pairs: Vec<_> = views().into_iter().zip(moved(&views(), r, t, s)).collect();
            camera_errors(&pairs, &tank(), &tank()).unwrap()
        };
        let tilt = one(about(Vec3::x(), 0.5), Vec3::zeros(), 1.0);
        assert!((tilt.axis_tilt_deg - 0.5).abs() < 1e-6 && tilt.scale.abs() < 1e-9, "{tilt:?}");
        let height = one(Mat3::identity(), Vec3::new(0.0, 0.0, -2.0), 1.0);
        assert!((height.height_mm - 2.0).abs() < 1e-6 && height.axis_tilt_deg < 1e-6, "{height:?}");
        assert!(height.water_rms_px > 2.0, "{height:?}");
        let offset = one(Mat3::identity(), Vec3::new(1.0, 0.0, 0.0), 1.0);
        assert!((offset.axis_offset_mm - 1.0).abs() < 1e-6, "{offset:?}");
        let scale = one(Mat3::identity(), Vec3::zeros(), 1.01);
        assert!((scale.scale - (1.0 / 1.01 - 1.0)).abs() < 1e-9, "{scale:?}");
    }
}
