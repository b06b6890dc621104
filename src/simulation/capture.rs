//! How the photographs are taken: one camera that stands still, a table turned by hand.
//!
//! The first picture's table position gives the tank frame its x and y; the camera's centre lies then at
//! azimuth 0 (on +x) but for the table's offset. Between pictures the table turns by 360°/views with jitter
//! about an axis beside the tank's.

use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens, Mat3, Tank, Vec3, View};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// File format of the photographs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PictureFormat {
    /// JPEG at `jpeg_quality`.
    Jpeg,
    /// PNG, without loss.
    Png,
}

/// A capture: camera, table, light and what stands about. Colours are sRGB, 0..1 per channel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CaptureParams {
    /// Number of photographs around the tank, at least 1.
    pub views: usize,
    /// Hand-turned: each turn differs from 360°/views by up to this, degrees.
    pub turn_jitter_deg: f64,
    /// Distance of the table's axis of rotation from the tank's axis, mm.
    pub table_offset_mm: f64,
    /// Picture width, px.
    pub width: usize,
    /// Picture height, px.
    pub height: usize,
    /// Focal length as on 35 mm film (36 mm wide), mm: focal length in px = this / 36 · width.
    pub focal_35mm: f64,
    /// Principal point beside the picture's centre, shares of the picture's width (x, y).
    pub principal_offset: [f64; 2],
    /// Lens distortion, OpenCV's coefficients.
    pub distortion: Distortion,
    /// Horizontal distance of the camera from the tank's axis, mm; 0: so that the tank fills 88 % of the picture's
    /// height (or width).
    pub distance_mm: f64,
    /// Depth of the camera below the rim, mm (negative: above); not given: at 0.42 of the tank's height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Tilt of the optical axis, degrees; positive looks down. Not given: at the middle of the tank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tilt_deg: Option<f64>,
    /// Roll of the camera about its optical axis, degrees.
    pub roll_deg: f64,
    /// Pan of the optical axis beside the tank's axis, degrees; positive looks to the right.
    pub pan_deg: f64,
    /// Supersampling per side of a pixel that holds detail, 1..8: this squared rays.
    pub supersampling: usize,
    /// Colour of a fully lit root.
    pub root_rgb: [f64; 3],
    /// Relative spread of the roots' brightness from root to root, 0..1.
    pub root_variation: f64,
    /// Colour of the room.
    pub background_rgb: [f64; 3],
    /// Relative strength of the room's gradient and blotches, 0..1 (of linear light).
    pub background_variation: f64,
    /// Brightness of the lamps' glow that the front wall mirrors into the pictures as a veil, linear light, 0 for none.
    pub lamp_level: f64,
    /// Brightness of the room behind the camera, over that of the room's colour, linear light: walls mirror it as a veil
    /// before which mirrored roots look dark.
    pub front_level: f64,
    /// Direction towards the lamps as the camera sees it: right, away from the camera, down; any length.
    pub lamp_direction: [f64; 3],
    /// Share of the light on a root that comes from all around, 0..1; the rest comes from the lamps.
    pub ambient: f64,
    /// Loss of light in the water, per mm, per channel.
    pub water_loss_per_mm: [f64; 3],
    /// Follow what walls and water surface mirror: illusory roots, veil.
    pub reflections: bool,
    /// Colour of the inner floor.
    pub floor_rgb: [f64; 3],
    /// Seed of the belts' random print.
    pub belt_seed: u64,
    /// Radius of the table top in tank radii; 0 for none.
    pub table_radii: f64,
    /// Standard deviation of the sensor noise, grey levels of 255.
    pub noise_sigma: f64,
    /// Blur of the picture, standard deviation, px at 968 px picture width (scales with the width).
    pub blur_px: f64,
    /// Greatest displacement of swaying roots, mm.
    pub sway_mm: f64,
    /// Views in which the roots sway, counted from 0; none given: all.
    pub sway_views: Vec<usize>,
    /// Number of specks of dirt on the outer wall.
    pub dirt: usize,
    /// Mean radius of a speck, mm, at most 3.
    pub dirt_mm: f64,
    /// Number of air bubbles on the inner wall.
    pub bubbles: usize,
    /// Mean radius of a bubble, mm, at most 3.
    pub bubble_mm: f64,
    /// A green stem above the crown.
    pub stem: bool,
    /// Drift of the exposure: standard deviation of the log of each picture's gain.
    pub exposure_drift: f64,
    /// File format of the photographs.
    pub format: PictureFormat,
    /// JPEG quality, 1..100.
    pub jpeg_quality: u8,
}

