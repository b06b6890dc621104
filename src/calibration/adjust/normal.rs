//! The normal equations with the points eliminated.

use super::state::{COMMON, Contour, Network, POSE, Projection, Shape, State, on_cylinder};
use super::{AdjustParams, Loss};
use crate::optics::Vec3;
use nalgebra::{DMatrix, DVector, Matrix2, SMatrix, Vector2};

/// Standard deviations of the residuals, px.
#[derive(Debug, Clone)]
pub(super) struct Sigmas {
    /// Per track and sighting.
    pub belt_px: Vec<Vec<f64>>,
    /// Of the outline's rings and of its sides.
    pub outline_px: [f64; 2],
}

impl Sigmas {
    /// Of outline point `k`.
    fn of_outline(&self, network: &Network, k: usize) -> f64 {
        self.outline_px[usize::from(network.contours[network.outline[k].contour].is_side())]
    }
}

/// What one point leaves behind for its own step.
pub(super) struct Eliminated {
    inverse: Matrix2<f64>,
    right: Vector2<f64>,
    /// Coupling with the lens and, per sighting, with a pose.
    lens: SMatrix<f64, COMMON, 2>,
    poses: Vec<(usize, SMatrix<f64, POSE, 2>)>,
}

pub(super) struct Normal {
    pub matrix: DMatrix<f64>,
    pub right: DVector<f64>,
    pub points: Vec<Eliminated>,
}

impl Normal {
    /// The points' steps that go with a step of the rest.
    pub fn point_steps(&self, step: &DVector<f64>) -> Vec<Vector2<f64>> {
        let lens = step.fixed_rows::<COMMON>(0);
        let of = |p: &Eliminated| {
            let mut right = p.right - p.lens.transpose() * lens;
            for (at, w) in &p.poses {
                right -= w.transpose() * step.fixed_rows::<POSE>(*at);
            }
            p.inverse * right
        };
        self.points.iter().map(of).collect()
    }
}

/// Distance of an outline point from its contour along the contour's outward normal in the picture, with the
/// normal; also the place along the contour of its nearest point.
pub(super) struct OutlineResidual {
    pub value: f64,
    pub normal: Vector2<f64>,
    pub along: f64,
    pub projection: Projection,
}

pub(super) fn outline_residual(network: &Network, state: &State, k: usize) -> Option<OutlineResidual> {
    let seen = &network.outline[k];
    let contour = &network.contours[seen.contour];
    let radius_mm = contour.radius_mm + state.thicker_mm;
    let target = Vector2::new(seen.u, seen.v);
    let mut along = state.along[k];
    // Where the sight grazes the surface a turn of the surface moves no pixel to first order: a side's azimuth is held.
    let side = match contour.shape {
        Shape::Ring { .. } => 0.0,
        Shape::Side { turn, .. } => {
            let (r, t) = &state.poses[seen.view];
            Contour::side_azimuth(turn, radius_mm, &-(r.transpose() * t))?
        }
    };
    let place = |along: f64| match contour.shape {
        Shape::Ring { z_mm, .. } => (along, z_mm),
        Shape::Side { .. } => (side, along),
    };
    // A ring seen edge-on turns back at its ends: the step is bounded there.
    let (column, bound) = if contour.is_side() { (1, 5.0) } else { (0, 0.05) };
    for _ in 0..3 {
        let (azimuth, z_mm) = place(along);
        let (x, by) = on_cylinder(radius_mm, azimuth, z_mm);
        let p = state.project(seen.view, &x)?;
        let tangent = p.by_point * by.column(column);
        along += (tangent.dot(&(target - p.pixel)) / tangent.norm_squared().max(1e-12)).clamp(-bound, bound);
    }
    let (azimuth, z_mm) = place(along);
    let (x, by) = on_cylinder(radius_mm, azimuth, z_mm);
    let projection = state.project(seen.view, &x)?.rides_on_radius(azimuth);
    let tangent: Vector2<f64> = (projection.by_point * by.column(column)).normalize();
    let mut normal = Vector2::new(-tangent.y, tangent.x);
    let away = match contour.shape {
        Shape::Ring { outward, .. } => Vec3::new(0.0, 0.0, outward),
        Shape::Side { .. } => Vec3::new(azimuth.cos(), azimuth.sin(), 0.0),
    };
    if normal.dot(&(projection.by_point * away)) < 0.0 {
        normal = -normal;
    }
    let value = normal.dot(&(projection.pixel - target)) + state.offsets[seen.contour];
    Some(OutlineResidual { value, normal, along, projection })
}

