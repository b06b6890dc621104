//! From structure from motion to cameras in the tank frame: start, rim and floor, rounds of adjustment.
//!
//! 1. [`start`]: axis, radius and scale from the belts' points.
//! 2. Rim and floor are looked for widely: their middle lays the height, their distance checks the
//!    tank's height against its radius.
//! 3. Adjustment with the tracks of structure from motion.
//! 4. Rounds of: belt points located anew by [`patches`], rings by [`outline`], adjustment.
//! 5. The first camera is turned to azimuth 0.
//!
//! The paper's way, [`chamfer`], takes the place of 3 and 4 where `method` says so: lens and relative poses then stay as
//! structure from motion gave them.

use super::adjust::{self, AdjustParams, Adjusted, Contour, Network, Shape};
use super::chamfer::{ChamferParams, Edge, chamfer};
use super::height::{check_height, lay_height};
use super::outline::{self, OutlineParams};
use super::patches::{self, PatchParams};
use super::quality::{Adjustment, Quality, warn};
use super::similarity::{Similarity, first_view_to_azimuth_zero};
use super::sparse::SparseModel;
use super::start::{Start, start};
use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3, View, turn_about_z};
use ndarray::{Array3, ArrayView2};
use serde::{Deserialize, Serialize};

/// By what cameras and tank are brought together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Joint least-squares adjustment of cameras, lens and belt points.
    #[default]
    Adjust,
    /// The tank's silhouettes alone, by chamfer matching.  Paper 2.2.3.
    Chamfer,
}

/// How cameras and tank are brought together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RegisterParams {
    /// `adjust` or `chamfer`.
    pub method: Method,
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
    /// Silhouettes, read with method `chamfer`.
    pub chamfer: ChamferParams,
}

