//! Where a printed belt turns out of sight, to the left and to the right.
//!
//! The print is seen at a grazing angle there: a pixel gathers many of its dots and shows their mean, on which the variance
//! of [`super::ring`] cannot rest. The mean over the stretch's profiles steps from the level outside to that inside; the
//! edge is half-way. A room as bright as the print's mean shows no side.

use super::{Column, Found, OutlineParams, edge, pixel, profile};
use crate::calibration::adjust::Contour;
use crate::math::robust::median;
use crate::optics::{Vec3, View};
use ndarray::ArrayView2;
use std::ops::Range;

/// Part of the belt's height at either end that is left out: its edges are another contour.
const END: f64 = 0.1;

/// Edge points of one side in one photograph.
pub(super) fn measure(
    photo: ArrayView2<u8>,
    view: &View,
    radius_mm: f64,
    z_mm: [f64; 2],
    turn: f64,
    reach_mm: f64,
    params: &OutlineParams,
) -> Vec<Found> {
    let Some(azimuth) = Contour::side_azimuth(turn, radius_mm, &view.centre_in_tank()) else { return Vec::new() };
    let (c, s) = (azimuth.cos(), azimuth.sin());
    let at = |radius_mm: f64, z_mm: f64| pixel(view, &Vec3::new(radius_mm * c, radius_mm * s, z_mm));
    let margin = END * (z_mm[1] - z_mm[0]);
    let (mut z, end) = (z_mm[0] + margin, z_mm[1] - margin);
    let (mut columns, mut reach_px) = (Vec::new(), 0.0);
    while z < end {
        let (Some(p), Some(down), Some(out)) = (at(radius_mm, z), at(radius_mm, z + 1.0), at(radius_mm + 1.0, z))
        else {
            break;
        };
        let along = (down.0 - p.0, down.1 - p.1);
        let speed = along.0.hypot(along.1).max(1e-6);
        if columns.is_empty() {
            reach_px = (reach_mm * speed).max(6.0);
        }
        let mut normal = (-along.1 / speed, along.0 / speed);
        if normal.0 * (out.0 - p.0) + normal.1 * (out.1 - p.1) < 0.0 {
            normal = (-normal.0, -normal.1);
        }
        if let Some(values) = profile(photo, p, normal, reach_px, reach_px) {
            columns.push(Column { along: z, pixel: p, normal, values });
        }
        z += params.spacing_px / speed;
    }
    if columns.len() < 8 {
        return Vec::new();
    }
    let n = columns[0].values.len();
    let mean: Vec<f64> =
        (0..n).map(|k| columns.iter().map(|c| c.values[k]).sum::<f64>() / columns.len() as f64).collect();
    let crossing = |outside, inside| crossing(&mean, outside, inside, params.min_contrast);
    edge(n, reach_px, crossing).map(|s| Found::of(&columns, s)).into_iter().collect()
}

/// Index (fractional) at which the mean passes half-way between its levels for the first time from the outside inwards.
fn crossing(mean: &[f64], outside: Range<usize>, inside: Range<usize>, min_contrast: f64) -> Option<f64> {
    let level = |range: Range<usize>| median(&mut mean[range].to_vec());
    let start = outside.start.max(1);
    let (out, inn) = (level(outside), level(inside));
    if (inn - out).abs() < min_contrast {
        return None;
    }
    let share = |k: usize| (mean[k] - out) / (inn - out);
    let k = (start..mean.len()).find(|&k| share(k) >= 0.5 && share(k - 1) < 0.5)?;
    Some((k - 1) as f64 + (0.5 - share(k - 1)) / (share(k) - share(k - 1)))
}