/// Prior residuals of the unknowns: (index, deviation from the prior's mean, standard deviation);
/// standard deviation 0 holds the unknown.
pub(super) fn priors(network: &Network, params: &AdjustParams, state: &State) -> Vec<(usize, f64, f64)> {
    let l = state.common_values();
    let (w, h) = (state.lens.width as f64, state.lens.height as f64);
    let centre = params.principal_point_sigma * w;
    let mut out = vec![
        (1, l[1] - 0.5 * (w - 1.0), centre),
        (2, l[2] - 0.5 * (h - 1.0), centre),
        (3, l[3], params.radial_sigma),
        (4, l[4], params.radial_sigma),
        (5, l[5], params.tangential_sigma),
        (6, l[6], params.tangential_sigma),
        (7, l[7], params.k3_sigma),
        (8, l[8], params.radius_sigma_mm),
    ];
    if network.holds_lens {
        // All but the printed surface's radius.
        out.retain(|(k, ..)| *k == COMMON - 1);
        out.extend((0..COMMON - 1).map(|k| (k, 0.0, 0.0)));
    } else if let Some((focal, sigma)) = network.focal_prior_px {
        out.push((0, l[0] - focal, sigma));
    }
    out.extend(state.offsets.iter().enumerate().map(|(k, o)| (state.offset_index(k), *o, params.edge_offset_sigma_px)));
    out
}

/// Robust cost: Σ scale² ρ(r / scale σ), plus priors; sightings behind a camera count as far outliers.
pub(super) fn cost(network: &Network, params: &AdjustParams, state: &State, sigmas: &Sigmas) -> f64 {
    let scale = params.loss_scale;
    let rho = |x: f64| scale * scale * params.loss.rho(x / scale);
    let mut sum = 0.0;
    for ((track, &(azimuth, z)), sigma) in network.tracks.iter().zip(&state.points).zip(&sigmas.belt_px) {
        let (x, _) = on_cylinder(network.belt_radius_mm + state.thicker_mm, azimuth, z);
        for (s, sigma_px) in track.iter().zip(sigma) {
            let miss = state.project(s.view, &x).map_or(1e3, |p| (p.pixel - Vector2::new(s.u, s.v)).norm());
            sum += rho(miss / sigma_px);
        }
    }
    for k in 0..network.outline.len() {
        sum += rho(outline_residual(network, state, k).map_or(1e3, |r| r.value) / sigmas.of_outline(network, k));
    }
    if let Some((axis, play)) = &state.axis {
        for r in state.poses.iter().map(|pose| axis.residual(pose)) {
            sum += rho(r.wobble.norm() / play.wobble) + rho(r.play_mm.norm() / play.play_mm);
        }
    }
    for (_, miss, sigma) in priors(network, params, state) {
        if sigma > 0.0 {
            sum += (miss / sigma).powi(2);
        }
    }
    sum
}

