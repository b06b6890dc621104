//! The one-axis prior: the camera stands still and the table turns about one axis, so that N poses are N angles and one
//! pose.
//!
//! Poses `(R_l, t_l)` are turns about the line through `p` along `a` (tank frame) exactly where both look the same from
//! every camera: `R_l a = b` and `R_l p + t_l = q` for all l. The angles drop out. Direction (two numbers), point (two, at
//! the rings' mean height), b and q are unknowns of the adjustment beside the poses; the residuals are `R_l a - b`, divided by the
//! wobble of the axis, and `R_l p + t_l - q`, divided by its play. Both are medians of the same
//! residuals' sizes per number, of poses adjusted without the prior: a table that wobbles, or a camera that was moved,
//! makes it weak.

use super::axis::{AXIS, Axis, Play};
use super::state::{POSE, State};
use crate::math::robust::median;
use crate::optics::Vec3;
use nalgebra::{Matrix3x2, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// How the table turned, for people.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Turning {
    /// Angle between the table's axis and the tank's, degrees.
    pub tilt_deg: f64,
    /// Distance between the two at the mean height of rim, floor and belt edges, mm.
    pub offset_mm: f64,
    /// By how much the axis' direction varied from photograph to photograph, degrees.
    pub wobble_deg: f64,
    /// By how much its place varied, mm.
    pub play_mm: f64,
    /// Where the camera was moved, once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bump: Option<Bump>,
}

/// The camera was moved between two photographs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Bump {
    /// Index of the first view after it.
    pub view: usize,
    /// How far the table's axis moved in the camera's frame, mm.
    pub moved_mm: f64,
    /// By how much its direction changed there, degrees.
    pub turned_deg: f64,
}

/// A bump has to leave so small a part of the residuals' squares.
const LEFT_OVER: f64 = 0.2;
/// A smaller one is none: degrees, mm.
const BUMPED: (f64, f64) = (0.03, 0.2);

/// Residuals of one view with their derivatives by its pose and by the axis, not yet divided.
pub(super) struct Residual {
    pub wobble: Vec3,
    pub play_mm: Vec3,
    pub by_pose: [SMatrix<f64, 3, POSE>; 2],
    pub by_axis: [SMatrix<f64, 3, AXIS>; 2],
}

impl Axis {
    /// The line of the tank's own axis, seen as the mean over the poses.
    pub fn begin(state: &State, middle_mm: f64) -> Self {
        let nowhere = Vec3::zeros();
        let mut axis = Self { tilt: [0.0; 2], point_mm: [0.0; 2], middle_mm, seen: nowhere, seen_mm: nowhere };
        let views = state.poses.len() as f64;
        axis.seen = state.poses.iter().map(|(r, _)| r * axis.direction().0).sum::<Vec3>() / views;
        axis.seen_mm = state.poses.iter().map(|(r, t)| r * axis.point() + t).sum::<Vec3>() / views;
        axis
    }

    /// Direction, and its derivatives by the tilts.
    fn direction(&self) -> (Vec3, Matrix3x2<f64>) {
        let raw = Vec3::new(self.tilt[0], self.tilt[1], 1.0);
        let length = raw.norm();
        let a = raw / length;
        let by = |k: usize| (Vec3::ith(k, 1.0) - a * a[k]) / length;
        (a, Matrix3x2::from_columns(&[by(0), by(1)]))
    }

    fn point(&self) -> Vec3 {
        Vec3::new(self.point_mm[0], self.point_mm[1], self.middle_mm)
    }

    /// The residuals of a pose.
    pub fn residual(&self, (r, t): &(crate::optics::Mat3, Vec3)) -> Residual {
        let (a, by_tilt) = self.direction();
        let (turned, moved) = (r * a, r * self.point());
        let mut by_pose = [SMatrix::<f64, 3, POSE>::zeros(), SMatrix::<f64, 3, POSE>::zeros()];
        let mut by_axis = [SMatrix::<f64, 3, AXIS>::zeros(), SMatrix::<f64, 3, AXIS>::zeros()];
        // exp(ω) x = x + ω x x.
        by_pose[0].fixed_columns_mut::<3>(0).copy_from(&-turned.cross_matrix());
        by_pose[1].fixed_columns_mut::<3>(0).copy_from(&-moved.cross_matrix());
        by_pose[1].fixed_columns_mut::<3>(3).fill_with_identity();
        by_axis[0].fixed_columns_mut::<2>(0).copy_from(&(r * by_tilt));
        by_axis[0].fixed_columns_mut::<3>(4).copy_from(&-crate::optics::Mat3::identity());
        by_axis[1].fixed_columns_mut::<2>(2).copy_from(&r.fixed_columns::<2>(0));
        by_axis[1].fixed_columns_mut::<3>(7).copy_from(&-crate::optics::Mat3::identity());
        Residual { wobble: turned - self.seen, play_mm: moved + t - self.seen_mm, by_pose, by_axis }
    }

