//! From structure from motion to cameras in the tank frame: start, rim and floor, rounds of adjustment.
//!
//! 1. [`start`]: axis, radius and scale from the belts' points.
//! 2. Rim and floor are looked for widely: their middle lays the height, their distance checks the
//!    tank's height against its radius.
//! 3. Adjustment with the tracks of structure from motion.
//! 4. Rounds of: belt points located anew by [`patches`], rings by [`outline`], adjustment.
//! 5. The first camera is turned to azimuth 0.

use super::adjust::{self, AdjustParams, Adjusted, Network, Ring, Uncertainty};
use super::outline::{self, OutlineParams};
use super::patches::{self, PatchParams};
use super::similarity::{Similarity, first_view_to_azimuth_zero, turn_about_z};
use super::sparse::SparseModel;
use super::start::start;
use crate::error::{Error, Result};
use crate::math::robust::median;
use crate::optics::{Tank, Vec3, View};
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};

/// How cameras and tank are brought together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RegisterParams {
    /// Thickness of the printed belts on the tank's outer wall, mm; office paper of 80 g/m² has 0.1.
    pub print_thickness_mm: f64,
    /// Rounds of locating belt points and rings anew, 1..10; the second moves pixels by some 0.01.
    pub rounds: usize,
    /// Belt points by patches; false keeps the feature detector's places, which are off by 0.01 to 0.1 px.
    pub match_patches: bool,
    /// Adjustment.
    pub adjust: AdjustParams,
    /// Belt points.
    pub patches: PatchParams,
    /// Rings.
    pub outline: OutlineParams,
}

impl Default for RegisterParams {
    fn default() -> Self {
        Self {
            print_thickness_mm: 0.1,
            rounds: 2,
            match_patches: true,
            adjust: AdjustParams::default(),
            patches: PatchParams::default(),
            outline: OutlineParams::default(),
        }
    }
}

/// Cameras in the tank frame with what a person wants to know about them.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Registration {
    /// Views in the tank frame, in the order of the sparse model; the first at azimuth 0.
    pub views: Vec<View>,
    /// Belt points, mm.
    pub belt_points_mm: Vec<Vec3>,
    /// The numbers beside them.
    pub quality: Quality,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// How well the photographs bear the registration out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Quality {
    /// Reprojection of structure from motion, root mean square px.
    pub sfm_rms_px: f64,
    /// Belt points and their sightings.
    pub belt_points: usize,
    /// Sightings of belt points.
    pub sightings: usize,
    /// Robust standard deviation of a sighting seen from the front, per coordinate, px.
    pub belt_sigma_px: f64,
    /// Root mean square of all sightings' residuals, px.
    pub belt_rms_px: f64,
    /// Robust standard deviation of the rings' edges, px; 0 without any.
    pub outline_sigma_px: f64,
    /// By how much the printed surface's radius exceeds the tank's and the print's together, mm.
    pub thicker_mm: f64,
    /// Common shift of each ring's edge against the adjusted tank, px, with the ring's name.
    pub edge_offsets_px: Vec<(String, f64)>,
    /// Height of the tank by the photographs, given its radius, mm; `None` where rim or floor is not seen.
    pub seen_height_mm: Option<f64>,
    /// Median residual of each view's belt points, px.
    pub view_residuals_px: Vec<f64>,
    /// Standard deviations.
    pub uncertainty: Uncertainty,
}

