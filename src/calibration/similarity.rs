//! The scaled rigid motion M₀ from the frame of structure from motion to the tank's.  Paper 2.2.3.

use super::sparse::SparseModel;
use crate::optics::{Mat3, Vec3, View, turn_about_z};
use serde::{Deserialize, Serialize};

/// `x_tank = scale rotation x_sfm + translation`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Similarity {
    /// mm per unit of the model.
    pub scale: f64,
    /// Rotation part.
    pub rotation: Mat3,
    /// Translation part, mm.
    pub translation_mm: Vec3,
}

impl Similarity {
    /// A point of the model in the tank frame.
    pub fn point(&self, x: &Vec3) -> Vec3 {
        self.rotation * x * self.scale + self.translation_mm
    }

    /// All views of the model in the tank frame.
    pub fn views(&self, model: &SparseModel) -> Vec<View> {
        model
            .views
            .iter()
            .map(|v| {
                let rotation = v.rotation * self.rotation.transpose();
                let translation_mm = v.translation * self.scale - rotation * self.translation_mm;
                View { lens: v.lens, rotation, translation_mm }
            })
            .collect()
    }

    /// The same motion followed by a turn about the tank's axis.
    #[must_use]
    pub fn turned(&self, angle: f64) -> Self {
        let turn = turn_about_z(angle);
        Self { scale: self.scale, rotation: turn * self.rotation, translation_mm: turn * self.translation_mm }
    }
}

/// Turns all views about the tank's axis so that the first camera's centre lies at azimuth 0 (on +x);
/// returns the angle of the turn that was applied to the tank's points.
pub fn first_view_to_azimuth_zero(views: &mut [View]) -> f64 {
    let Some(first) = views.first() else { return 0.0 };
    let centre = first.centre_in_tank();
    let angle = -centre.y.atan2(centre.x);
    let back = turn_about_z(angle).transpose();
    for view in views {
        view.rotation *= back;
    }
    angle
}
