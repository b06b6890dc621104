//! The loop: standard deviations, Levenberg-Marquardt, again.

use super::AdjustParams;
use super::axis::{Axis, Play};
use super::covariance::{Uncertainty, uncertainty};
use super::normal::{Sigmas, cost, normal, outline_residual};
use super::state::{Network, Start, State, on_cylinder};
use super::turning::Turning;
use crate::calibration::sparse::Sighting;
use crate::error::{Error, Result};
use crate::math::robust::spread;
use crate::optics::{Vec3, View};
use nalgebra::Vector2;

/// The adjusted geometry.
#[derive(Debug, Clone)]
pub struct Adjusted {
    /// Views in the tank frame, still free to turn about z.
    pub views: Vec<View>,
    /// Belt points, mm.
    pub points_mm: Vec<Vec3>,
    /// Robust standard deviation of the belt points' residuals, px.
    pub belt_sigma_px: f64,
    /// Root mean square of the belt points' residuals (distance in the picture), px.
    pub belt_rms_px: f64,
    /// Robust standard deviation of the residuals of the outline's rings, px; NaN without outline.
    pub outline_sigma_px: f64,
    /// By how much the printed surface's radius exceeds the given one, mm.
    pub thicker_mm: f64,
    /// Common offset of each contour's edge, px.
    pub edge_offsets_px: Vec<f64>,
    /// From each outline point to its contour, its common offset taken off, px.
    pub misses_px: Vec<[f64; 2]>,
    /// Median residual of each view's belt points, px.
    pub view_residuals_px: Vec<f64>,
    /// How the table turned, by poses adjusted without the prior that it turns about one axis.
    pub turning: Turning,
    /// Standard deviations.
    pub uncertainty: Uncertainty,
}

/// Adjusts everything together from `start`.
///
/// # Errors
/// Too few belt points, or normal equations that cannot be solved (numbers that are not finite).
pub fn adjust(network: &Network, start: &Start, params: &AdjustParams) -> Result<Adjusted> {
    let sightings: usize = network.tracks.iter().map(Vec::len).sum();
    let unknowns = 6 * start.views.len() + 8;
    if start.views.len() < 3 || 2 * sightings < unknowns + 2 * network.tracks.len() {
        return Err(Error::failed(format!(
            "{} belt points seen {sightings} times do not hold {} views",
            network.tracks.len(),
            start.views.len()
        ))
        .help("the belts need a random print of high contrast, sharp and well lit"));
    }
    let mut state = State {
        lens: start.views[0].lens,
        thicker_mm: 0.0,
        poses: start.views.iter().map(|v| (v.rotation, v.translation_mm)).collect(),
        points: start.points_mm.iter().map(|p| (p.y.atan2(p.x), p.z)).collect(),
        along: network.outline.iter().map(|o| o.along).collect(),
        offsets: vec![0.0; network.contours.len()],
        axis: None,
    };
    let heights = network.ring_heights_mm();
    let middle_mm = heights.iter().sum::<f64>() / heights.len().max(1) as f64;
    let mut sigmas = measure(network, &state);
    let mut turning = None;
    for _ in 0..params.rounds {
        descend(network, params, &mut state, &sigmas)?;
        sigmas = measure(network, &state);
        if turning.is_none() {
            let axis = Axis::fitted(&state, middle_mm);
            let play = axis.play(&state);
            turning = Some(axis.turning(&play, &state));
            // As little play as the prior ever allows: a ten-thousandth of a pixel at the wall.
            let play = Play { wobble: play.wobble.max(1e-7), play_mm: play.play_mm.max(1e-5) };
            state.axis = params.one_axis.then_some((axis, play));
        }
    }
    let uncertainty = uncertainty(network, params, &state, &sigmas)?;
    let (mut sum, mut count) = (0.0, 0_usize);
    let mut by_view = vec![Vec::new(); state.poses.len()];
    each_belt_miss(network, &state, |view, miss| {
        sum += miss.norm_squared();
        count += 1;
        by_view[view].push(miss.norm());
    });
    let point = |&(azimuth, z): &(f64, f64)| on_cylinder(network.belt_radius_mm + state.thicker_mm, azimuth, z).0;
    Ok(Adjusted {
        views: state.views(),
        points_mm: state.points.iter().map(point).collect(),
        belt_sigma_px: frontal_sigma_px(network, &state),
        belt_rms_px: (sum / count.max(1) as f64).sqrt(),
        outline_sigma_px: if network.outline.is_empty() { f64::NAN } else { sigmas.outline_px[0] },
        thicker_mm: state.thicker_mm,
        edge_offsets_px: state.offsets.clone(),
        misses_px: (0..network.outline.len()).map(|k| outline_miss(network, &state, k)).collect(),
        view_residuals_px: by_view.iter_mut().map(|v| crate::math::robust::median(v)).collect(),
        turning: turning.ok_or_else(|| Error::failed("the adjustment ran no round"))?,
        uncertainty,
    })
}

fn outline_miss(network: &Network, state: &State, k: usize) -> [f64; 2] {
    outline_residual(network, state, k).map_or([0.0; 2], |r| (r.normal * r.value).into())
}

fn each_belt_miss(network: &Network, state: &State, mut take: impl FnMut(usize, Vector2<f64>)) {
    for (track, &(azimuth, z)) in network.tracks.iter().zip(&state.points) {
        let (x, _) = on_cylinder(network.belt_radius_mm + state.thicker_mm, azimuth, z);
        for s in track {
            if let Some(p) = state.project(s.view, &x) {
                take(s.view, p.pixel - Vector2::new(s.u, s.v));
            }
        }
    }
}

