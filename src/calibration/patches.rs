//! Belt points located anew by matching patches of the belt itself.
//!
//! A feature detector looks at a round window of the picture; on a curved, obliquely seen surface the
//! window's centre is not the picture of the surface point (inwards by about a² sin θ / 2ρ cos² θ for a
//! window of radius a, 0.01 to 0.1 px). Next to a nearly degenerate geometry that is too much. Here the
//! surface is modelled instead: around each belt point a patch of the cylinder is sampled through every
//! camera that sees it (cubic interpolation), each patch is compared with the mean of the others, and the
//! shift (along the belt, along the axis) that aligns it (Gauss-Newton on the rectified patches,
//! normalised to mean 0 and deviation 1) says where the photograph really shows the point.
//!
//! Given: views and points in the tank frame, good to a pixel or so. Returned: per point its sightings in
//! all views in which it is seen well; an empty track where the print is too plain there or the views
//! disagree.

use super::sparse::Sighting;
use crate::optics::{Vec3, View};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How patches are matched.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PatchParams {
    /// Half the side of a patch, in pixels of the nearest view, 3..20: wide enough to hold print.
    pub half_px: usize,
    /// Largest angle between the line of sight and the wall's normal, degrees, 20..75; beyond it the
    /// print is foreshortened to less than half.
    pub max_incidence_deg: f64,
    /// Smallest standard deviation of gray values (of 255) within a patch: some times the noise.
    pub min_deviation: f64,
    /// Smallest correlation of a patch with the mean of the others, 0..1.
    pub min_correlation: f64,
    /// Largest shift, px: the geometry is known to a pixel or so.
    pub max_shift_px: f64,
    /// How many points are matched at most.
    pub max_points: usize,
}

impl Default for PatchParams {
    fn default() -> Self {
        Self {
            half_px: 6,
            max_incidence_deg: 60.0,
            min_deviation: 5.0,
            min_correlation: 0.8,
            max_shift_px: 3.0,
            max_points: 3000,
        }
    }
}

/// How many patches share a pixel where points are chosen as densely as [`choose`] allows.
pub const REDUNDANCY: f64 = 4.0;

/// Indices of the points to match, ascending: the longest tracks first (ties in their order), each at
/// least half a patch away from those before: each part of the print is then matched [`REDUNDANCY`] times.
pub fn choose(tracks: &[Vec<Sighting>], views: &[View], points_mm: &[Vec3], params: &PatchParams) -> Vec<usize> {
    let nearest = |x: &Vec3| {
        let distance = |v: &View| (v.centre_in_tank() - x).norm() / v.lens.focal_px;
        views.iter().map(distance).fold(f64::INFINITY, f64::min)
    };
    let mut order: Vec<usize> = (0..tracks.len()).collect();
    order.sort_by_key(|&k| std::cmp::Reverse(tracks[k].len()));
    let mut chosen: Vec<usize> = Vec::new();
    for k in order {
        let x = &points_mm[k];
        let apart = 0.5 * (2 * params.half_px + 1) as f64 * nearest(x);
        // On the belt a patch is a square: the larger of arc and height counts.
        let free = |&c: &usize| {
            let y = &points_mm[c];
            (x.z - y.z).abs() >= apart || (x.xy() - y.xy()).norm() >= apart
        };
        if chosen.iter().all(free) {
            chosen.push(k);
        }
        if chosen.len() == params.max_points {
            break;
        }
    }
    chosen.sort_unstable();
    chosen
}

/// Sightings of each point in all views that see it well; `photos` are gray, 0..255, one per view.
pub fn relocate(
    photos: &[ArrayView2<u8>],
    views: &[View],
    points_mm: &[Vec3],
    params: &PatchParams,
) -> Vec<Vec<Sighting>> {
    points_mm.par_iter().map(|x| track(photos, views, x, params)).collect()
}

/// A patch of the cylinder as one view shows it.
struct Seen {
    view: usize,
    weight: f64,
    shift: (f64, f64),
    values: Array2<f64>,
}

fn track(photos: &[ArrayView2<u8>], views: &[View], point_mm: &Vec3, params: &PatchParams) -> Vec<Sighting> {
    let radius = point_mm.x.hypot(point_mm.y);
    let azimuth = point_mm.y.atan2(point_mm.x);
    let mut mm_per_px = f64::INFINITY;
    let mut visible = Vec::new();
    for (k, view) in views.iter().enumerate() {
        let to_camera = view.centre_in_tank() - point_mm;
        let cos = (to_camera.x * point_mm.x + to_camera.y * point_mm.y) / (radius * to_camera.norm());
        if cos > params.max_incidence_deg.to_radians().cos() {
            mm_per_px = mm_per_px.min(to_camera.norm() / view.lens.focal_px);
            visible.push((k, cos));
        }
    }
    let sample = |view: usize, shift: (f64, f64)| {
        patch(photos[view], &views[view], (radius, azimuth, point_mm.z), shift, mm_per_px, params)
    };
    let mut seen: Vec<Seen> = visible
        .into_iter()
        .filter_map(|(view, cos)| {
            let values = sample(view, (0.0, 0.0))?;
            Some(Seen { view, weight: cos.powi(3), shift: (0.0, 0.0), values })
        })
        .collect();
    for _ in 0..3 {
        if seen.len() < 3 {
            return Vec::new();
        }
        let mut total = Array2::<f64>::zeros(seen[0].values.dim());
        let mut weights = 0.0;
        for s in &seen {
            total.scaled_add(s.weight, &s.values);
            weights += s.weight;
        }
        seen = seen
            .into_iter()
            .filter_map(|s| {
                let others = (&total - &(&s.values * s.weight)) / (weights - s.weight);
                let (along, down) = alignment(&s.values, &normalised(others, 0.0)?, params)?;
                let shift = (s.shift.0 + along * mm_per_px, s.shift.1 + down * mm_per_px);
                if shift.0.hypot(shift.1) > params.max_shift_px * mm_per_px {
                    return None;
                }
                Some(Seen { shift, values: sample(s.view, shift)?, ..s })
            })
            .collect();
    }
    let place = |s: &Seen| {
        let a = azimuth + s.shift.0 / radius;
        let x = Vec3::new(radius * a.cos(), radius * a.sin(), point_mm.z + s.shift.1);
        let c = views[s.view].rotation * x + views[s.view].translation_mm;
        let (u, v) = views[s.view].lens.pixel(c.x / c.z, c.y / c.z);
        Sighting { view: s.view, u, v }
    };
    if seen.len() < 3 { Vec::new() } else { seen.iter().map(place).collect() }
}

