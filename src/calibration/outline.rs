//! Where the photographs show the edges of the tank's rings (rim, floor, belt edges), to a fraction of a
//! pixel.
//!
//! Along each ring, profiles are taken across the predicted edge every `spacing_px` and gathered in `bins` stretches.
//! Inside lies print, dark here and light there, so that no single profile tells the edge; a stretch does: the variance
//! over its profiles, `V(s) = var_c I_c(s)`, rises from V₀ (noise, room or table, outside) to V₁ (print, inside) as
//! `V₀ + α² (V₁ - V₀)` where a part α of the light (linear, not sRGB code) comes from inside, and the edge is where
//! α = 1/2. A mere step of brightness, such as the table's edge, is none. The place is found twice: with levels from the
//! profile's ends, then with levels from 1.5 to 4 px on either side of the first place. Stretches whose step is lost in
//! the noise, or that leave the picture, are skipped.
//!
//! Always the near half of a ring is looked at, where the print on the outer wall ends. To a camera that looks over the
//! rim (or up at the floor) the far half outlines the tank, but there the print is seen from behind, through walls that
//! bend the light, or not at all.

use super::adjust::{OutlinePoint, Ring};
use crate::math::robust::median;
use crate::optics::{Vec3, View};
use crate::photo::colour::linear_of_srgb;
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// How edges are looked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutlineParams {
    /// Distance between samples along the ring, px, 1..20; neighbours nearer than the blur are no news.
    pub spacing_px: f64,
    /// Half the length of a profile in the first round, mm on the wall: how far off the prediction may be.
    pub reach_mm: f64,
    /// The same in later rounds, mm.
    pub fine_reach_mm: f64,
    /// Stretches per ring and view, 1..50.
    pub bins: usize,
    /// A step counts where √V rises by at least this (linear light, 0..1); 0.02 is white print at a tenth of full exposure.
    pub min_contrast: f64,
    /// And where √V inside is at least this many times what it is outside, 1..10: a stem or the table's mottle outside
    /// pulls the place.
    pub min_rise: f64,
    /// Part of the half ring, to either side of its middle, that is used, 0..1: towards the ends it
    /// turns away along the line of sight.
    pub arc: f64,
}

impl Default for OutlineParams {
    fn default() -> Self {
        Self {
            spacing_px: 2.0,
            reach_mm: 5.0,
            fine_reach_mm: 2.5,
            bins: 5,
            min_contrast: 0.02,
            min_rise: 3.0,
            arc: 0.85,
        }
    }
}

/// Step of the samples along a profile, px.
const STEP: f64 = 0.25;

/// Edge points of one ring in one photograph (gray, 0..255); `reach_mm` as in [`OutlineParams`].
pub fn measure(
    photo: ArrayView2<u8>,
    view: &View,
    view_index: usize,
    ring: &Ring,
    ring_index: usize,
    reach_mm: f64,
    params: &OutlineParams,
) -> Vec<OutlinePoint> {
    let centre = view.centre_in_tank();
    let distance = centre.x.hypot(centre.y);
    if distance <= ring.radius_mm {
        return Vec::new();
    }
    let toward = centre.y.atan2(centre.x);
    let half = (ring.radius_mm / distance).acos();
    let (low, high) = (toward - params.arc * half, toward + params.arc * half);

    let mut columns: Vec<Column> = Vec::new();
    let mut azimuth = low;
    let middle_mm = Vec3::new(ring.radius_mm * toward.cos(), ring.radius_mm * toward.sin(), ring.z_mm);
    let (Some(a), Some(b)) = (pixel(view, &middle_mm), pixel(view, &(middle_mm + Vec3::z()))) else {
        return Vec::new();
    };
    let reach_px = (reach_mm * (a.0 - b.0).hypot(a.1 - b.1)).max(6.0);
    // Less far outwards where the picture ends.
    let out = ((b.0 - a.0) * ring.outward, (b.1 - a.1) * ring.outward);
    let length = out.0.hypot(out.1).max(1e-6);
    let room = (0..reach_px as usize)
        .take_while(|&s| {
            let s = s as f64 + 2.0;
            bilinear(photo, a.0 + s * out.0 / length, a.1 + s * out.1 / length).is_some()
        })
        .count() as f64;
    let outer_px = reach_px.min(room);
    while azimuth < high {
        let on_ring = |a: f64| Vec3::new(ring.radius_mm * a.cos(), ring.radius_mm * a.sin(), ring.z_mm);
        let x = on_ring(azimuth);
        let (Some(p), Some(q), Some(o)) = (
            pixel(view, &x),
            pixel(view, &on_ring(azimuth + 1e-4)),
            pixel(view, &(x + Vec3::new(0.0, 0.0, ring.outward))),
        ) else {
            break;
        };
        let along = ((q.0 - p.0) / 1e-4, (q.1 - p.1) / 1e-4);
        let speed = along.0.hypot(along.1).max(1e-6);
        azimuth += (params.spacing_px / speed).min(0.1);
        let mut normal = (-along.1 / speed, along.0 / speed);
        let out = (o.0 - p.0, o.1 - p.1);
        if normal.0 * out.0 + normal.1 * out.1 < 0.0 {
            normal = (-normal.0, -normal.1);
        }
        if let Some(values) = profile(photo, p, normal, outer_px, reach_px) {
            columns.push(Column { azimuth: x.y.atan2(x.x), pixel: p, normal, values });
        }
    }
    let per_bin = columns.len().div_ceil(params.bins).max(1);
    let mut points = Vec::new();
    for stretch in columns.chunks(per_bin).filter(|s| 2 * s.len() > per_bin && s.len() >= 8) {
        if let Some(s) = edge(stretch, outer_px, params) {
            let c = &stretch[stretch.len() / 2];
            points.push(OutlinePoint {
                view: view_index,
                ring: ring_index,
                u: c.pixel.0 + s * c.normal.0,
                v: c.pixel.1 + s * c.normal.1,
                azimuth: c.azimuth,
            });
        }
    }
    points
}

