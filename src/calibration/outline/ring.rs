//! Rims, floors and belt edges.
//!
//! No single profile tells the edge of a print; a stretch does: the variance over its profiles, `V(s) = var_c I_c(s)`,
//! rises from V₀ (noise, room or table, outside) to V₁ (print, inside) as `V₀ + α² (V₁ - V₀)` where a part α of the light
//! (linear, not sRGB code) comes from inside, and the edge is where α = 1/2. A mere step of brightness, such as the table's
//! edge, is none.
//!
//! Always the near half of a ring is looked at, where the print on the outer wall ends. To a camera that looks over the
//! rim (or up at the floor) the far half outlines the tank, but there the print is seen from behind, through walls that
//! bend the light, or not at all.

use super::{Column, Found, OutlineParams, bilinear, edge, pixel, profile};
use crate::calibration::adjust::{Contour, OutlinePoint, Shape};
use crate::math::robust::median;
use crate::optics::{Vec3, View};
use ndarray::ArrayView2;
use std::ops::Range;

/// Edge points of one ring in one photograph.
pub(super) fn measure(
    photo: ArrayView2<u8>,
    view: &View,
    radius_mm: f64,
    z_mm: f64,
    outward: f64,
    reach_mm: f64,
    params: &OutlineParams,
) -> Vec<Found> {
    let centre = view.centre_in_tank();
    let distance = centre.x.hypot(centre.y);
    if distance <= radius_mm {
        return Vec::new();
    }
    let toward = centre.y.atan2(centre.x);
    let half = (radius_mm / distance).acos();
    let (low, high) = (toward - params.arc * half, toward + params.arc * half);

    let mut columns: Vec<Column> = Vec::new();
    let mut azimuth = low;
    let middle_mm = Vec3::new(radius_mm * toward.cos(), radius_mm * toward.sin(), z_mm);
    let (Some(a), Some(b)) = (pixel(view, &middle_mm), pixel(view, &(middle_mm + Vec3::z()))) else {
        return Vec::new();
    };
    let reach_px = (reach_mm * (a.0 - b.0).hypot(a.1 - b.1)).max(6.0);
    // Less far outwards where the picture ends.
    let out = ((b.0 - a.0) * outward, (b.1 - a.1) * outward);
    let length = out.0.hypot(out.1).max(1e-6);
    let room = (0..reach_px as usize)
        .take_while(|&s| {
            let s = s as f64 + 2.0;
            bilinear(photo, a.0 + s * out.0 / length, a.1 + s * out.1 / length).is_some()
        })
        .count() as f64;
    let outer_px = reach_px.min(room);
    while azimuth < high {
        let on_ring = |a: f64| Vec3::new(radius_mm * a.cos(), radius_mm * a.sin(), z_mm);
        let x = on_ring(azimuth);
        let (Some(p), Some(q), Some(o)) =
            (pixel(view, &x), pixel(view, &on_ring(azimuth + 1e-4)), pixel(view, &(x + Vec3::new(0.0, 0.0, outward))))
        else {
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
            columns.push(Column { along: x.y.atan2(x.x), pixel: p, normal, values });
        }
    }
    let per_bin = columns.len().div_ceil(params.bins).max(1);
    let mut points = Vec::new();
    for stretch in columns.chunks(per_bin).filter(|s| 2 * s.len() > per_bin && s.len() >= 8) {
        let crossing = |outside, inside| crossing(stretch, outside, inside, params);
        points.extend(edge(stretch[0].values.len(), outer_px, crossing).map(|s| Found::of(stretch, s)));
    }
    points
}

/// Height in the tank frame at which the view shows an edge point, on the ring's cylinder, mm; `None`
/// where the line of sight runs along it, and of a side.
pub fn height_mm(view: &View, ring: &Contour, point: &OutlinePoint) -> Option<f64> {
    let Shape::Ring { z_mm, .. } = ring.shape else { return None };
    let x = Vec3::new(ring.radius_mm * point.along.cos(), ring.radius_mm * point.along.sin(), z_mm);
    let (p, q) = (pixel(view, &x)?, pixel(view, &(x + Vec3::z()))?);
    let down = (q.0 - p.0, q.1 - p.1);
    let length = down.0 * down.0 + down.1 * down.1;
    let moved = (point.u - p.0) * down.0 + (point.v - p.1) * down.1;
    (length > 1e-6).then(|| z_mm + moved / length)
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
