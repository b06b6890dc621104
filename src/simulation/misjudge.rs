//! Cameras that are not known well: what calibration errors do to a reconstruction.

use super::noise::{hash, normal_pair};
use crate::error::{Error, Result};
use crate::optics::{Mat3, Vec3, View};
use nalgebra::{Rotation3, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// How badly the cameras are known: standard deviations of independent normal errors.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MisjudgeParams {
    /// Of each coordinate of each camera's centre, mm.
    pub centre_mm: f64,
    /// Of the turn about each of a camera's own axes, degrees.
    pub turn_deg: f64,
}

impl MisjudgeParams {
    /// Whether nothing is wrong.
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }

    /// Fails where a number is out of its range.
    ///
    /// # Errors
    /// Every fault at once, each naming its key.
    pub fn check(&self) -> Result<()> {
        let faults = [("centre_mm", self.centre_mm), ("turn_deg", self.turn_deg)]
            .into_iter()
            .filter(|(_, x)| !(x.is_finite() && *x >= 0.0))
            .map(|(key, x)| {
                Error::usage(format!("simulate.misjudge.{key} is {x}")).help("give a standard deviation of at least 0")
            });
        Error::many(faults.collect())
    }
}

/// The views with errors: each camera centre is moved and each camera turned about its own centre. Views stay in order;
/// errors of different views are independent.
pub fn misjudged(views: &[View], params: &MisjudgeParams, seed: u64) -> Vec<View> {
    let MisjudgeParams { centre_mm, turn_deg } = *params;
    let misjudge = |(i, view): (usize, &View)| {
        let normal = |j: u64| normal_pair(hash(seed, &[61, i as u64, j]));
        let ((a, b), (c, d), (e, f)) = (normal(0), normal(1), normal(2));
        let centre = view.centre_in_tank() + Vec3::new(a, b, c) * centre_mm;
        let turn: Rotation3<f64> =
            UnitQuaternion::from_scaled_axis(Vec3::new(d, e, f) * turn_deg.to_radians()).to_rotation_matrix();
        let rotation: Mat3 = turn.matrix() * view.rotation;
        View { lens: view.lens, rotation, translation_mm: -(rotation * centre) }
    };
    views.iter().enumerate().map(misjudge).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Index, Tank};
    use crate::simulation::{CaptureParams, capture};

    #[test]
    fn errors_have_the_size_asked_for() {
        let tank = Tank {
            radius_mm: 60.0,
            height_mm: 180.0,
            wall_mm: 4.0,
            water_level_mm: 14.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let views = capture(&CaptureParams { views: 400, ..Default::default() }, &tank, 1).unwrap();
        let wrong = misjudged(&views, &MisjudgeParams { centre_mm: 0.5, turn_deg: 0.2 }, 3);
        let (mut moved, mut turned) = (0.0, 0.0);
        for (a, b) in views.iter().zip(&wrong) {
            b.check().unwrap();
            moved += (a.centre_in_tank() - b.centre_in_tank()).norm_squared() / 3.0;
            let between = Rotation3::from_matrix_unchecked(b.rotation * a.rotation.transpose());
            turned += between.angle().to_degrees().powi(2) / 3.0;
        }
        let rms = |sum: f64| (sum / views.len() as f64).sqrt();
        assert!((rms(moved) - 0.5).abs() < 0.05 && (rms(turned) - 0.2).abs() < 0.02, "{} {}", rms(moved), rms(turned));
        assert_eq!(misjudged(&views, &MisjudgeParams::default(), 3)[7].lens, views[7].lens);
    }
}
