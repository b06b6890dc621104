//! The photographs' point spread, sought where it shows: in how bright thin roots are.
//!
//! Roots of one plant are about equally bright in one photograph, thick or thin. Taken for sharper than it is, a photograph
//! makes of a thin root a wide and dim one, and the other way round; wide roots keep their light. So the spread is that at which
//! the thinnest third of the measured places (by width in px) is as bright as the thickest third, each against the median of its
//! photograph. The veil and the neighbours beside a root, which always ask the residuals for a wider spread, dim both alike.

use super::bar::Bars;
use super::profile::Profile;
use super::width::{common, fit};
use super::{DiameterParams, SHARPEST_PX};
use crate::math::robust::median;
use rayon::prelude::*;

/// Ratio of neighbouring spreads tried.
const RATIO: f64 = 1.25;
/// How many are tried, from the sharpest on: up to 0.9 px.
const TRIED: i32 = 6;
/// Fewest bars that tell a spread.
const FEWEST: usize = 100;

/// The profiles of one place, each with the number of its photograph.
pub type Place = Vec<(usize, Profile)>;

/// The point spread, px: no sharper than the pixel's own square; that where the places tell none.
pub fn spread_px(places: &[Place], params: &DiameterParams) -> f64 {
    let mut before: Option<(f64, f64)> = None;
    for k in 0..TRIED {
        let spread = SHARPEST_PX * RATIO.powi(k);
        let Some(excess) = excess(places, &Bars::new(spread, params.limb), params) else { break };
        if excess >= 0.0 {
            let Some((sharper, dim)) = before else { return spread };
            return sharper + (spread - sharper) * dim / (dim - excess);
        }
        before = Some((spread, excess));
    }
    before.map_or(SHARPEST_PX, |(widest, _)| widest)
}

/// How much brighter thin bars are than thick ones, as a logarithm; none where too few are measured.
fn excess(places: &[Place], bars: &Bars, params: &DiameterParams) -> Option<f64> {
    let of_place = |place: &Place| -> Vec<(usize, f64, f64)> {
        let profiles: Vec<Profile> = place.iter().map(|(_, profile)| profile.clone()).collect();
        let Some(found) = common(&profiles, bars, None, params).measured else { return Vec::new() };
        let bar = |(view, profile): &(usize, Profile)| {
            let width_px = found.diameter_mm * profile.scale;
            let light = fit(profile, 0.0, width_px, bars).light;
            (light > 0.0).then(|| (*view, width_px, light.ln()))
        };
        place.iter().filter_map(bar).collect()
    };
    let mut found: Vec<(usize, f64, f64)> = places.par_iter().flat_map_iter(of_place).collect();
    if found.len() < FEWEST {
        return None;
    }
    let views = 1 + found.iter().map(|f| f.0).max()?;
    let mut by_view = vec![Vec::new(); views];
    found.iter().for_each(|f| by_view[f.0].push(f.2));
    let usual: Vec<f64> = by_view.iter_mut().map(|lights| median(lights)).collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let third = found.len() / 3;
    let level = |part: &[(usize, f64, f64)]| median(&mut part.iter().map(|f| f.2 - usual[f.0]).collect::<Vec<_>>());
    Some(level(&found[..third]) - level(&found[found.len() - third..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Vec3;

    /// Places of roots of 0.4 to 1.6 mm at 2 px/mm in twelve photographs, blurred by `spread`; each photograph has a light of its own.
    fn places(spread: f64) -> Vec<Place> {
        let bars = Bars::new(spread, 0.0);
        let of = |k: usize| -> Place {
            let width = (0.4 + 1.2 * (k as f64 / 39.0)) * 2.0;
            let photograph = |view: usize| {
                let pixels = (0..60)
                    .map(|i| {
                        let x = 0.2 * f64::from(i) - 6.0;
                        let noise = ((f64::from(i) * 7.0 + (view * 31 + k * 17) as f64).sin() * 43758.5453).fract();
                        let light = 0.1 + 0.02 * view as f64;
                        (x, 0.2 + light * bars.at(x, width)[1] + 0.004 * noise)
                    })
                    .collect();
                (view, Profile { pixels, scale: 2.0, across: Vec3::x() * 2.0, half_px: 6.0 })
            };
            (0..12).map(photograph).collect()
        };
        (0..40).map(of).collect()
    }

    #[test]
    fn the_spread_is_found_and_never_sharper_than_a_pixel() {
        let params = DiameterParams { limb: 0.0, ..DiameterParams::default() };
        for spread in [0.29, 0.4, 0.55, 0.7] {
            let found = spread_px(&places(spread), &params);
            assert!((found - spread).abs() < 0.06, "{found} px for {spread}");
        }
        assert_eq!(spread_px(&places(0.5)[..5], &params), SHARPEST_PX, "five places tell nothing");
    }
}
