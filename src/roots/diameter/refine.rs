//! Moves centrelines to where the photographs show the roots.
//!
//! The ridge of the merged light lies towards the lit side of a root. Here the shift across the root (two unknowns,
//! common to all photographs) is sought that lowers the summed `n ln RSS` of bar and shade together, the shade
//! taking up the one-sided light; the width is that of the place before. Each photograph's cost is computed at
//! some offsets across its line and read between them, so that the whole plane of shifts can be searched. A
//! photograph's part is limited, so that an illusory root or a hidden neighbour in a minority of photographs has no
//! say. On thin roots shift and shade look alike: a weak pull towards no shift decides. Along the root the shifts are
//! smoothed like the centreline itself.

use super::DiameterParams;
use super::bar::Bars;
use super::profile::Profile;
use super::width::{LIMIT, fit, shows};
use crate::optics::Vec3;
use crate::roots::curve;

/// Offsets across the line at which a photograph's cost is computed: this many to either side of 0.
const OFFSETS: i32 = 5;
/// Steps of the search to either side.
const STEPS: i32 = 20;
/// A shift of this size costs as much as one unit of `n ln RSS`, mm.
const PULL_MM: f64 = 0.5;

/// One photograph's cost over the offset across its line.
struct Cost {
    /// Change of the offset with the shift, px/mm.
    across: Vec3,
    /// Distance of the offsets, px.
    step_px: f64,
    /// `n ln (RSS / RSS at 0)`, limited, at the offsets.
    rises: Vec<f64>,
}

impl Cost {
    fn new(profile: &Profile, diameter_mm: f64, bars: &Bars, furthest_mm: f64) -> Option<Self> {
        let width_px = diameter_mm * profile.scale;
        let zero = fit(profile, 0.0, width_px, bars);
        if !shows(&zero) {
            return None;
        }
        let step_px = furthest_mm * profile.across.norm() / f64::from(OFFSETS);
        let rise = |k: i32| {
            let f = fit(profile, f64::from(k) * step_px, width_px, bars);
            let rise = profile.pixels.len() as f64 * (f.rss / zero.rss).ln();
            if f.light > 0.0 { rise.clamp(-LIMIT, LIMIT) } else { LIMIT }
        };
        Some(Self { across: profile.across, step_px, rises: (-OFFSETS..=OFFSETS).map(rise).collect() })
    }

    /// The cost at a shift, by the parabola through the three nearest offsets.
    fn at(&self, shift: &Vec3) -> f64 {
        let x = (self.across.dot(shift) / self.step_px + f64::from(OFFSETS)).clamp(0.0, f64::from(2 * OFFSETS));
        let k = (x.round() as usize).clamp(1, self.rises.len() - 2);
        let f = x - k as f64;
        let (a, b, c) = (self.rises[k - 1], self.rises[k], self.rises[k + 1]);
        b + f * (0.5 * (c - a) + f * 0.5 * (a - 2.0 * b + c))
    }
}

/// The shift across `tangent` that explains the profiles of a root of `diameter_mm` best, mm; none where it would lie
/// on the border of what is searched.
pub fn shift(
    profiles: &[Profile],
    tangent: &Vec3,
    diameter_mm: f64,
    bars: &Bars,
    params: &DiameterParams,
) -> Option<Vec3> {
    let first = tangent.cross(&if tangent.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() }).normalize();
    let second = tangent.cross(&first);
    let costs: Vec<Cost> =
        profiles.iter().filter_map(|p| Cost::new(p, diameter_mm, bars, params.furthest_mm)).collect();
    if costs.len() < params.min_views {
        return None;
    }
    let step_mm = params.furthest_mm / f64::from(STEPS);
    let cost = |a: i32, b: i32| -> f64 {
        let shift = (first * f64::from(a) + second * f64::from(b)) * step_mm;
        costs.iter().map(|c| c.at(&shift)).sum::<f64>() + shift.norm_squared() / (PULL_MM * PULL_MM)
    };
    let (mut best, mut at) = (cost(0, 0), (0, 0));
    let mut search = |centre: (i32, i32), reach: i32, stride: usize| {
        for a in (centre.0 - reach..=centre.0 + reach).step_by(stride) {
            for b in (centre.1 - reach..=centre.1 + reach).step_by(stride) {
                let inside = a * a + b * b <= STEPS * STEPS;
                let value = if inside { cost(a, b) } else { f64::INFINITY };
                if value < best {
                    (best, at) = (value, (a, b));
                }
            }
        }
        at
    };
    let coarse = search((0, 0), STEPS, 4);
    let (a, b) = search(coarse, 3, 1);
    let shift = (first * f64::from(a) + second * f64::from(b)) * step_mm;
    (shift.norm() < 0.95 * params.furthest_mm).then_some(shift)
}