/// Normal equations at `state`; `damping` multiplies the diagonals by 1 + damping.
pub(super) fn normal(network: &Network, params: &AdjustParams, state: &State, sigmas: &Sigmas, damping: f64) -> Normal {
    let n = state.size();
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let mut right = DVector::<f64>::zeros(n);
    let weight = |x: f64| Loss::weight(params.loss, x / params.loss_scale);
    let mut points = Vec::with_capacity(network.tracks.len());
    for ((track, &(azimuth, z)), sigma) in network.tracks.iter().zip(&state.points).zip(&sigmas.belt_px) {
        let (x, by) = on_cylinder(network.belt_radius_mm + state.thicker_mm, azimuth, z);
        let mut point = Matrix2::zeros();
        let mut point_right = Vector2::zeros();
        let mut lens = SMatrix::<f64, COMMON, 2>::zeros();
        let mut poses = Vec::with_capacity(track.len());
        for (s, sigma_px) in track.iter().zip(sigma) {
            let Some(p) = state.project(s.view, &x) else { continue };
            let p = p.rides_on_radius(azimuth);
            let miss = p.pixel - Vector2::new(s.u, s.v);
            let w = weight(miss.norm() / sigma_px) / (sigma_px * sigma_px);
            let by_point: Matrix2<f64> = p.by_point * by;
            let at = state.pose_index(s.view);
            add(&mut matrix, 0, 0, &(p.by_common.transpose() * p.by_common * w));
            add(&mut matrix, 0, at, &(p.by_common.transpose() * p.by_pose * w));
            add(&mut matrix, at, at, &(p.by_pose.transpose() * p.by_pose * w));
            add_vector(&mut right, 0, &(p.by_common.transpose() * miss * -w));
            add_vector(&mut right, at, &(p.by_pose.transpose() * miss * -w));
            point += by_point.transpose() * by_point * w;
            point_right -= by_point.transpose() * miss * w;
            lens += p.by_common.transpose() * by_point * w;
            poses.push((at, p.by_pose.transpose() * by_point * w));
        }
        point[(0, 0)] *= 1.0 + damping;
        point[(1, 1)] *= 1.0 + damping;
        let inverse = point.try_inverse().unwrap_or_else(Matrix2::zeros);
        points.push(Eliminated { inverse, right: point_right, lens, poses });
    }
    for k in 0..network.outline.len() {
        let Some(r) = outline_residual(network, state, k) else { continue };
        let sigma_px = sigmas.of_outline(network, k);
        let w = weight(r.value / sigma_px) / (sigma_px * sigma_px);
        let by_common = r.normal.transpose() * r.projection.by_common;
        let by_pose = r.normal.transpose() * r.projection.by_pose;
        let at = state.pose_index(network.outline[k].view);
        let offset = state.offset_index(network.outline[k].contour);
        add(&mut matrix, 0, 0, &(by_common.transpose() * by_common * w));
        add(&mut matrix, 0, offset, &(by_common.transpose() * w));
        add(&mut matrix, 0, at, &(by_common.transpose() * by_pose * w));
        matrix[(offset, offset)] += w;
        add(&mut matrix, offset, at, &(by_pose * w));
        add(&mut matrix, at, at, &(by_pose.transpose() * by_pose * w));
        add_vector(&mut right, 0, &(by_common.transpose() * (-w * r.value)));
        right[offset] -= w * r.value;
        add_vector(&mut right, at, &(by_pose.transpose() * (-w * r.value)));
    }
    if let Some((axis, play)) = &state.axis {
        let first = state.axis_index();
        for (view, pose) in state.poses.iter().enumerate() {
            let (r, at) = (axis.residual(pose), state.pose_index(view));
            let parts = [(r.wobble, play.wobble), (r.play_mm, play.play_mm)];
            for ((miss, sigma), (by_axis, by_pose)) in parts.into_iter().zip(r.by_axis.iter().zip(&r.by_pose)) {
                let w = weight(miss.norm() / sigma) / (sigma * sigma);
                add(&mut matrix, first, first, &(by_axis.transpose() * by_axis * w));
                add(&mut matrix, first, at, &(by_axis.transpose() * by_pose * w));
                add(&mut matrix, at, at, &(by_pose.transpose() * by_pose * w));
                add_vector(&mut right, first, &(by_axis.transpose() * miss * -w));
                add_vector(&mut right, at, &(by_pose.transpose() * miss * -w));
            }
        }
    }
    let mut held = Vec::new();
    for (k, miss, sigma) in priors(network, params, state) {
        if sigma > 0.0 {
            matrix[(k, k)] += 1.0 / (sigma * sigma);
            right[k] -= miss / (sigma * sigma);
        } else {
            held.push(k);
        }
    }
    for k in 0..n {
        matrix[(k, k)] *= 1.0 + damping;
    }
    for p in &points {
        eliminate(&mut matrix, &mut right, p);
    }
    matrix.fill_lower_triangle_with_upper_triangle();
    for k in held {
        matrix.row_mut(k).fill(0.0);
        matrix.column_mut(k).fill(0.0);
        matrix[(k, k)] = 1.0;
        right[k] = 0.0;
    }
    Normal { matrix, right, points }
}

/// Takes one point out: `S -= W V⁻¹ Wᵀ`, `g -= W V⁻¹ g_p`, in the upper triangle.
fn eliminate(matrix: &mut DMatrix<f64>, right: &mut DVector<f64>, p: &Eliminated) {
    let solved = p.inverse * p.right;
    let lens = p.lens * p.inverse;
    add(matrix, 0, 0, &-(lens * p.lens.transpose()));
    add_vector(right, 0, &-(p.lens * solved));
    for (k, (at, w)) in p.poses.iter().enumerate() {
        add_vector(right, *at, &-(w * solved));
        add(matrix, 0, *at, &-(lens * w.transpose()));
        let y = w * p.inverse;
        for (other, v) in &p.poses[k..] {
            let block = -(y * v.transpose());
            if at == other && !std::ptr::eq(w, v) {
                // One view sees the point twice: both halves fall on the diagonal block.
                add(matrix, *at, *at, &(block + block.transpose()));
            } else if at <= other {
                add(matrix, *at, *other, &block);
            } else {
                add(matrix, *other, *at, &block.transpose());
            }
        }
    }
}

fn add<const R: usize, const C: usize>(
    matrix: &mut DMatrix<f64>,
    row: usize,
    column: usize,
    block: &SMatrix<f64, R, C>,
) {
    let mut part = matrix.fixed_view_mut::<R, C>(row, column);
    part += block;
}

fn add_vector<const R: usize>(vector: &mut DVector<f64>, row: usize, block: &SMatrix<f64, R, 1>) {
    let mut part = vector.fixed_rows_mut::<R>(row);
    part += block;
}