/// Samples the patch around (radius, azimuth, z), shifted (along the belt, down) in mm; rows run down.
/// `None` where it leaves the picture or shows too little.
fn patch(
    photo: ArrayView2<u8>,
    view: &View,
    at: (f64, f64, f64),
    shift: (f64, f64),
    step_mm: f64,
    params: &PatchParams,
) -> Option<Array2<f64>> {
    let n = 2 * params.half_px + 1;
    let mut values = Array2::zeros((n, n));
    for ((j, i), value) in values.indexed_iter_mut() {
        let along = shift.0 + (i as f64 - params.half_px as f64) * step_mm;
        let down = shift.1 + (j as f64 - params.half_px as f64) * step_mm;
        let azimuth = at.1 + along / at.0;
        let x = Vec3::new(at.0 * azimuth.cos(), at.0 * azimuth.sin(), at.2 + down);
        let c = view.rotation * x + view.translation_mm;
        if c.z <= 1e-6 {
            return None;
        }
        let (u, v) = view.lens.pixel(c.x / c.z, c.y / c.z);
        *value = cubic(photo, u, v)?;
    }
    normalised(values, params.min_deviation)
}

/// Mean 0, deviation 1; `None` where the deviation is not above `least`.
fn normalised(mut values: Array2<f64>, least: f64) -> Option<Array2<f64>> {
    let n = values.len() as f64;
    let mean = values.sum() / n;
    values -= mean;
    let deviation = (values.iter().map(|x| x * x).sum::<f64>() / n).sqrt();
    (deviation > least).then(|| values / deviation)
}

/// Shift in samples (along the belt, down) of `patch` against `reference`; `None` where they correlate
/// too little or the print does not fix both directions.
fn alignment(patch: &Array2<f64>, reference: &Array2<f64>, params: &PatchParams) -> Option<(f64, f64)> {
    let (h, w) = patch.dim();
    let correlation = patch.iter().zip(reference).map(|(a, b)| a * b).sum::<f64>() / (h * w) as f64;
    if correlation < params.min_correlation {
        return None;
    }
    let (mut aa, mut ab, mut bb, mut ra, mut rb) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for j in 1..h - 1 {
        for i in 1..w - 1 {
            let a = 0.5 * (reference[(j, i + 1)] - reference[(j, i - 1)]);
            let b = 0.5 * (reference[(j + 1, i)] - reference[(j - 1, i)]);
            let e = patch[(j, i)] - reference[(j, i)];
            aa += a * a;
            ab += a * b;
            bb += b * b;
            ra -= a * e;
            rb -= b * e;
        }
    }
    let det = aa * bb - ab * ab;
    // Both principal directions must carry gradient: at least a tenth of the stronger one's.
    if det < 0.09 * (0.5 * (aa + bb)).powi(2) {
        return None;
    }
    let (x, y) = ((bb * ra - ab * rb) / det, (aa * rb - ab * ra) / det);
    (x.hypot(y) < 2.0).then_some((x, y))
}

/// Catmull-Rom interpolation; `None` within two pixels of the border.
fn cubic(photo: ArrayView2<u8>, u: f64, v: f64) -> Option<f64> {
    let (h, w) = photo.dim();
    if !(u >= 1.0 && v >= 1.0 && u < w as f64 - 2.0 && v < h as f64 - 2.0) {
        return None;
    }
    let (x, y) = (u as usize, v as usize);
    let (a, b) = (weights(u - x as f64), weights(v - y as f64));
    let row = |j: usize| {
        a[0] * f64::from(photo[(j, x - 1)])
            + a[1] * f64::from(photo[(j, x)])
            + a[2] * f64::from(photo[(j, x + 1)])
            + a[3] * f64::from(photo[(j, x + 2)])
    };
    Some(b[0] * row(y - 1) + b[1] * row(y) + b[2] * row(y + 1) + b[3] * row(y + 2))
}

fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t + 2.0 * t2 - t3), 0.5 * (2.0 - 5.0 * t2 + 3.0 * t3), 0.5 * (t + 4.0 * t2 - 3.0 * t3), 0.5 * (t3 - t2)]
}
