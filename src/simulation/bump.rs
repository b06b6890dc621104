//! A bumped tripod: from one view on the camera stands a little elsewhere and looks a little elsewhere.
//!
//! `x_cam' = T (x_cam - m)` with a move m and a turn T of the given sizes; their directions are drawn. The room does not
//! move, so where it stands is told by the camera as it stood before ([`Bump::undone`]).

use super::CaptureParams;
use super::noise::{hash, normal_pair};
use crate::optics::{Mat3, Vec3, View};
use nalgebra::{Rotation3, Unit};

/// The camera's motion, once.
#[derive(Debug, Clone)]
pub struct Bump {
    first_view: usize,
    turn: Mat3,
    move_mm: Vec3,
}

impl Bump {
    /// The bump of a capture with that seed; `None` where there is none.
    pub fn of(params: &CaptureParams, seed: u64) -> Option<Self> {
        let direction = |j: u64| {
            let ((x, y), (z, _)) = (normal_pair(hash(seed, &[67, j])), normal_pair(hash(seed, &[67, j + 1])));
            Vec3::new(x, y, z).try_normalize(1e-9).unwrap_or_else(Vec3::x)
        };
        let axis = Unit::new_unchecked(direction(2));
        (params.bump_view > 0).then(|| Self {
            first_view: params.bump_view,
            turn: *Rotation3::from_axis_angle(&axis, params.bump_deg.to_radians()).matrix(),
            move_mm: direction(0) * params.bump_mm,
        })
    }

    /// View `index` as the bump left it.
    pub fn done(&self, index: usize, view: View) -> View {
        if index < self.first_view {
            return view;
        }
        let translation_mm = self.turn * (view.translation_mm - self.move_mm);
        View { rotation: self.turn * view.rotation, translation_mm, ..view }
    }

    /// View `index` as it would be without the bump.
    pub fn undone(&self, index: usize, view: &View) -> View {
        if index < self.first_view {
            return view.clone();
        }
        let back = self.turn.transpose();
        let translation_mm = back * view.translation_mm + self.move_mm;
        View { rotation: back * view.rotation, translation_mm, ..view.clone() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Index, Tank};
    use crate::simulation::capture;

    #[test]
    fn the_cameras_from_there_on_have_moved_and_turned_by_as_much() {
        let tank = Tank {
            radius_mm: 60.0,
            height_mm: 180.0,
            wall_mm: 4.0,
            water_level_mm: 14.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let steady = CaptureParams { views: 12, ..Default::default() };
        let bumped = CaptureParams { bump_view: 5, bump_mm: 1.8, bump_deg: 0.5, ..steady.clone() };
        let (before, after) = (capture(&steady, &tank, 4).unwrap(), capture(&bumped, &tank, 4).unwrap());
        let bump = Bump::of(&bumped, 4).unwrap();
        for (i, (a, b)) in before.iter().zip(&after).enumerate() {
            b.check().unwrap();
            let moved = (a.centre_in_tank() - b.centre_in_tank()).norm();
            let turned = b.rotation * a.rotation.transpose() - Mat3::identity();
            // |T - 1| = 2 √2 sin(angle / 2) in the Frobenius norm.
            let turned = (2.0 * (turned.norm() / 8f64.sqrt()).asin()).to_degrees();
            let (mm, degrees) = if i < 5 { (0.0, 0.0) } else { (1.8, 0.5) };
            assert!((moved - mm).abs() < 1e-9 && (turned - degrees).abs() < 1e-6, "{i}: {moved} {turned}");
            let undone = bump.undone(i, b);
            assert!((undone.centre_in_tank() - a.centre_in_tank()).norm() < 1e-9);
            assert!((undone.rotation - a.rotation).norm() < 1e-12);
        }
    }
}
