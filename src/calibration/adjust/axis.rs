//! The line that the table turned about, as unknowns of the adjustment.

use crate::optics::Vec3;
use nalgebra::SVector;

/// Unknowns of the axis: two tilts, two coordinates of its point, b, q.
pub const AXIS: usize = 10;

/// The table's axis in the tank frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Its direction is `(tilt_0, tilt_1, 1)`, normalised.
    pub tilt: [f64; 2],
    /// Where it passes the height `middle_mm`, mm.
    pub point_mm: [f64; 2],
    /// That height, mm.
    pub middle_mm: f64,
    /// The direction as all cameras see it.
    pub seen: Vec3,
    /// The point as all cameras see it, mm.
    pub seen_mm: Vec3,
}

/// How far the poses are from turns about one axis: half of them less than this per number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Play {
    /// Of the axis' direction, radians.
    pub wobble: f64,
    /// Of its place, mm.
    pub play_mm: f64,
}

impl Axis {
    /// Moved by a step of its unknowns.
    pub fn stepped(&self, step: &SVector<f64, AXIS>) -> Self {
        Self {
            tilt: [self.tilt[0] + step[0], self.tilt[1] + step[1]],
            point_mm: [self.point_mm[0] + step[2], self.point_mm[1] + step[3]],
            middle_mm: self.middle_mm,
            seen: self.seen + Vec3::new(step[4], step[5], step[6]),
            seen_mm: self.seen_mm + Vec3::new(step[7], step[8], step[9]),
        }
    }
}
