//! Standard deviations in units that a person understands, from the inverse of the normal equations.
//!
//! The turn about the axis is not observable: the normal matrix is singular along `ω_l = R_l e_z`, and
//! one stiff equation holds it. Linear functions of the unknowns then have the variance `jᵀ N⁻¹ j`.

use super::AdjustParams;
use super::normal::{Sigmas, normal};
use super::state::{COMMON, Network, POSE, State, on_cylinder};
use crate::error::{Error, Result};
use crate::optics::{Mat3, Vec3};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// One standard deviation of each.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Uncertainty {
    /// Focal length, px.
    pub focal_px: f64,
    /// Principal point, px.
    pub principal_point_px: [f64; 2],
    /// k1, k2, p1, p2, k3.
    pub distortion: [f64; 5],
    /// Common pitch of the cameras against the tank, degrees.
    pub pitch_deg: f64,
    /// Common roll of the cameras against the tank, degrees.
    pub roll_deg: f64,
    /// Radius of the printed surface, mm.
    pub radius_mm: f64,
    /// Distance of the cameras from the axis, as a part of itself (scale).
    pub scale: f64,
    /// Tilt of the ring of cameras against the tank's axis, degrees.
    pub axis_tilt_deg: f64,
    /// Offset of the ring of cameras from the tank's axis, mm.
    pub axis_offset_mm: f64,
    /// Height of the cameras above the tank's frame, mm.
    pub height_mm: f64,
    /// Pixel of a point on the tank's wall, px (root mean square over views, front and sides, heights).
    pub wall_px: f64,
}

type Weights<'a> = dyn Fn(&(Mat3, Vec3)) -> (Vec3, Vec3) + 'a;

pub(super) fn uncertainty(
    network: &Network,
    params: &AdjustParams,
    state: &State,
    sigmas: &Sigmas,
) -> Result<Uncertainty> {
    let mut matrix = normal(network, params, state, sigmas, 0.0).matrix;
    let n = state.size();
    let mut turn = DVector::<f64>::zeros(n);
    for (view, (r, _)) in state.poses.iter().enumerate() {
        turn.fixed_rows_mut::<3>(state.pose_index(view)).copy_from(&r.column(2));
    }
    let stiff = matrix.diagonal().max();
    matrix += &turn * turn.transpose() * stiff;
    let mut inverse = matrix
        .cholesky()
        .ok_or_else(|| {
            Error::failed("something about cameras and tank is not observable: the normal equations are singular")
                .help("more photographs around the tank, or belts at both ends, are needed")
        })?
        .inverse();
    if network.holds_lens {
        // What is known has no deviation.
        for k in 0..COMMON - 1 {
            inverse.row_mut(k).fill(0.0);
            inverse.column_mut(k).fill(0.0);
        }
    }
    let sigma = |j: &DVector<f64>| (j.dot(&(&inverse * j))).max(0.0).sqrt();
    let unit = |k: usize| inverse[(k, k)].max(0.0).sqrt();

    let views = state.poses.len() as f64;
    let centre = |(r, t): &(Mat3, Vec3)| -(r.transpose() * t);
    // δC = Rᵀ(ω x t) - Rᵀ δt
    let by_pose = |(r, t): &(Mat3, Vec3)| (-(r.transpose() * t.cross_matrix()), -r.transpose());
    // Per pose: weight of its turn and of its centre's shift.
    let linear = |weights: &Weights| {
        let mut j = DVector::<f64>::zeros(n);
        for (view, pose) in state.poses.iter().enumerate() {
            let (by_turn, by_centre) = weights(pose);
            let (a, b) = by_pose(pose);
            let at = state.pose_index(view);
            j.fixed_rows_mut::<3>(at).copy_from(&(by_turn + a.transpose() * by_centre));
            j.fixed_rows_mut::<3>(at + 3).copy_from(&(b.transpose() * by_centre));
        }
        sigma(&j)
    };
    let flat = |x: Vec3| Vec3::new(x.x, x.y, 0.0);
    let mean = state.poses.iter().map(|p| flat(centre(p))).sum::<Vec3>() / views;
    let size: f64 = state.poses.iter().map(|p| flat(centre(p) - mean).norm_squared()).sum();
    let sway = |axis: usize| {
        let weight = |p: &(Mat3, Vec3)| (Vec3::zeros(), Vec3::z() * (2.0 * flat(centre(p) - mean)[axis] / size));
        linear(&weight)
    };
    let shift = |axis: usize| linear(&|_| (Vec3::zeros(), Vec3::ith(axis, 1.0 / views)));
    Ok(Uncertainty {
        focal_px: unit(0),
        principal_point_px: [unit(1), unit(2)],
        distortion: [unit(3), unit(4), unit(5), unit(6), unit(7)],
        radius_mm: unit(8),
        pitch_deg: linear(&|_| (Vec3::x() / views, Vec3::zeros())).to_degrees(),
        roll_deg: linear(&|_| (Vec3::z() / views, Vec3::zeros())).to_degrees(),
        scale: linear(&|p| (Vec3::zeros(), flat(centre(p) - mean) / size)),
        axis_tilt_deg: sway(0).hypot(sway(1)).to_degrees(),
        axis_offset_mm: shift(0).hypot(shift(1)),
        height_mm: shift(2),
        wall_px: wall_px(network, state, &inverse),
    })
}

/// Test points: five heights between the outermost rings (or belt points), at the front and 60 degrees
/// to either side, in every view.
fn wall_px(network: &Network, state: &State, inverse: &DMatrix<f64>) -> f64 {
    let heights = network.ring_heights_mm().into_iter().chain(state.points.iter().map(|p| p.1));
    let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), z| (a.min(z), b.max(z)));
    let (mut sum, mut count) = (0.0, 0_usize);
    for (view, (r, t)) in state.poses.iter().enumerate() {
        let centre = -(r.transpose() * t);
        let front = centre.y.atan2(centre.x);
        for side in [-1.0, 0.0, 1.0] {
            for k in 0..5 {
                let z = low + (high - low) * f64::from(k) / 4.0;
                let (x, _) = on_cylinder(network.belt_radius_mm + state.thicker_mm, front + side * 1.047, z);
                let Some(p) = state.project(view, &x) else { continue };
                let at = state.pose_index(view);
                for row in 0..2 {
                    let mut j = DVector::<f64>::zeros(COMMON + POSE);
                    j.rows_mut(0, COMMON).copy_from(&p.by_common.row(row).transpose());
                    j.rows_mut(COMMON, POSE).copy_from(&p.by_pose.row(row).transpose());
                    let index: Vec<usize> = (0..COMMON).chain(at..at + POSE).collect();
                    let part = DMatrix::from_fn(COMMON + POSE, COMMON + POSE, |a, b| inverse[(index[a], index[b])]);
                    sum += j.dot(&(part * &j));
                }
                count += 1;
            }
        }
    }
    (sum / count.max(1) as f64).max(0.0).sqrt()
}
