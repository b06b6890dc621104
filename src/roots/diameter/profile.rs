//! The light of one photograph about one centreline point.

use super::DiameterParams;
use super::clutter::Clutter;
use super::sight::{Pixel, Sight};
use super::track::{Beads, Track};
use crate::optics::Vec3;

/// The light about a stretch of root in one photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Distance across the projected line, px, and light, of every pixel taken.
    pub pixels: Vec<(f64, f64)>,
    /// Scale across the line, px/mm.
    pub scale: f64,
    /// Change of the distance across the line, px, per mm of the point's way.
    pub across: Vec3,
    /// Half width of the strip that the pixels come from, px.
    pub half_px: f64,
}

/// Share of the pixels within the root's own width that must be free of other roots.
const FREE: f64 = 0.6;

/// A root in one photograph.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// The photograph.
    pub sight: &'a Sight<'a>,
    /// What covers what in it.
    pub clutter: &'a Clutter<'a>,
    /// Where it shows the root's beads.
    pub track: &'a Track,
}

/// The profile about bead `b` (one with a derivative) of root `number` of the list, `radius_mm` thick, in one
/// photograph; none where the stretch is not seen, seen end on, or covered by other roots.
pub fn profile(
    seen: &Seen<'_>,
    beads: &Beads,
    number: usize,
    b: usize,
    radius_mm: f64,
    params: &DiameterParams,
) -> Option<Profile> {
    let Seen { sight, clutter, track } = seen;
    let (centre, jacobian) = (track.pixels[b]?, track.jacobian(b)?);
    let reach = (params.stretch_mm / params.bead_mm()).round().max(1.0) as usize;
    let ends = (b.saturating_sub(reach), (b + reach).min(beads.places.len() - 1));
    let mut line = Vec::with_capacity(ends.1 - ends.0 + 1);
    for pixel in &track.pixels[ends.0..=ends.1] {
        line.push((*pixel)?);
    }
    let (first, last) = (line[0], line[line.len() - 1]);
    let along = (last - first).try_normalize(1e-9)?;
    let across = Pixel::new(-along.y, along.x);
    let tangent = (beads.places[ends.1] - beads.places[ends.0]).try_normalize(1e-9)?;
    // The view's direction in the water moves no pixel: it spans the kernel of the Jacobian.
    let (right, down) = (jacobian.row(0).transpose(), jacobian.row(1).transpose());
    let view = right.cross(&down).try_normalize(1e-12)?;
    let side = view.cross(&tangent);
    // Seen nearly end on, the stretch is a spot, not a bar.
    if side.norm() < 0.5 {
        return None;
    }
    let scale = (jacobian * side.normalize()).dot(&across).abs();
    let expected = 2.0 * radius_mm * scale;
    let half = 0.75 * expected + params.margin_px;
    let length = (last - first).norm().max(2.0);
    let reach = half.hypot(0.5 * length) + 1.0;
    let (height, width) = sight.light.dim();
    let range = |centre: f64, size: usize| {
        (centre - reach).ceil().max(0.0) as usize..((centre + reach).floor() + 1.0).clamp(0.0, size as f64) as usize
    };
    let mut pixels = Vec::new();
    let (mut own, mut free) = (0u32, 0u32);
    for v in range(centre.y, height) {
        for u in range(centre.x, width) {
            let at = Pixel::new(u as f64, v as f64);
            let t = (at - centre).dot(&along);
            if t.abs() > 0.5 * length {
                continue;
            }
            let x = offset(&line, &at, &across);
            if x.abs() > half {
                continue;
            }
            let foreign = clutter.is_foreign(v, u, number);
            if x.abs() <= 0.5 * expected + 1.0 {
                own += 1;
                free += u32::from(!foreign);
            }
            if !foreign {
                pixels.push((x, f64::from(sight.light[[v, u]])));
            }
        }
    }
    (f64::from(free) >= FREE * f64::from(own) && pixels.len() >= 12).then_some(Profile {
        pixels,
        scale,
        across: jacobian.transpose() * across,
        half_px: half,
    })
}

/// Signed distance of a pixel from the polyline, positive towards `across`.
fn offset(line: &[Pixel], at: &Pixel, across: &Pixel) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for pair in line.windows(2) {
        let way = pair[1] - pair[0];
        let f = ((at - pair[0]).dot(&way) / way.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        let miss = at - pair[0] - way * f;
        let distance = miss.norm();
        if distance < best.0 {
            best = (distance, if miss.dot(across) < 0.0 { -distance } else { distance });
        }
    }
    best.1
}