/// Residual (u, v) of a sighting, px, with its bin of incidence.
type Miss = (f64, f64, usize);

/// Bins of the angle of incidence, 10 degrees each.
const BINS: usize = 9;

fn bin(state: &State, view: usize, x: &Vec3) -> usize {
    let (r, t) = &state.poses[view];
    let to_camera = (-(r.transpose() * t) - x).normalize();
    let cos = (to_camera.x * x.x + to_camera.y * x.y) / x.x.hypot(x.y);
    ((cos.clamp(0.0, 1.0).acos().to_degrees() / 10.0) as usize).min(BINS - 1)
}

/// Standard deviation of sightings at less than 10 degrees of incidence, px; of all where there are none.
fn frontal_sigma_px(network: &Network, state: &State) -> f64 {
    by_incidence(network, state).0[0]
}

/// Robust standard deviation per bin of incidence, with the residuals and bins of all sightings.
/// Features are located the worse the more obliquely their surface is seen: the table is taken from
/// the residuals, never falls with the angle, and fills bins of less than 50 sightings from below.
fn by_incidence(network: &Network, state: &State) -> ([f64; BINS], Vec<Vec<Miss>>) {
    let mut bins: [Vec<f64>; BINS] = std::array::from_fn(|_| Vec::new());
    let mut all = Vec::with_capacity(network.tracks.len());
    for (track, &(azimuth, z)) in network.tracks.iter().zip(&state.points) {
        let (x, _) = on_cylinder(network.belt_radius_mm + state.thicker_mm, azimuth, z);
        let of = |s: &Sighting| {
            let miss = state.project(s.view, &x).map_or(Vector2::new(1e3, 1e3), |p| p.pixel - Vector2::new(s.u, s.v));
            (miss.x, miss.y, bin(state, s.view, &x))
        };
        let track: Vec<_> = track.iter().map(of).collect();
        for &(du, dv, bin) in &track {
            bins[bin].extend([du, dv]);
        }
        all.push(track);
    }
    let mut floor = spread(bins.iter().flatten().copied()).min(f64::MAX);
    let mut table = [0.0; BINS];
    let mut first = true;
    for (sigma, bin) in table.iter_mut().zip(bins) {
        if bin.len() >= 100 {
            let own = spread(bin.into_iter());
            floor = if first { own } else { own.max(floor) };
            first = false;
        }
        *sigma = floor.max(0.02);
    }
    (table, all)
}

/// Standard deviations for the next round: by incidence, times how much worse than its peers a track
/// is (root mean square of its scaled residuals, each held below 3, drawn towards 1 by four more).
fn measure(network: &Network, state: &State) -> Sigmas {
    let (table, misses) = by_incidence(network, state);
    let shared = network.redundancy.sqrt();
    let of = |track: &Vec<Miss>| {
        let scaled = |m: &Miss| (0.5 * (m.0 * m.0 + m.1 * m.1) / table[m.2].powi(2)).min(9.0);
        let sum: f64 = track.iter().map(scaled).sum();
        let factor = ((sum + 4.0) / (track.len() as f64 + 4.0)).sqrt().max(1.0);
        track.iter().map(|m| factor * shared * table[m.2]).collect()
    };
    let outline = |sides: bool| {
        let own =
            (0..network.outline.len()).filter(|&k| network.contours[network.outline[k].contour].is_side() == sides);
        let sigma = spread(own.filter_map(|k| outline_residual(network, state, k).map(|r| r.value)));
        if sigma.is_nan() { 1.0 } else { sigma.max(0.02) }
    };
    Sigmas { belt_px: misses.iter().map(of).collect(), outline_px: [outline(false), outline(true)] }
}

/// Levenberg-Marquardt with Marquardt's scaling.
fn descend(network: &Network, params: &AdjustParams, state: &mut State, sigmas: &Sigmas) -> Result<()> {
    let mut damping = 1e-4;
    let mut here = cost(network, params, state, sigmas);
    for _ in 0..params.steps {
        let equations = normal(network, params, state, sigmas, damping);
        let step = equations.matrix.clone().cholesky().map(|c| c.solve(&equations.right));
        let next = step.filter(|s| s.iter().all(|x| x.is_finite())).map(|step| {
            let mut next = state.stepped(&step);
            for (point, by) in next.points.iter_mut().zip(equations.point_steps(&step)) {
                point.0 += by.x;
                point.1 += by.y;
            }
            for k in 0..network.outline.len() {
                if let Some(r) = outline_residual(network, &next, k) {
                    next.along[k] = r.along;
                }
            }
            let there = cost(network, params, &next, sigmas);
            (next, there)
        });
        match next {
            Some((next, there)) if there < here => {
                let gain = (here - there) / here;
                *state = next;
                here = there;
                damping = (damping * 0.2).max(1e-12);
                if gain < params.tolerance {
                    return Ok(());
                }
            }
            _ => {
                damping *= 10.0;
                if damping > 1e8 {
                    return if here.is_finite() {
                        Ok(())
                    } else {
                        Err(Error::failed("the adjustment of cameras and tank met numbers that are not finite")
                            .help("check tank radius and height, and the start of the registration"))
                    };
                }
            }
        }
    }
    Ok(())
}