/// Registers the views of `model` in the tank frame. `photos` are gray (0..255), one per view of the model.
///
/// # Errors
/// Where the views give no axis, the points no cylinder, or too little is seen to hold the cameras.
pub fn register(
    model: &SparseModel,
    photos: &[ArrayView2<u8>],
    tank: &Tank,
    focal_prior_px: Option<(f64, f64)>,
    params: &RegisterParams,
) -> Result<Registration> {
    if photos.len() != model.views.len() {
        let (p, v) = (photos.len(), model.views.len());
        return Err(Error::failed(format!("{p} photographs do not go with the {v} views of the sparse model")));
    }
    let mut warnings = Vec::new();
    let belt_radius_mm = tank.radius_mm + params.print_thickness_mm;
    let begun = start(model, tank, belt_radius_mm)?;
    let ends = [ring("rim", 0.0, -1.0, belt_radius_mm), ring("floor", tank.height_mm, 1.0, belt_radius_mm)];
    let (tank_from_sfm, seen_height_mm) = lay_height(model, photos, tank, &ends, begun.tank_from_sfm, params);
    check_height(tank, seen_height_mm, begun.extent_mm, &mut warnings);

    let mut rings = ends.to_vec();
    for belt in &tank.belts_mm {
        // The edges that face the water; the others coincide with rim and floor or lie in air.
        let upper = belt[0] + belt[1] < tank.height_mm;
        let (z, outward) = if upper { (belt[1], 1.0) } else { (belt[0], -1.0) };
        rings.push(Ring { near_only: true, ..ring("belt edge", z, outward, belt_radius_mm) });
    }
    let mut network = Network {
        belt_radius_mm,
        tracks: begun.on_belts.iter().map(|&k| model.points[k].seen.clone()).collect(),
        redundancy: 1.0,
        rings,
        outline: Vec::new(),
        focal_prior_px,
    };
    let mut now = adjust::Start {
        views: tank_from_sfm.views(model),
        points_mm: begun.on_belts.iter().map(|&k| tank_from_sfm.point(&model.points[k].position)).collect(),
    };
    see_rings(&mut network, photos, &now.views, params.outline.reach_mm, &params.outline);
    let mut adjusted = adjust::adjust(&network, &now, &params.adjust)?;
    let chosen = patches::choose(&network.tracks, &adjusted.views, &adjusted.points_mm, &params.patches);
    let features = network.tracks.clone();
    for _ in 0..params.rounds {
        now = adjust::Start { views: adjusted.views, points_mm: adjusted.points_mm };
        if params.match_patches {
            if network.tracks.len() == features.len() {
                now.points_mm = chosen.iter().map(|&k| now.points_mm[k]).collect();
            }
            let tracks = patches::relocate(photos, &now.views, &now.points_mm, &params.patches);
            let found = tracks.iter().filter(|t| t.len() >= 3).count();
            if found < 50 || 4 * found < now.points_mm.len() {
                return Err(Error::failed(format!(
                    "only {found} of {} belt points look alike in the photographs that should show them",
                    now.points_mm.len()
                ))
                .help("photographs must be sharp and evenly exposed; pose.match_patches = false does without"));
            }
            let (tracks, points) =
                tracks.into_iter().zip(&now.points_mm).filter(|(t, _)| t.len() >= 3).map(|(t, &x)| (t, x)).unzip();
            (network.tracks, now.points_mm) = (tracks, points);
            network.redundancy = patches::REDUNDANCY;
        }
        see_rings(&mut network, photos, &now.views, params.outline.fine_reach_mm, &params.outline);
        adjusted = adjust::adjust(&network, &now, &params.adjust)?;
    }
    let quality = quality(model, &network, &adjusted, seen_height_mm);
    warn(&network, &quality, photos.len(), &mut warnings);
    let mut views = adjusted.views;
    let turn = turn_about_z(first_view_to_azimuth_zero(&mut views));
    let belt_points_mm = adjusted.points_mm.iter().map(|x| turn * x).collect();
    Ok(Registration { views, belt_points_mm, quality, warnings })
}

fn ring(name: &str, z_mm: f64, outward: f64, radius_mm: f64) -> Ring {
    Ring { name: name.to_owned(), z_mm, radius_mm, outward, near_only: false }
}

fn see_rings(network: &mut Network, photos: &[ArrayView2<u8>], views: &[View], reach_mm: f64, params: &OutlineParams) {
    network.outline.clear();
    for (k, (photo, view)) in photos.iter().zip(views).enumerate() {
        for (r, ring) in network.rings.iter().enumerate() {
            network.outline.extend(outline::measure(photo.view(), view, k, ring, r, reach_mm, params));
        }
    }
}

/// Part of the tank's height within which rim and floor are looked for first.
const WIDE: f64 = 0.08;