impl Default for RegisterParams {
    fn default() -> Self {
        Self {
            method: Method::Adjust,
            print_thickness_mm: 0.1,
            rounds: 2,
            match_patches: true,
            adjust: AdjustParams::default(),
            patches: PatchParams::default(),
            outline: OutlineParams::default(),
            chamfer: ChamferParams::default(),
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
    /// Edges of the tank as seen.
    pub edges: Vec<Edge>,
    /// The numbers beside them.
    pub quality: Quality,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// What is known of the lens beforehand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LensPrior {
    /// Nothing but what the sparse model found.
    None,
    /// The focal length that the camera wrote into its photographs, px.
    Focal(f64),
    /// That of the sparse model is known, and stays.
    Known,
}

/// Registers the views of `model` in the tank frame. `photos` are gray (0..255), one per view of the model; `shrunken`
/// are read with method `chamfer` alone ([`super::chamfer::shrunken`]).
///
/// # Errors
/// Where the views give no axis, the points no cylinder, or too little is seen to hold the cameras.
pub fn register(
    model: &SparseModel,
    photos: &[ArrayView2<u8>],
    shrunken: &[Array3<u8>],
    tank: &Tank,
    prior: LensPrior,
    params: &RegisterParams,
) -> Result<Registration> {
    params.check()?;
    if params.method == Method::Adjust {
        model.one_lens()?;
    }
    if photos.len() != model.views.len() {
        let (p, v) = (photos.len(), model.views.len());
        return Err(Error::failed(format!("{p} photographs do not go with the {v} views of the sparse model")));
    }
    let mut warnings = Vec::new();
    let belt_radius_mm = tank.radius_mm + params.print_thickness_mm;
    let mut begun = start(model, tank, belt_radius_mm)?;
    let ends = [ring("rim", 0.0, -1.0, belt_radius_mm), ring("floor", tank.height_mm, 1.0, belt_radius_mm)];
    let seen_height_mm;
    (begun.tank_from_sfm, seen_height_mm) =
        lay_height(model, photos, tank, &ends, begun.tank_from_sfm, &params.outline);
    check_height(tank, seen_height_mm, begun.extent_mm, &mut warnings)?;
    let quality = Quality {
        sfm_rms_px: model.reprojection_rms_px().unwrap_or(0.0),
        seen_height_mm,
        adjustment: None,
        contour_median_px: None,
    };
    let registration =
        Registration { views: Vec::new(), belt_points_mm: Vec::new(), edges: Vec::new(), quality, warnings };
    let mut registration = match params.method {
        Method::Chamfer => silhouettes(registration, model, shrunken, tank, &begun, params)?,
        Method::Adjust => {
            let mut contours = ends.to_vec();
            for belt in &tank.belts_mm {
                // The edges that face the water; the others coincide with rim and floor or lie in air.
                let upper = belt[0] + belt[1] < tank.height_mm;
                let (z, outward) = if upper { (belt[1], 1.0) } else { (belt[0], -1.0) };
                contours.push(ring("belt edge", z, outward, belt_radius_mm));
            }
            for belt in &tank.belts_mm {
                for (name, turn) in [("left side of a belt", -1.0), ("right side of a belt", 1.0)] {
                    let shape = Shape::Side { z_mm: *belt, turn };
                    contours.push(Contour { name: name.to_owned(), radius_mm: belt_radius_mm, shape });
                }
            }
            let network = Network {
                belt_radius_mm,
                tracks: begun.on_belts.iter().map(|&k| model.points[k].seen.clone()).collect(),
                redundancy: 1.0,
                contours,
                outline: Vec::new(),
                focal_prior_px: match prior {
                    LensPrior::Focal(f) if params.adjust.focal_sigma > 0.0 => Some((f, params.adjust.focal_sigma * f)),
                    _ => None,
                },
                holds_lens: prior == LensPrior::Known,
            };
            together(registration, network, model, photos, &begun, params)?
        }
    };
    let turn = turn_about_z(first_view_to_azimuth_zero(&mut registration.views));
    registration.belt_points_mm.iter_mut().for_each(|x| *x = turn * *x);
    Ok(registration)
}

impl RegisterParams {
    fn check(&self) -> Result<()> {
        if !(1..=10).contains(&self.rounds) {
            return Err(Error::usage(format!("pose.rounds is {}", self.rounds)).help("give 1 to 10"));
        }
        if !(0.0..=5.0).contains(&self.print_thickness_mm) {
            return Err(
                Error::usage(format!("pose.print_thickness_mm is {}", self.print_thickness_mm)).help("give 0 to 5 mm")
            );
        }
        Ok(())
    }
}

/// The paper's way: silhouettes.
fn silhouettes(
    mut registration: Registration,
    model: &SparseModel,
    shrunken: &[Array3<u8>],
    tank: &Tank,
    begun: &Start,
    params: &RegisterParams,
) -> Result<Registration> {
    let radius_mm = tank.radius_mm + params.print_thickness_mm;
    let found = chamfer(model, shrunken, tank, radius_mm, &begun.tank_from_sfm, &params.chamfer)?;
    if !found.converged {
        registration.warnings.push("the silhouettes' loss did not stand still within pose.chamfer.rounds".into());
    }
    if found.median_px > 4.0 {
        registration.warnings.push(format!(
            "half of the tank regions' contours lie over {:.1} px off the tank: look at the outlines in the results",
            found.median_px
        ));
    }
    registration.quality.contour_median_px = Some(found.median_px);
    registration.views = found.tank_from_sfm.views(model);
    let on_belts = begun.on_belts.iter();
    registration.belt_points_mm = on_belts.map(|&k| found.tank_from_sfm.point(&model.points[k].position)).collect();
    registration.edges = found.edges;
    Ok(registration)
}

/// Rounds of adjustment.
fn together(
    mut registration: Registration,
    mut network: Network,
    model: &SparseModel,
    photos: &[ArrayView2<u8>],
    begun: &Start,
    params: &RegisterParams,
) -> Result<Registration> {
    let tank_from_sfm: &Similarity = &begun.tank_from_sfm;
    let mut now = adjust::Start {
        views: tank_from_sfm.views(model),
        points_mm: begun.on_belts.iter().map(|&k| tank_from_sfm.point(&model.points[k].position)).collect(),
    };
    see_outline(&mut network, photos, &now.views, params.outline.reach_mm, &params.outline);
    let mut adjusted = adjust::adjust(&network, &now, &params.adjust)?;
    let chosen = patches::choose(&network.tracks, &adjusted.views, &adjusted.points_mm, &params.patches);
    for round in 0..params.rounds {
        now = adjust::Start { views: adjusted.views, points_mm: adjusted.points_mm };
        if params.match_patches {
            if round == 0 {
                now.points_mm = chosen.iter().map(|&k| now.points_mm[k]).collect();
            }
            locate(&mut network, &mut now, photos, &params.patches)?;
        }
        see_outline(&mut network, photos, &now.views, params.outline.fine_reach_mm, &params.outline);
        adjusted = adjust::adjust(&network, &now, &params.adjust)?;
    }
    let adjustment = Adjustment::of(&network, &adjusted);
    let names: Vec<&str> = model.views.iter().map(|view| view.file.as_str()).collect();
    warn(&network, &adjustment, &names, &mut registration.warnings);
    let Adjusted { views, points_mm, misses_px, .. } = adjusted;
    let edge = |(o, miss): (&adjust::OutlinePoint, &[f64; 2])| Edge { view: o.view, u: o.u, v: o.v, miss_px: *miss };
    registration.edges = network.outline.iter().zip(&misses_px).map(edge).collect();
    registration.quality.adjustment = Some(adjustment);
    registration.views = views;
    registration.belt_points_mm = points_mm;
    Ok(registration)
}

/// Locates the belt points anew by their patches; those that are not found again go.
fn locate(
    network: &mut Network,
    now: &mut adjust::Start,
    photos: &[ArrayView2<u8>],
    params: &PatchParams,
) -> Result<()> {
    let tracks = patches::relocate(photos, &now.views, &now.points_mm, params);
    let found = tracks.iter().filter(|t| t.len() >= 3).count();
    if found < 50 || 4 * found < now.points_mm.len() {
        return Err(Error::failed(format!(
            "only {found} of {} belt points look alike in the photographs that should show them",
            now.points_mm.len()
        ))
        .help("photographs must be sharp and evenly exposed; pose.match_patches = false does without"));
    }
    (network.tracks, now.points_mm) =
        tracks.into_iter().zip(&now.points_mm).filter(|(t, _)| t.len() >= 3).map(|(t, &x)| (t, x)).unzip();
    network.redundancy = patches::REDUNDANCY;
    Ok(())
}

fn ring(name: &str, z_mm: f64, outward: f64, radius_mm: f64) -> Contour {
    Contour { name: name.to_owned(), radius_mm, shape: Shape::Ring { z_mm, outward } }
}

fn see_outline(
    network: &mut Network,
    photos: &[ArrayView2<u8>],
    views: &[View],
    reach_mm: f64,
    params: &OutlineParams,
) {
    network.outline.clear();
    for (k, (photo, view)) in photos.iter().zip(views).enumerate() {
        for (c, contour) in network.contours.iter().enumerate() {
            network.outline.extend(outline::measure(photo.view(), view, k, contour, c, reach_mm, params));
        }
    }
}