impl Default for CaptureParams {
    /// 36 photographs of 968 x 648 px with an ordinary camera before a dark room.
    fn default() -> Self {
        Self {
            views: 36,
            turn_jitter_deg: 1.5,
            table_offset_mm: 2.0,
            width: 968,
            height: 648,
            focal_35mm: 36.0,
            principal_offset: [0.004, -0.004],
            distortion: Distortion { k1: -0.08, k2: 0.04, p1: 4e-4, p2: -3e-4, k3: 0.0 },
            distance_mm: 0.0,
            height_mm: None,
            tilt_deg: None,
            roll_deg: 0.5,
            pan_deg: 0.3,
            supersampling: 3,
            root_rgb: [0.86, 0.80, 0.74],
            root_variation: 0.12,
            background_rgb: [0.22, 0.235, 0.255],
            background_variation: 0.25,
            lamp_level: 0.6,
            front_level: 0.35,
            lamp_direction: [-0.5, -0.6, -0.6],
            ambient: 0.25,
            water_loss_per_mm: [0.0005, 0.0002, 0.0002],
            reflections: true,
            floor_rgb: [0.2, 0.2, 0.22],
            belt_seed: 1,
            table_radii: 1.5,
            noise_sigma: 2.0,
            blur_px: 0.0,
            sway_mm: 0.0,
            sway_views: Vec::new(),
            dirt: 0,
            dirt_mm: 0.6,
            bubbles: 0,
            bubble_mm: 0.6,
            stem: true,
            exposure_drift: 0.0,
            format: PictureFormat::Jpeg,
            jpeg_quality: 95,
        }
    }
}

impl CaptureParams {
    /// Fails where a number is out of its range.
    ///
    /// # Errors
    /// Every fault at once, each naming its key.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        let mut need = |ok: bool, key: &str, value: &dyn std::fmt::Display, remedy: &str| {
            if !ok {
                faults.push(Error::usage(format!("simulate.capture.{key} is {value}")).help(remedy));
            }
        };
        need((1..=10_000).contains(&self.views), "views", &self.views, "give 1 to 10000 photographs");
        for (key, n) in [("width", self.width), ("height", self.height)] {
            need((8..=20_000).contains(&n), key, &n, "give 8 to 20000 px");
        }
        need((1..=8).contains(&self.supersampling), "supersampling", &self.supersampling, "give 1 to 8");
        need((1..=100).contains(&self.jpeg_quality), "jpeg_quality", &self.jpeg_quality, "give 1 to 100");
        need(
            self.focal_35mm.is_finite() && self.focal_35mm > 0.0,
            "focal_35mm",
            &self.focal_35mm,
            "give a positive length in mm",
        );
        for (key, x) in [
            ("turn_jitter_deg", self.turn_jitter_deg),
            ("table_offset_mm", self.table_offset_mm),
            ("distance_mm", self.distance_mm),
            ("background_variation", self.background_variation),
            ("lamp_level", self.lamp_level),
            ("front_level", self.front_level),
            ("table_radii", self.table_radii),
            ("noise_sigma", self.noise_sigma),
            ("exposure_drift", self.exposure_drift),
            ("sway_mm", self.sway_mm),
        ] {
            need(x.is_finite() && x >= 0.0, key, &x, "give a number of at least 0");
        }
        need((0.0..=100.0).contains(&self.blur_px), "blur_px", &self.blur_px, "give 0 to 100 px");
        for (key, x) in [("dirt_mm", self.dirt_mm), ("bubble_mm", self.bubble_mm)] {
            need(x > 0.0 && x <= 3.0, key, &x, "give a radius over 0 and at most 3 mm");
        }
        for (key, n) in [("dirt", self.dirt), ("bubbles", self.bubbles)] {
            need(n <= 1_000_000, key, &n, "give at most 1000000");
        }
        need(
            self.sway_views.iter().all(|&v| v < self.views),
            "sway_views",
            &format!("{:?}", self.sway_views),
            "views are counted from 0 and there are `views` of them",
        );
        for (key, x) in [("ambient", self.ambient), ("root_variation", self.root_variation)] {
            need((0.0..=1.0).contains(&x), key, &x, "give a share, 0 to 1");
        }
        for (key, colour) in
            [("root_rgb", self.root_rgb), ("background_rgb", self.background_rgb), ("floor_rgb", self.floor_rgb)]
        {
            let ok = colour.iter().all(|c| (0.0..=1.0).contains(c));
            need(ok, key, &format!("{colour:?}"), "give three numbers 0 to 1");
        }
        let ok = self.water_loss_per_mm.iter().all(|&x| x.is_finite() && x >= 0.0);
        need(ok, "water_loss_per_mm", &format!("{:?}", self.water_loss_per_mm), "give three numbers of at least 0");
        let lamp = Vec3::from(self.lamp_direction).norm();
        need(
            lamp.is_finite() && lamp > 0.0,
            "lamp_direction",
            &format!("{:?}", self.lamp_direction),
            "give a direction",
        );
        let d = &self.distortion;
        for (key, x) in [
            ("roll_deg", self.roll_deg),
            ("pan_deg", self.pan_deg),
            ("height_mm", self.height_mm.unwrap_or(0.0)),
            ("tilt_deg", self.tilt_deg.unwrap_or(0.0)),
            ("principal_offset", self.principal_offset[0] + self.principal_offset[1]),
            ("distortion", d.k1 + d.k2 + d.p1 + d.p2 + d.k3),
        ] {
            need(x.is_finite(), key, &x, "give a finite number");
        }
        Error::many(faults)
    }

    /// The lens.
    pub fn lens(&self) -> Lens {
        let width = self.width as f64;
        Lens {
            width: self.width,
            height: self.height,
            focal_px: self.focal_35mm / 36.0 * width,
            cx: (width - 1.0) / 2.0 + self.principal_offset[0] * width,
            cy: (self.height as f64 - 1.0) / 2.0 + self.principal_offset[1] * width,
            distortion: self.distortion,
        }
    }
}

