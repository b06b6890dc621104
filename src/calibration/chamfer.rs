//! The paper's registration: the tank's silhouette laid over the tank's region in the photographs.  Paper 2.2.3.
//!
//! 1. Photographs, undistorted by the lens of structure from motion, at 1/`shrink` of their size.
//! 2. The tank's region by [`graph_cut`]: what lies well within the silhouette of the start is known to be tank, what
//!    lies well without is known not to be.
//! 3. Its contour: the borders between pixels inside and outside, taken at their middles.
//! 4. The silhouette of a candidate: the convex hull of the projected rim and floor, whose sides are the cylinder's.
//!    The distance of a contour point from it is what the distance map of the silhouette holds there, exactly.
//! 5. `Σ ρ(distance / scale)` is minimised over scale, rotation (angle-axis) and translation by Powell's method, on a
//!    growing number of views.

use super::similarity::Similarity;
use super::sparse::SparseModel;
use crate::error::{Error, Result};
use crate::math::powell::{self, Stop};
use crate::math::robust::{Loss, median};
use crate::optics::{Lens, Tank, Vec3, View};
use crate::photo::graph_cut::{self, CutParams, Known};
use crate::photo::{Picture, undistort};
use nalgebra::{Rotation3, Vector2};
use ndarray::{Array2, Array3};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A place where a photograph shows the tank's edge.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Edge {
    /// Index of the view.
    pub view: usize,
    /// Column in the photograph, px.
    pub u: f64,
    /// Row in the photograph, px.
    pub v: f64,
    /// From the seen edge to where the registration puts it, px.
    pub miss_px: [f64; 2],
}

/// One step of the growing schedule.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Step {
    /// Every how many views one is taken, from the first on; at least 1.
    pub every: usize,
    /// M-estimator.
    pub loss: Loss,
}

/// How silhouettes are registered; the defaults are the paper's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ChamferParams {
    /// Photographs are taken at one over this of their size, 1..16.
    pub shrink: usize,
    /// Half the width of the band about the start's silhouette in which the graph cut decides, part of the silhouette's
    /// size, 0.01..0.3: how far off the start may be.
    pub band: f64,
    /// The graph cut.
    pub cut: CutParams,
    /// Where the M-estimator bends, px of the shrunken photographs.
    pub scale_px: f64,
    /// Views and M-estimators in turn.
    pub schedule: Vec<Step>,
    /// A step ends when the loss changes by less than this part of itself: 1e-4 is its top four digits.
    pub tolerance: f64,
    /// Rounds of Powell's method per step at most.
    pub rounds: usize,
}

impl Default for ChamferParams {
    fn default() -> Self {
        let step = |every, loss| Step { every, loss };
        Self {
            shrink: 4,
            band: 0.04,
            cut: CutParams::default(),
            scale_px: 1.0,
            schedule: vec![step(12, Loss::SoftL1), step(6, Loss::Cauchy), step(3, Loss::Cauchy), step(1, Loss::Cauchy)],
            tolerance: 1e-4,
            rounds: 100,
        }
    }
}

/// What the registration found.
#[derive(Debug, Clone)]
pub struct Chamfered {
    /// M₀.
    pub tank_from_sfm: Similarity,
    /// The contours in the photographs.
    pub edges: Vec<Edge>,
    /// Median distance of contour points from the silhouette, px of the photographs.
    pub median_px: f64,
    /// Whether every step's loss stood still before its rounds ran out.
    pub converged: bool,
}

/// The photograph without distortion at 1/`shrink` of its size: means of squares, cut off at the right and lower edge.
pub fn shrunken(photo: &Picture, lens: &Lens, shrink: usize) -> Array3<u8> {
    let ideal = undistort(photo, lens);
    let (h, w, _) = ideal.dim();
    let area = (shrink * shrink) as u32;
    Array3::from_shape_fn((h / shrink, w / shrink, 3), |(y, x, c)| {
        let mut sum = 0_u32;
        for j in 0..shrink {
            for i in 0..shrink {
                sum += u32::from(ideal[(y * shrink + j, x * shrink + i, c)]);
            }
        }
        ((sum + area / 2) / area) as u8
    })
}