/// Moves the start along the axis so that the middle of rim and floor, as seen, lies at half the tank's
/// height; also the distance between them, mm.
fn lay_height(
    model: &SparseModel,
    photos: &[ArrayView2<u8>],
    tank: &Tank,
    ends: &[Ring; 2],
    start: Similarity,
    params: &RegisterParams,
) -> (Similarity, Option<f64>) {
    let mut start = start;
    let mut seen_height = None;
    // Twice: the second look is taken from the right height.
    for _ in 0..2 {
        let views = start.views(model);
        let seen = |ring: &Ring| {
            let mut heights: Vec<f64> = Vec::new();
            for (k, (photo, view)) in photos.iter().zip(&views).enumerate() {
                let points = outline::measure(photo.view(), view, k, ring, 0, WIDE * tank.height_mm, &params.outline);
                heights.extend(points.iter().filter_map(|p| outline::height_mm(view, ring, p)));
            }
            (heights.len() >= photos.len()).then(|| median(&mut heights))
        };
        let (rim, floor) = (seen(&ends[0]), seen(&ends[1]));
        start.translation_mm.z -= match (rim, floor) {
            (Some(rim), Some(floor)) => {
                seen_height = Some(floor - rim);
                0.5 * (rim + floor - tank.height_mm)
            }
            (Some(rim), None) => rim,
            (None, Some(floor)) => floor - tank.height_mm,
            (None, None) => return (start, None),
        };
    }
    (start, seen_height)
}

fn check_height(tank: &Tank, seen_mm: Option<f64>, extent_mm: [f64; 2], warnings: &mut Vec<String>) {
    let extent = extent_mm[1] - extent_mm[0];
    if let Some(seen) = seen_mm.filter(|s| (s / tank.height_mm - 1.0).abs() > 0.015) {
        warnings.push(format!(
            "with a radius of {} mm the photographs show rim and floor {seen:.1} mm apart, but tank.height is {} mm: \
             one of the two is wrong, and all lengths of the result with it",
            tank.radius_mm, tank.height_mm
        ));
    } else if extent > 1.03 * tank.height_mm {
        warnings.push(format!(
            "with a radius of {} mm the belts' points reach over {extent:.1} mm, more than tank.height ({} mm): \
             one of the two is wrong, and all lengths of the result with it",
            tank.radius_mm, tank.height_mm
        ));
    }
}

fn quality(model: &SparseModel, network: &Network, adjusted: &Adjusted, seen_height_mm: Option<f64>) -> Quality {
    Quality {
        sfm_rms_px: model.reprojection_rms_px().unwrap_or(0.0),
        belt_points: network.tracks.len(),
        sightings: network.tracks.iter().map(Vec::len).sum(),
        belt_sigma_px: adjusted.belt_sigma_px,
        belt_rms_px: adjusted.belt_rms_px,
        outline_sigma_px: if network.outline.is_empty() { 0.0 } else { adjusted.outline_sigma_px },
        thicker_mm: adjusted.thicker_mm,
        edge_offsets_px: network.rings.iter().map(|r| r.name.clone()).zip(adjusted.edge_offsets_px.clone()).collect(),
        seen_height_mm,
        view_residuals_px: adjusted.view_residuals_px.clone(),
        uncertainty: adjusted.uncertainty.clone(),
    }
}

fn warn(network: &Network, quality: &Quality, photos: usize, warnings: &mut Vec<String>) {
    for (k, ring) in network.rings.iter().enumerate() {
        let seen = network.outline.iter().filter(|o| o.ring == k).count();
        if seen < photos {
            warnings.push(format!("the {} was seen at {seen} places in {photos} photographs only", ring.name));
        }
    }
    if !network.rings.iter().enumerate().any(|(k, _)| network.outline.iter().filter(|o| o.ring == k).count() >= photos)
    {
        warnings.push(
            "neither rim nor floor is seen: the cameras' height against the tank rests on the middle of the belts"
                .into(),
        );
    }
    for (name, offset) in &quality.edge_offsets_px {
        if offset.abs() > 0.5 {
            warnings.push(format!(
                "the {name} is seen {:.1} px {} of where the tank's size puts it: check tank.radius, tank.height and the belts' thickness",
                offset.abs(),
                if *offset > 0.0 { "outwards" } else { "inwards" }
            ));
        }
    }
    if quality.belt_rms_px > 1.0 {
        warnings.push(format!("belt points miss their places by {:.2} px (root mean square)", quality.belt_rms_px));
    }
    let typical = median(&mut quality.view_residuals_px.clone());
    for (k, r) in quality.view_residuals_px.iter().enumerate().filter(|(_, r)| **r > (5.0 * typical).max(0.2)) {
        warnings.push(format!("view {k} misses its belt points by {r:.2} px, the others by {typical:.2} px"));
    }
    if quality.uncertainty.wall_px > 0.5 {
        warnings.push(format!(
            "points on the tank's wall are uncertain by {:.2} px: more views or belts at both ends would help",
            quality.uncertainty.wall_px
        ));
    }
}