/// Height in the tank frame at which the view shows an edge point, on the ring's cylinder, mm; `None`
/// where the line of sight runs along it.
pub fn height_mm(view: &View, ring: &Ring, point: &OutlinePoint) -> Option<f64> {
    let x = Vec3::new(ring.radius_mm * point.azimuth.cos(), ring.radius_mm * point.azimuth.sin(), ring.z_mm);
    let (p, q) = (pixel(view, &x)?, pixel(view, &(x + Vec3::z()))?);
    let down = (q.0 - p.0, q.1 - p.1);
    let length = down.0 * down.0 + down.1 * down.1;
    let moved = (point.u - p.0) * down.0 + (point.v - p.1) * down.1;
    (length > 1e-6).then(|| ring.z_mm + moved / length)
}

/// A profile across the predicted edge, from the outer end to the inner.
struct Column {
    azimuth: f64,
    pixel: (f64, f64),
    normal: (f64, f64),
    values: Vec<f64>,
}

fn pixel(view: &View, x: &Vec3) -> Option<(f64, f64)> {
    let c = view.rotation * x + view.translation_mm;
    (c.z > 1e-6).then(|| view.lens.pixel(c.x / c.z, c.y / c.z))
}

/// Grey values from the outer end to the inner; `None` where the profile leaves the picture.
fn profile(photo: ArrayView2<u8>, p: (f64, f64), normal: (f64, f64), outer_px: f64, inner_px: f64) -> Option<Vec<f64>> {
    let n = ((outer_px + inner_px) / STEP).ceil() as usize + 1;
    (0..n)
        .map(|k| {
            let s = outer_px - STEP * k as f64;
            bilinear(photo, p.0 + s * normal.0, p.1 + s * normal.1)
        })
        .collect()
}

/// In linear light: a pixel on the edge mixes light, not code.
fn bilinear(photo: ArrayView2<u8>, u: f64, v: f64) -> Option<f64> {
    let (h, w) = photo.dim();
    if !(u >= 0.0 && v >= 0.0 && u < w as f64 - 1.0 && v < h as f64 - 1.0) {
        return None;
    }
    let (x, y) = (u as usize, v as usize);
    let (a, b) = (u - x as f64, v - y as f64);
    let at = |j: usize, i: usize| f64::from(linear_of_srgb(f32::from(photo[(j, i)]) / 255.0));
    Some((1.0 - b) * ((1.0 - a) * at(y, x) + a * at(y, x + 1)) + b * ((1.0 - a) * at(y + 1, x) + a * at(y + 1, x + 1)))
}

/// Signed place of the edge along the normal (outward positive), px from the prediction.
fn edge(stretch: &[Column], outer_px: f64, params: &OutlineParams) -> Option<f64> {
    let n = stretch[0].values.len();
    let px = |x: f64| (x / STEP) as usize;
    let margin = ((0.4 * outer_px / STEP) as usize).max(px(1.5));
    if margin >= n {
        return None;
    }
    let first = crossing(stretch, 0..margin, margin..n, params)?;
    let k = first as usize;
    let outside = k.saturating_sub(px(4.0))..k.saturating_sub(px(1.5));
    let inside = (k + px(1.5)).min(n)..(k + px(4.0)).min(n);
    if outside.len() < px(1.0) || inside.len() < px(1.0) {
        return None;
    }
    Some(outer_px - STEP * crossing(stretch, outside, inside, params)?)
}

/// Index (fractional) at which α passes 1/2 for the first time from the outside inwards.
fn crossing(stretch: &[Column], outside: Range<usize>, inside: Range<usize>, params: &OutlineParams) -> Option<f64> {
    let n = stretch[0].values.len();
    let mut power = vec![0.0; n];
    for (k, power) in power.iter_mut().enumerate() {
        let mean = stretch.iter().map(|c| c.values[k]).sum::<f64>() / stretch.len() as f64;
        *power = stretch.iter().map(|c| (c.values[k] - mean).powi(2)).sum::<f64>() / stretch.len() as f64;
    }
    let low = median(&mut power[outside.clone()].to_vec());
    // The upper quartile: the print may end within the profile.
    let mut within = power[inside].to_vec();
    within.sort_by(f64::total_cmp);
    let high = within[3 * within.len() / 4];
    if high.sqrt() < low.sqrt() + params.min_contrast || high < params.min_rise.powi(2) * low {
        return None;
    }
    let half = low + 0.25 * (high - low);
    let k = (outside.start.max(1)..n).find(|&k| power[k] >= half && power[k - 1] < half)?;
    Some((k - 1) as f64 + (half - power[k - 1]) / (power[k] - power[k - 1]))
}