/// Registers the tank, of outer radius `radius_mm`, from `start`; `photos` are [`shrunken`], one per view.
///
/// # Errors
/// Where a photograph is too small for its silhouette, or parameters are out of range.
pub fn chamfer(
    model: &SparseModel,
    photos: &[Array3<u8>],
    tank: &Tank,
    radius_mm: f64,
    start: &Similarity,
    params: &ChamferParams,
) -> Result<Chamfered> {
    params.check()?;
    let rims = Rims::new(radius_mm, tank.height_mm);
    let contours = photos
        .par_iter()
        .zip(start.views(model))
        .zip(&model.views)
        .map(|((photo, view), sparse)| {
            contour(photo, &rims, &view, params).map_err(|e| e.at(format!("photograph `{}`", sparse.file)))
        })
        .collect::<Result<Vec<_>>>()?;
    // Where the tank stands before the cameras: turns are taken about there, so that they do not shift it.
    let middle = Vec3::new(0.0, 0.0, 0.5 * tank.height_mm);
    let candidate = |x: &[f64]| -> Similarity {
        let turn = Rotation3::new(Vec3::new(x[1], x[2], x[3])).into_inner();
        let scale = x[0].exp();
        Similarity {
            scale: start.scale * scale,
            rotation: turn * start.rotation,
            translation_mm: turn * (start.translation_mm - middle) * scale + middle + Vec3::new(x[4], x[5], x[6]),
        }
    };
    let distances = |at: &Similarity, every: usize| -> Vec<Vec<f64>> {
        let views = at.views(model);
        let each = |k: usize| rims.distances(&views[k], &contours[k], params.shrink);
        (0..views.len()).step_by(every).collect::<Vec<_>>().into_par_iter().map(each).collect()
    };
    let mut x = vec![0.0; 7];
    let mut converged = true;
    for step in &params.schedule {
        let rho = |d: &f64| step.loss.rho(d / params.scale_px);
        let loss = |x: &[f64]| distances(&candidate(x), step.every).iter().flatten().map(rho).sum();
        let stop = Stop { tolerance: params.tolerance, rounds: params.rounds };
        let found = powell::minimise(loss, &x, &[0.01, 0.01, 0.01, 0.01, 2.0, 2.0, 2.0], stop);
        x = found.x;
        converged &= found.converged;
    }
    let tank_from_sfm = candidate(&x);
    let mut apart: Vec<f64> = distances(&tank_from_sfm, 1).concat();
    let views = tank_from_sfm.views(model);
    let edges = (0..views.len()).flat_map(|k| rims.edges(&views[k], k, &contours[k], params.shrink)).collect();
    Ok(Chamfered { tank_from_sfm, edges, median_px: median(&mut apart) * params.shrink as f64, converged })
}

impl ChamferParams {
    fn check(&self) -> Result<()> {
        let fault = |key: &str, remedy: &str| {
            Err(Error::usage(format!("pose.chamfer.{key} is out of range")).help(remedy.to_owned()))
        };
        if !(1..=16).contains(&self.shrink) {
            return fault("shrink", "give 1 to 16; the paper takes 4");
        }
        if !(0.01..=0.3).contains(&self.band) {
            return fault("band", "give 0.01 to 0.3 of the tank's size");
        }
        if !(self.scale_px > 0.0 && self.scale_px.is_finite() && self.tolerance > 0.0) {
            return fault("scale_px or pose.chamfer.tolerance", "give a number over 0");
        }
        if self.schedule.is_empty() || self.schedule.iter().any(|s| s.every == 0) {
            return fault("schedule", "give at least one step, with `every` of at least 1");
        }
        Ok(())
    }
}

/// Points of the tank's rim and floor.
struct Rims(Vec<Vec3>);

/// Points per circle: chords leave the circle by 0.05 % of its radius.
const AROUND: usize = 96;

impl Rims {
    fn new(radius_mm: f64, height_mm: f64) -> Self {
        let of = |z: f64| {
            (0..AROUND).map(move |k| {
                let a = std::f64::consts::TAU * k as f64 / AROUND as f64;
                Vec3::new(radius_mm * a.cos(), radius_mm * a.sin(), z)
            })
        };
        Self(of(0.0).chain(of(height_mm)).collect())
    }

    /// The silhouette's corners in the shrunken photograph, in order; empty where the tank reaches behind the camera.
    fn silhouette(&self, view: &View, shrink: usize) -> Vec<Vector2<f64>> {
        let (lens, shrink) = (view.lens.ideal(), shrink as f64);
        let mut corners = Vec::with_capacity(self.0.len());
        for x in &self.0 {
            let c = view.rotation * x + view.translation_mm;
            if c.z <= 1e-6 {
                return Vec::new();
            }
            // The centre of the first pixel of a square of `shrink` lies half a square off.
            let place = |p: f64, centre: f64| (lens.focal_px * p + centre + 0.5) / shrink - 0.5;
            corners.push(Vector2::new(place(c.x / c.z, lens.cx), place(c.y / c.z, lens.cy)));
        }
        hull(corners)
    }

    /// Distance of every contour point from the silhouette, px; far where there is none.
    fn distances(&self, view: &View, contour: &[(f64, f64)], shrink: usize) -> Vec<f64> {
        self.misses(view, contour, shrink).iter().map(Vector2::norm).collect()
    }