    /// The axis about which the poses come nearest to turns: least squares of both residuals, by Gauss-Newton.
    pub fn fitted(state: &State, middle_mm: f64) -> Self {
        let mut axis = Self::begin(state, middle_mm);
        // Nearly linear: the direction is nearly the tank's.
        for _ in 0..5 {
            let (mut matrix, mut right) = (SMatrix::<f64, AXIS, AXIS>::zeros(), SVector::<f64, AXIS>::zeros());
            for pose in &state.poses {
                let r = axis.residual(pose);
                for (miss, by) in [(r.wobble, r.by_axis[0]), (r.play_mm, r.by_axis[1])] {
                    matrix += by.transpose() * by;
                    right -= by.transpose() * miss;
                }
            }
            let Some(step) = matrix.cholesky().map(|c| c.solve(&right)) else { break };
            axis = axis.stepped(&step);
        }
        axis
    }

    /// How far the poses are from turns about this axis.
    pub fn play(&self, state: &State) -> Play {
        // `R a - b` has no part along b: two of its three numbers vary.
        let misses = state.poses.iter().map(|pose| self.residual(pose));
        let (mut wobbles, mut plays): (Vec<f64>, Vec<f64>) =
            misses.map(|r| (r.wobble.norm() / 2_f64.sqrt(), r.play_mm.norm() / 3_f64.sqrt())).unzip();
        Play { wobble: median(&mut wobbles), play_mm: median(&mut plays) }
    }

    /// Where the camera was moved, if it was once: the split of the views in two runs that leaves the least of the squares of
    /// the residuals, which are the axis' direction and place as each camera sees them.
    fn bump(&self, state: &State) -> Option<Bump> {
        let misses: Vec<(Vec3, Vec3)> =
            state.poses.iter().map(|pose| self.residual(pose)).map(|r| (r.wobble, r.play_mm)).collect();
        let mean = |part: &[(Vec3, Vec3)]| {
            let n = part.len() as f64;
            (part.iter().map(|m| m.0).sum::<Vec3>() / n, part.iter().map(|m| m.1).sum::<Vec3>() / n)
        };
        // Both kinds in units of what a bump has at least.
        let squares = |part: &[(Vec3, Vec3)]| {
            let (wobble, play) = mean(part);
            let of = |m: &(Vec3, Vec3)| {
                ((m.0 - wobble).norm() / BUMPED.0.to_radians()).powi(2) + ((m.1 - play).norm() / BUMPED.1).powi(2)
            };
            part.iter().map(of).sum::<f64>()
        };
        let n = misses.len();
        let left = |at: usize| squares(&misses[..at]) + squares(&misses[at..]);
        let view = (1..n).min_by(|a, b| left(*a).total_cmp(&left(*b)))?;
        let (before, after) = (mean(&misses[..view]), mean(&misses[view..]));
        let (turned_deg, moved_mm) = ((after.0 - before.0).norm().to_degrees(), (after.1 - before.1).norm());
        let is_one = left(view) < LEFT_OVER * squares(&misses) && (turned_deg > BUMPED.0 || moved_mm > BUMPED.1);
        is_one.then_some(Bump { view, moved_mm, turned_deg })
    }

    /// For people; `state` holds the poses adjusted without the axis.
    pub fn turning(&self, play: &Play, state: &State) -> Turning {
        Turning {
            tilt_deg: self.tilt[0].hypot(self.tilt[1]).atan().to_degrees(),
            offset_mm: self.point_mm[0].hypot(self.point_mm[1]),
            wobble_deg: play.wobble.to_degrees(),
            play_mm: play.play_mm,
            bump: self.bump(state),
        }
    }
}
