//! Which settings of a capture make sense.

use super::CaptureParams;
use crate::error::{Error, Result};
use crate::optics::{Distortion, Vec3};

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
            ("exposure_walk", self.exposure_walk),
            ("white_balance_walk", self.white_balance_walk),
            ("bubble_glint", self.bubble_glint),
            ("bump_mm", self.bump_mm),
            ("bump_deg", self.bump_deg),
            ("room.window_level", self.room.window_level),
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
        need(self.drifting <= 1000, "drifting", &self.drifting, "give at most 1000");
        need(
            self.drifting_mm > 0.0 && self.drifting_mm <= 10.0,
            "drifting_mm",
            &self.drifting_mm,
            "give over 0, to 10 mm",
        );
        for (key, n) in [("room.windows", self.room.windows), ("room.lamps", self.room.lamps)] {
            need(n <= 4, key, &n, "the room has four walls: give 0 to 4");
        }
        let bumped = self.bump_mm > 0.0 || self.bump_deg > 0.0;
        need(
            self.bump_view < self.views,
            "bump_view",
            &self.bump_view,
            "views are counted from 0 and there are `views` of them",
        );
        need(
            bumped == (self.bump_view > 0),
            "bump_view",
            &self.bump_view,
            "a bump needs a view, 1 or later, and a bump_mm or bump_deg over 0",
        );
        need(!(self.carried && bumped), "carried", &self.carried, "a carried camera has no tripod to bump into");
        for (i, light) in self.other_light.iter().enumerate() {
            let key = |name: &str| format!("other_light[{i}].{name}");
            let others = || self.other_light[..i].iter().flat_map(|l| &l.views);
            need(
                light.views.iter().all(|v| *v < self.views && !others().any(|other| other == v)),
                &key("views"),
                &format!("{:?}", light.views),
                "views are counted from 0, there are `views` of them, and each is in one other light at most",
            );
            need(
                light.gain.iter().all(|g| *g > 0.0 && *g <= 100.0),
                &key("gain"),
                &format!("{:?}", light.gain),
                "give three numbers over 0, at most 100",
            );
            let lamp = light.lamp_direction.map_or(1.0, |d| Vec3::from(d).norm());
            need(
                lamp.is_finite() && lamp > 0.0,
                &key("lamp_direction"),
                &format!("{:?}", light.lamp_direction.unwrap_or_default()),
                "give a direction",
            );
        }
        for (i, other) in self.other_lens.iter().enumerate() {
            let key = |name: &str| format!("other_lens[{i}].{name}");
            let others = || self.other_lens[..i].iter().flat_map(|l| &l.views);
            need(
                other.views.iter().all(|v| *v < self.views && !others().any(|seen| seen == v)),
                &key("views"),
                &format!("{:?}", other.views),
                "views are counted from 0, there are `views` of them, and each has one other lens at most",
            );
            need(
                other.focal_35mm.is_finite() && other.focal_35mm > 0.0,
                &key("focal_35mm"),
                &other.focal_35mm,
                "give a positive length in mm",
            );
            let numbers = other.principal_offset.iter().sum::<f64>() + sum(&other.distortion);
            need(numbers.is_finite(), &key("distortion"), &numbers, "give finite numbers");
        }
        need(
            self.sway_views.iter().all(|&v| v < self.views),
            "sway_views",
            &format!("{:?}", self.sway_views),
            "views are counted from 0 and there are `views` of them",
        );
        for (key, x) in
            [("ambient", self.ambient), ("root_variation", self.root_variation), ("room.clutter", self.room.clutter)]
        {
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
        for (key, x) in [
            ("roll_deg", self.roll_deg),
            ("pan_deg", self.pan_deg),
            ("height_mm", self.height_mm.unwrap_or(0.0)),
            ("tilt_deg", self.tilt_deg.unwrap_or(0.0)),
            ("principal_offset", self.principal_offset[0] + self.principal_offset[1]),
            ("distortion", sum(&self.distortion)),
        ] {
            need(x.is_finite(), key, &x, "give a finite number");
        }
        Error::many(faults)
    }
}

/// Finite where all coefficients are.
fn sum(distortion: &Distortion) -> f64 {
    distortion.named().into_iter().map(|(_, value)| value).sum()
}

#[cfg(test)]
mod tests {
    use crate::simulation::{CaptureParams, OtherLight, RoomParams};

    #[test]
    fn settings_that_make_no_sense_are_named_with_a_remedy() {
        let light = |views: &[usize]| OtherLight { views: views.to_vec(), gain: [1.0; 3], lamp_direction: None };
        let base = CaptureParams { views: 8, ..Default::default() };
        let (bump_mm, room) = (1.0, RoomParams::default());
        let bad = [
            ("bump_view", CaptureParams { bump_mm, ..base.clone() }),
            ("bump_view", CaptureParams { bump_view: 3, ..base.clone() }),
            ("bump_view", CaptureParams { bump_view: 8, bump_mm, ..base.clone() }),
            ("carried", CaptureParams { bump_view: 3, bump_mm, carried: true, ..base.clone() }),
            ("bump_deg", CaptureParams { bump_view: 3, bump_deg: f64::NAN, bump_mm, ..base.clone() }),
            ("room.clutter", CaptureParams { room: RoomParams { clutter: 1.1, ..room }, ..base.clone() }),
            ("room.windows", CaptureParams { room: RoomParams { windows: 5, ..room }, ..base.clone() }),
            ("room.lamps", CaptureParams { room: RoomParams { lamps: 5, ..room }, ..base.clone() }),
            ("room.window_level", CaptureParams { room: RoomParams { window_level: -1.0, ..room }, ..base.clone() }),
            ("drifting", CaptureParams { drifting: 1001, ..base.clone() }),
            ("drifting_mm", CaptureParams { drifting_mm: 0.0, ..base.clone() }),
            ("bubble_glint", CaptureParams { bubble_glint: -0.1, ..base.clone() }),
            ("exposure_walk", CaptureParams { exposure_walk: -0.1, ..base.clone() }),
            ("white_balance_walk", CaptureParams { white_balance_walk: f64::INFINITY, ..base.clone() }),
            ("other_light[0].views", CaptureParams { other_light: vec![light(&[8])], ..base.clone() }),
            ("other_light[1].views", CaptureParams { other_light: vec![light(&[1, 2]), light(&[2])], ..base.clone() }),
            (
                "other_light[0].gain",
                CaptureParams {
                    other_light: vec![OtherLight { gain: [1.0, 0.0, 1.0], ..light(&[1]) }],
                    ..base.clone()
                },
            ),
            (
                "other_light[0].lamp_direction",
                CaptureParams {
                    other_light: vec![OtherLight { lamp_direction: Some([0.0; 3]), ..light(&[1]) }],
                    ..base.clone()
                },
            ),
        ];
        for (key, params) in bad {
            let error = params.check().unwrap_err();
            let text = error.to_string();
            assert!(text.contains(&format!("simulate.capture.{key} is")) && text.contains(" ("), "{key}: {text}");
        }
        CaptureParams { bump_view: 3, bump_mm, other_light: vec![light(&[1]), light(&[2])], ..base }.check().unwrap();
    }
}
