//! Where the photographs show the edges of the tank's outline (rim, floor, belt edges, sides of belts), to a fraction of a
//! pixel.
//!
//! Along each contour, profiles are taken across the predicted edge every `spacing_px` and gathered in stretches, so that
//! the print, dark here and light there, averages out; the edge of a stretch is found twice, with levels from the
//! profile's ends, then with levels from 1.5 to 4 px on either side of the first place. What tells inside from outside is
//! another thing on rings and on sides. Stretches whose step is lost in the noise, or that leave the picture, are
//! skipped.

mod ring;
mod side;

use super::adjust::{Contour, OutlinePoint, Shape};
use crate::optics::{Vec3, View};
use crate::photo::colour::linear_of_srgb;
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};
use std::ops::Range;

pub use ring::height_mm;

/// How edges are looked for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutlineParams {
    /// Distance between samples along the contour, px, 1..20; neighbours nearer than the blur are no news.
    pub spacing_px: f64,
    /// Half the length of a profile in the first round, mm on the wall: how far off the prediction may be.
    pub reach_mm: f64,
    /// The same in later rounds, mm.
    pub fine_reach_mm: f64,
    /// Stretches per ring and view, 1..50; a side is one.
    pub bins: usize,
    /// A ring's step counts where √V rises by at least this (linear light, 0..1), a side's where the mean changes by it; 0.02
    /// is white print at a tenth of full exposure.
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

/// Edge points of one contour in one photograph (gray, 0..255); `reach_mm` as in [`OutlineParams`].
pub fn measure(
    photo: ArrayView2<u8>,
    view: &View,
    view_index: usize,
    contour: &Contour,
    contour_index: usize,
    reach_mm: f64,
    params: &OutlineParams,
) -> Vec<OutlinePoint> {
    let found = match contour.shape {
        Shape::Ring { z_mm, outward } => ring::measure(photo, view, contour.radius_mm, z_mm, outward, reach_mm, params),
        Shape::Side { z_mm, turn } => side::measure(photo, view, contour.radius_mm, z_mm, turn, reach_mm, params),
    };
    let point = |f: Found| OutlinePoint {
        view: view_index,
        contour: contour_index,
        u: f.pixel.0,
        v: f.pixel.1,
        along: f.along,
    };
    found.into_iter().map(point).collect()
}

/// A place of an edge.
struct Found {
    pixel: (f64, f64),
    along: f64,
}

impl Found {
    /// The place `s` px outwards of the prediction in the middle of a stretch.
    fn of(stretch: &[Column], s: f64) -> Self {
        let c = &stretch[stretch.len() / 2];
        Self { pixel: (c.pixel.0 + s * c.normal.0, c.pixel.1 + s * c.normal.1), along: c.along }
    }
}

/// A profile across the predicted edge, from the outer end to the inner.
struct Column {
    /// Place along the contour.
    along: f64,
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

/// Signed place of the edge along the normal (outward positive), px from the prediction; `crossing` tells the index at
/// which it is for levels from the ranges outside and inside.
fn edge(samples: usize, outer_px: f64, crossing: impl Fn(Range<usize>, Range<usize>) -> Option<f64>) -> Option<f64> {
    let n = samples;
    let px = |x: f64| (x / STEP) as usize;
    let margin = ((0.4 * outer_px / STEP) as usize).max(px(1.5));
    if margin >= n {
        return None;
    }
    let first = crossing(0..margin, margin..n)?;
    let k = first as usize;
    let outside = k.saturating_sub(px(4.0))..k.saturating_sub(px(1.5));
    let inside = (k + px(1.5)).min(n)..(k + px(4.0)).min(n);
    if outside.len() < px(1.0) || inside.len() < px(1.0) {
        return None;
    }
    Some(outer_px - STEP * crossing(outside, inside)?)
}