/// Stands the camera before the tank and turns the table: the true views, in order of capture.
///
/// # Errors
/// Where a parameter is out of range or the camera would stand inside the tank.
pub fn capture(params: &CaptureParams, tank: &Tank, seed: u64) -> Result<Vec<View>> {
    params.check()?;
    tank.check()?;
    let lens = params.lens();
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
    let height_mm = params.height_mm.unwrap_or(0.42 * tank.height_mm);
    let tilt = params.tilt_deg.map_or_else(|| (0.5 * tank.height_mm - height_mm).atan2(distance_mm), f64::to_radians);
    // The room frame is the tank frame but for the table's turning; the camera looks along -x.
    let (pan, roll) = (params.pan_deg.to_radians(), params.roll_deg.to_radians());
    let right = Vec3::new(0.0, -1.0, 0.0);
    let level = -Vec3::x() * pan.cos() + right * pan.sin();
    let right = right * pan.cos() + Vec3::x() * pan.sin();
    let forward = level * tilt.cos() + Vec3::z() * tilt.sin();
    let down = Vec3::z() * tilt.cos() - level * tilt.sin();
    let x = right * roll.cos() + down * roll.sin();
    let y = down * roll.cos() - right * roll.sin();
    let cam_from_room = Mat3::from_rows(&[x.transpose(), y.transpose(), forward.transpose()]);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let bearing = rng.random_range(0.0..std::f64::consts::TAU);
    let table_mm = Vec3::new(bearing.cos(), bearing.sin(), 0.0) * params.table_offset_mm;
    let camera_mm = Vec3::new(distance_mm, 0.0, height_mm);
    let step = std::f64::consts::TAU / params.views as f64;
    let jitter = params.turn_jitter_deg.to_radians();
    let mut angle = 0.0f64;
    let mut views = Vec::with_capacity(params.views);
    for i in 0..params.views {
        let turn = Mat3::new(angle.cos(), -angle.sin(), 0.0, angle.sin(), angle.cos(), 0.0, 0.0, 0.0, 1.0);
        // x_room = table + turn (x_tank - table);  x_cam = R (x_room - camera)
        let rotation = cam_from_room * turn;
        let translation_mm = cam_from_room * (table_mm - turn * table_mm - camera_mm);
        views.push(View { lens, rotation, translation_mm });
        // Errors of a hand that aims at marks do not add up.
        angle = (i + 1) as f64 * step + jitter * (rng.random::<f64>() - 0.5);
    }
    Ok(views)
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
    fn a_camera_inside_the_tank_is_refused() {
        let params = CaptureParams { distance_mm: 60.0, ..Default::default() };
        assert!(capture(&params, &tank(), 1).unwrap_err().message.contains("inside the tank"));
    }
}