    /// The way from every contour point to the silhouette, px; long where there is none.
    fn misses(&self, view: &View, contour: &[(f64, f64)], shrink: usize) -> Vec<Vector2<f64>> {
        let corners = self.silhouette(view, shrink);
        if corners.len() < 3 {
            return vec![Vector2::new(1e3, 0.0); contour.len()];
        }
        let n = corners.len();
        let edges: Vec<_> = (0..n)
            .map(|k| {
                let along = corners[(k + 1) % n] - corners[k];
                (corners[k], along, 1.0 / along.norm_squared().max(1e-12))
            })
            .collect();
        let miss = |&(u, v): &(f64, f64)| {
            let p = Vector2::new(u, v);
            let way = |(a, along, inverse): &(Vector2<f64>, Vector2<f64>, f64)| {
                let d = p - a;
                along * (d.dot(along) * inverse).clamp(0.0, 1.0) - d
            };
            let ways = edges.iter().map(way);
            ways.min_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared())).unwrap_or_default()
        };
        contour.iter().map(miss).collect()
    }

    /// The contour in the photograph as taken, with its misses.
    fn edges(&self, view: &View, index: usize, contour: &[(f64, f64)], shrink: usize) -> Vec<Edge> {
        let ideal = view.lens.ideal();
        let taken = |x: f64, y: f64| {
            let full = |p: f64, centre: f64| ((p + 0.5) * shrink as f64 - 0.5 - centre) / ideal.focal_px;
            view.lens.pixel(full(x, ideal.cx), full(y, ideal.cy))
        };
        let edge = |(&(x, y), miss): (&(f64, f64), Vector2<f64>)| {
            let (from, to) = (taken(x, y), taken(x + miss.x, y + miss.y));
            Edge { view: index, u: from.0, v: from.1, miss_px: [to.0 - from.0, to.1 - from.1] }
        };
        contour.iter().zip(self.misses(view, contour, shrink)).map(edge).collect()
    }
}

/// Convex hull, turning one way from its leftmost corner (Andrew's chains).
fn hull(mut points: Vec<Vector2<f64>>) -> Vec<Vector2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let chain = |points: &mut dyn Iterator<Item = &Vector2<f64>>| {
        let mut chain: Vec<Vector2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp(&(p - a)) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(*p);
        }
        chain.pop();
        chain
    };
    let mut corners = chain(&mut points.iter());
    corners.extend(chain(&mut points.iter().rev()));
    corners
}

/// Whether a point lies within a convex polygon of [`hull`]'s turning.
fn within(corners: &[Vector2<f64>], p: &Vector2<f64>) -> bool {
    (0..corners.len()).all(|k| {
        let (a, b) = (corners[k], corners[(k + 1) % corners.len()]);
        (b - a).perp(&(p - a)) >= 0.0
    })
}

/// Contour points of the tank's region in a shrunken photograph.
fn contour(photo: &Array3<u8>, rims: &Rims, view: &View, params: &ChamferParams) -> Result<Vec<(f64, f64)>> {
    let (h, w, _) = photo.dim();
    let corners = rims.silhouette(view, params.shrink);
    let centre = corners.iter().sum::<Vector2<f64>>() / corners.len().max(1) as f64;
    let size = corners.iter().map(|c| (c - centre).norm()).fold(0.0, f64::max);
    let band = (params.band * size).max(2.0);
    // The band is made by moving every corner out and in.
    let moved = |by: f64| -> Vec<Vector2<f64>> {
        let away = |c: &Vector2<f64>| c + Vector2::new((c.x - centre.x).signum(), (c.y - centre.y).signum()) * by;
        hull(corners.iter().map(away).collect())
    };
    let (outer, inner) = (moved(band), moved(-band));
    let known = Array2::from_shape_fn((h, w), |(y, x)| {
        let p = Vector2::new(x as f64, y as f64);
        if within(&inner, &p) {
            Known::Inside
        } else if within(&outer, &p) {
            Known::Nothing
        } else {
            Known::Outside
        }
    });
    let inside = graph_cut::cut(photo.view(), known.view(), &params.cut)
        .map_err(|e| e.help("the tank must stand free in the photographs, with room around it"))?;
    let mut points = Vec::new();
    for y in 0..h {
        for x in 0..w {
            if x + 1 < w && inside[(y, x)] != inside[(y, x + 1)] {
                points.push((x as f64 + 0.5, y as f64));
            }
            if y + 1 < h && inside[(y, x)] != inside[(y + 1, x)] {
                points.push((x as f64, y as f64 + 0.5));
            }
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests;
