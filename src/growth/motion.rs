//! How one day's tank frame lies in another's.

use crate::math::umeyama::fit;
use crate::optics::{Mat3, Vec3, turn_about_z};
use crate::roots::Root;
use serde::{Deserialize, Serialize};

/// A rigid motion: `x_to = R x_from + t`, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// R.
    pub rotation: Mat3,
    /// t, mm.
    pub translation_mm: Vec3,
}

impl Motion {
    /// No motion.
    pub fn identity() -> Self {
        Self { rotation: Mat3::identity(), translation_mm: Vec3::zeros() }
    }

    /// A turn about the tank's axis, radians.
    pub fn turn(angle: f64) -> Self {
        Self { rotation: turn_about_z(angle), translation_mm: Vec3::zeros() }
    }

    /// A small turn about the axis through the origin along `turn` by its length, radians, then a shift, mm.
    pub fn small(turn: &Vec3, shift_mm: &Vec3) -> Self {
        Self { rotation: *nalgebra::Rotation3::new(*turn).matrix(), translation_mm: *shift_mm }
    }

    /// The motion that brings points nearest to their goals, which run alike; `None` where they lie on one line.
    pub fn nearest(from: &[Vec3], to: &[Vec3]) -> Option<Self> {
        let found = fit(from, to)?;
        Some(Self { rotation: found.rotation, translation_mm: found.translation(1.0) })
    }

    /// Where a point goes.
    pub fn apply(&self, x: &Vec3) -> Vec3 {
        self.rotation * x + self.translation_mm
    }

    /// This motion after `first`.
    #[must_use]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            rotation: self.rotation * first.rotation,
            translation_mm: self.rotation * first.translation_mm + self.translation_mm,
        }
    }

    /// The motion back.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let back = self.rotation.transpose();
        Self { rotation: back, translation_mm: -(back * self.translation_mm) }
    }

    /// The turn about the tank's axis, radians within ±π.
    pub fn azimuth(&self) -> f64 {
        let r = &self.rotation;
        (r[(1, 0)] - r[(0, 1)]).atan2(r[(0, 0)] + r[(1, 1)])
    }

    /// A root moved along.
    pub fn root(&self, root: &Root) -> Root {
        let points_mm = root.points_mm.iter().map(|p| self.apply(&Vec3::from(*p)).into()).collect();
        Root { points_mm, ..root.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn motions_go_back_and_add_up() {
        let a = Motion::small(&Vec3::new(0.01, -0.02, 0.03), &Vec3::new(1.0, 2.0, 3.0)).after(&Motion::turn(2.0));
        let x = Vec3::new(5.0, -7.0, 11.0);
        assert!((a.inverse().apply(&a.apply(&x)) - x).norm() < 1e-12);
        let twice = a.after(&a);
        assert!((twice.apply(&x) - a.apply(&a.apply(&x))).norm() < 1e-12);
        assert!((Motion::turn(-2.0).azimuth() + 2.0).abs() < 1e-12 && (a.azimuth() - 2.03).abs() < 1e-3);
    }
}