/// The shift of every point at ascending `arc` positions, from shifts `[arc, x, y, z]` at some: smoothed and
/// interpolated; beyond the outer ones theirs; none for fewer than two.
pub fn spread(arc: &[f64], shifts: &[[f64; 4]], step_mm: f64, wavelength_mm: f64) -> Vec<Vec3> {
    if shifts.len() < 2 {
        return vec![Vec3::zeros(); arc.len()];
    }
    let at: Vec<f64> = shifts.iter().map(|s| s[0]).collect();
    let values: Vec<[f64; 3]> = shifts.iter().map(|s| [s[1], s[2], s[3]]).collect();
    let smooth = curve::smooth_values(&at, &values, step_mm, wavelength_mm);
    arc.iter()
        .map(|&s| {
            let after = at.iter().position(|a| *a >= s).unwrap_or(at.len() - 1).max(1);
            let f = ((s - at[after - 1]) / (at[after] - at[after - 1]).max(1e-12)).clamp(0.0, 1.0);
            Vec3::from(std::array::from_fn::<f64, 3, _>(|d| {
                smooth[after - 1][d] + f * (smooth[after][d] - smooth[after - 1][d])
            }))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::width::common;
    use super::*;

    /// Bars of 0.9 mm lit from one side and shifted by `shift`, seen from all around at 2.4 px/mm.
    fn seen(shift: &Vec3, shade: f64) -> Vec<Profile> {
        let bars = Bars::new(0.5, 0.0);
        (0..16)
            .map(|view| {
                let angle = 0.39 * f64::from(view);
                let across = Vec3::new(angle.cos(), angle.sin(), 0.1) * 2.4;
                let pixels = (0..60)
                    .map(|k| {
                        let x = 0.2 * f64::from(k) - 6.0;
                        let [_, bar, slope] = bars.at(x - across.dot(shift), 0.9 * 2.4);
                        let noise = (f64::from(k * 7 + view) * 12.9898).sin() * 43758.5453 % 1.0;
                        // A quarter of the views shows something else beside.
                        let other = if view % 4 == 0 { 0.4 * bars.at(x - 2.5, 2.0)[1] } else { 0.0 };
                        (x, 0.1 + 0.2 * bar + shade * 0.2 * slope + other + 0.004 * noise)
                    })
                    .collect();
                Profile { pixels, scale: 2.4, across, half_px: 6.0 }
            })
            .collect()
    }

    #[test]
    fn light_from_one_side_and_a_minority_of_views_move_nothing() {
        let (bars, params) = (Bars::new(0.5, 0.0), DiameterParams::default());
        let truth = Vec3::new(0.3, -0.2, 0.0);
        for shade in [0.0, 0.5] {
            let profiles = seen(&truth, shade);
            let found = shift(&profiles, &Vec3::z(), 0.9, &bars, &params).unwrap();
            assert!((found - truth).norm() < 0.08, "{found} at shade {shade}");
            // As the stage measures: over all widths, then about the one found; and from a start that is far off.
            let profiles = seen(&Vec3::zeros(), shade);
            let first = common(&profiles, &bars, None, &params).measured.unwrap().diameter_mm;
            for expected_mm in [first, 0.7] {
                let width = common(&profiles, &bars, Some(expected_mm), &params).measured.unwrap();
                assert!((width.diameter_mm - 0.9).abs() < 0.05, "{width:?} from {expected_mm}");
            }
        }
    }
}
