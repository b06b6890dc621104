//! How the photographs are taken: one camera that stands still, a table turned by hand.
//!
//! The first picture's table position gives the tank frame its x and y; the camera's centre lies then at
//! azimuth 0 (on +x) but for the table's offset. Between pictures the table turns by 360°/views with jitter
//! about an axis beside the tank's. Or the camera is carried around the tank by the same angles, by hand.

mod check;
mod params;

pub use params::{CaptureParams, OtherLens, OtherLight, PictureFormat};

use super::bump::Bump;
use super::noise::{hash, uniform};
use crate::error::{Error, Result};
use crate::optics::{Mat3, Tank, Vec3, View};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// How far a carried camera strays: share of the distance farther away, share of the tank's height up or down, degrees
/// beside its aim, degrees of roll.
const FARTHER: f64 = 0.15;
const STRAY_HEIGHT: f64 = 0.08;
const STRAY_AIM_DEG: f64 = 1.0;
const STRAY_ROLL_DEG: f64 = 3.0;

/// Stands the camera before the tank and turns the table: the true views, in order of capture.
///
/// # Errors
/// Where a parameter is out of range or the camera would stand inside the tank.
pub fn capture(params: &CaptureParams, tank: &Tank, seed: u64) -> Result<Vec<View>> {
    params.check()?;
    tank.check()?;
    let lens = params.lens(0);
    let distance_mm = if params.distance_mm > 0.0 {
        params.distance_mm
    } else {
        // The front edge of the rim is nearest and looks largest.
        let (w, h) = (params.width as f64, params.height as f64);
        let tall = lens.focal_px * tank.height_mm / (0.88 * h);
        let wide = lens.focal_px * 2.0 * tank.radius_mm / (0.88 * w);
        tall.max(wide) + tank.radius_mm
    };
    if distance_mm - params.table_offset_mm * 2.0 <= tank.radius_mm {
        return Err(Error::usage(format!(
            "simulate.capture.distance_mm ({distance_mm} mm) puts the camera inside the tank (outer radius {} mm)",
            tank.radius_mm
        ))
        .help("the distance is counted from the tank's axis"));
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let bearing = rng.random_range(0.0..std::f64::consts::TAU);
    let table_mm = Vec3::new(bearing.cos(), bearing.sin(), 0.0) * params.table_offset_mm;
    let bump = Bump::of(params, seed);
    let step = std::f64::consts::TAU / params.views as f64;
    let jitter = params.turn_jitter_deg.to_radians();
    let mut angle = 0.0f64;
    let mut views = Vec::with_capacity(params.views);
    for i in 0..params.views {
        let turn = Mat3::new(angle.cos(), -angle.sin(), 0.0, angle.sin(), angle.cos(), 0.0, 0.0, 0.0, 1.0);
        let (cam_from_room, camera_mm) = camera(params, tank, distance_mm, params.carried.then_some((seed, i)));
        // x_room = table + turn (x_tank - table);  x_cam = R (x_room - camera)
        let rotation = cam_from_room * turn;
        let translation_mm = cam_from_room * (table_mm - turn * table_mm - camera_mm);
        let view = View { lens: params.lens(i), rotation, translation_mm };
        views.push(match &bump {
            Some(bump) => bump.done(i, view),
            None => view,
        });
        // Errors of a hand that aims at marks do not add up.
        angle = (i + 1) as f64 * step + jitter * (rng.random::<f64>() - 0.5);
    }
    Ok(views)
}

/// Turn and place of the camera in the room's frame as it stands (see [`capture`]), strayed as in `hand`, seed and view,
/// where it is carried.
fn camera(params: &CaptureParams, tank: &Tank, distance_mm: f64, hand: Option<(u64, usize)>) -> (Mat3, Vec3) {
    let stray = |j: u64| hand.map_or(0.0, |(seed, view)| 2.0 * uniform(hash(seed, &[73, view as u64, j])) - 1.0);
    let distance_mm = distance_mm * if hand.is_some() { 1.0 + FARTHER * (0.5 + 0.5 * stray(0)) } else { 1.0 };
    let height_mm = params.height_mm.unwrap_or(0.42 * tank.height_mm) + STRAY_HEIGHT * tank.height_mm * stray(1);
    let tilt = params.tilt_deg.map_or_else(|| (0.5 * tank.height_mm - height_mm).atan2(distance_mm), f64::to_radians)
        + (STRAY_AIM_DEG * stray(2)).to_radians();
    let pan = (params.pan_deg + STRAY_AIM_DEG * stray(3)).to_radians();
    let roll = (params.roll_deg + STRAY_ROLL_DEG * stray(4)).to_radians();
    // The room frame is the tank frame but for the table's turning; the camera looks along -x.
    let right = Vec3::new(0.0, -1.0, 0.0);
    let level = -Vec3::x() * pan.cos() + right * pan.sin();
    let right = right * pan.cos() + Vec3::x() * pan.sin();
    let forward = level * tilt.cos() + Vec3::z() * tilt.sin();
    let down = Vec3::z() * tilt.cos() - level * tilt.sin();
    let x = right * roll.cos() + down * roll.sin();
    let y = down * roll.cos() - right * roll.sin();
    let cam_from_room = Mat3::from_rows(&[x.transpose(), y.transpose(), forward.transpose()]);
    (cam_from_room, Vec3::new(distance_mm, 0.0, height_mm))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn tank() -> Tank {
        Tank {
            radius_mm: 90.0,
            height_mm: 246.6,
            wall_mm: 5.0,
            water_level_mm: 12.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    #[test]
    fn views_are_sound_and_hold_the_tank() {
        let views = capture(&CaptureParams::default(), &tank(), 1).unwrap();
        assert_eq!(views.len(), 36);
        for view in &views {
            view.check().unwrap();
            for (z, radius) in [(0.0, 90.0), (246.6, 90.0)] {
                for k in 0..12 {
                    let a = f64::from(k) * std::f64::consts::TAU / 12.0;
                    let p = Vec3::new(radius * a.cos(), radius * a.sin(), z);
                    let (u, v) = view.pixel_of_direction(&(p - view.centre_in_tank())).unwrap();
                    assert!(view.holds(u, v), "({u}, {v}) is outside");
                }
            }
        }
        let first = views[0].centre_in_tank();
        assert!(first.y.abs() < 1e-9 && first.x > 0.0);
    }

    #[test]
    fn turns_are_even_within_the_jitter() {
        let params = CaptureParams { table_offset_mm: 0.0, ..Default::default() };
        let views = capture(&params, &tank(), 4).unwrap();
        for w in views.windows(2) {
            let turn = (w[0].rotation.transpose() * w[1].rotation).transpose();
            let degrees = turn[(1, 0)].atan2(turn[(0, 0)]).to_degrees().abs();
            assert!((degrees - 10.0).abs() <= 1.5 + 1e-9, "{degrees}");
        }
    }

    #[test]
    fn a_carried_camera_strays_and_keeps_the_tank_in_sight() {
        let steady = capture(&CaptureParams::default(), &tank(), 1).unwrap();
        let views = capture(&CaptureParams { carried: true, ..Default::default() }, &tank(), 1).unwrap();
        let (mut nearest, mut farthest) = (f64::INFINITY, 0f64);
        for (view, steady) in views.iter().zip(&steady) {
            view.check().unwrap();
            let (a, b) = (view.centre_in_tank(), steady.centre_in_tank());
            let share = a.x.hypot(a.y) / b.x.hypot(b.y);
            (nearest, farthest) = (nearest.min(share), farthest.max(share));
            assert!((a.z - b.z).abs() <= 0.08 * 246.6 + 1e-9 && (a.y.atan2(a.x) - b.y.atan2(b.x)).abs() < 0.02);
            for (z, radius) in [(0.0, 90.0), (246.6, 90.0)] {
                for k in 0..12 {
                    let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
                    let p = Vec3::new(radius * cos, radius * sin, z);
                    let (u, v) = view.pixel_of_direction(&(p - a)).unwrap();
                    assert!(view.holds(u, v), "({u}, {v}) is outside");
                }
            }
        }
        assert!(nearest > 0.99 && nearest < 1.03 && farthest > 1.12 && farthest < 1.16, "{nearest} {farthest}");
    }

    #[test]
    fn a_camera_inside_the_tank_is_refused() {
        let params = CaptureParams { distance_mm: 60.0, ..Default::default() };
        assert!(capture(&params, &tank(), 1).unwrap_err().message.contains("inside the tank"));
    }
}
