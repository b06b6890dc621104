//! The width that explains the profiles of several photographs together.

use super::bar::Bars;
use super::profile::Profile;
use super::{DiameterParams, Measured, Station};
use crate::roots::trace::Looks;
use nalgebra::{Matrix4, Vector4};

/// Ratio of neighbouring widths tried, of the first search and of the second.
const RATIOS: [f64; 2] = [1.33, 1.12];
/// Offsets at which a root that moved is looked for, in expected widths, at least one pixel each.
const ASIDE: [f64; 3] = [0.6, 1.2, 1.8];
/// Widths tried in the second search lie within this factor of the expected one.
const NEAR: f64 = 1.6;
/// How far a photograph may move the common estimate: the rise of its `n ln RSS` is limited to this.
pub(super) const LIMIT: f64 = 12.0;
/// A photograph shows a root when the bar's light exceeds its standard error this many times.
const SHOWN: f64 = 3.0;

/// A least squares fit of background, bar and shade at one width.
#[derive(Debug, Clone, Copy)]
pub struct Fit {
    /// Sum of squared residuals.
    pub rss: f64,
    /// Light c of the bar, beyond the background's.
    pub light: f64,
    /// Its squared standard error.
    pub variance: f64,
}

/// Fits background, bar and shade for a bar about `centre`.
pub fn fit(profile: &Profile, centre: f64, width_px: f64, bars: &Bars) -> Fit {
    let mut sums = [[0.0; 5]; 5];
    for &(x, y) in &profile.pixels {
        let x = x - centre;
        let [cover, bar, shade] = bars.at(x, width_px);
        let row = [1.0 - cover + bar, x * (1.0 - cover), bar, shade, y];
        for a in 0..5 {
            for b in a..5 {
                sums[a][b] += row[a] * row[b];
            }
        }
    }
    let mut gram = Matrix4::from_fn(|a, b| sums[a.min(b)][a.max(b)]);
    let right = Vector4::from_fn(|a, _| sums[a][4]);
    let square = sums[4][4];
    // A term that the pixels do not tell from the others keeps a finite place.
    let ridge = 1e-9 * gram.trace().max(1e-300);
    gram += Matrix4::identity() * ridge;
    let Some(cholesky) = gram.cholesky() else { return Fit { rss: square, light: 0.0, variance: f64::INFINITY } };
    let found = cholesky.solve(&right);
    let rss = (square - found.dot(&right)).max(1e-12);
    let spare = (profile.pixels.len() as f64 - 4.0).max(1.0);
    // The entry of the inverse that belongs to the bar: the squared length of L⁻¹ e₂.
    let share = cholesky.l_dirty().solve_lower_triangular(&Vector4::z()).map_or(f64::INFINITY, |v| v.norm_squared());
    Fit { rss, light: found[2], variance: rss / spare * share }
}

/// Whether the bar stands out of the noise.
pub fn shows(fit: &Fit) -> bool {
    fit.light > 0.0 && fit.light * fit.light > SHOWN * SHOWN * fit.variance
}

/// How many of the photographs show a root, and their common diameter: none when fewer than `min_views` do. Searched over
/// all diameters of the parameters, or, more finely, about the one that is expected.
pub fn common(profiles: &[Profile], bars: &Bars, expected_mm: Option<f64>, params: &DiameterParams) -> Station {
    let (least, most) = (params.thinnest_mm, params.thickest_mm);
    let (from, to, ratio) = match expected_mm {
        None => (least, most, RATIOS[0]),
        Some(d) => ((d / NEAR).max(least), (d * NEAR).clamp(least * RATIOS[1], most), RATIOS[1]),
    };
    let count = ((to / from).ln() / ratio.ln()).ceil().max(2.0) as i32;
    let widths: Vec<f64> = (0..=count).map(|k| from * ratio.powi(k)).collect();
    let mut rises: Vec<Vec<f64>> = Vec::new();
    let mut moved = 0;
    for profile in profiles {
        if expected_mm.is_some_and(|d| is_aside(profile, d * profile.scale, bars)) {
            moved += 1;
            continue;
        }
        // A bar that leaves no background on either side cannot be told from it.
        let room = |w: f64| w * profile.scale <= 2.0 * profile.half_px - 2.0;
        let fits: Vec<Fit> =
            widths.iter().take_while(|w| room(**w)).map(|w| fit(profile, 0.0, w * profile.scale, bars)).collect();
        let best =
            (0..fits.len()).filter(|&k| fits[k].light > 0.0).min_by(|&a, &b| fits[a].rss.total_cmp(&fits[b].rss));
        let Some(best) = best.filter(|&k| shows(&fits[k])) else { continue };
        let n = profile.pixels.len() as f64;
        let rise = |f: &Fit| if f.light > 0.0 { (n * (f.rss / fits[best].rss).ln()).min(LIMIT) } else { LIMIT };
        rises.push((0..widths.len()).map(|k| fits.get(k).map_or(LIMIT, rise)).collect());
    }
    let looks = Looks { unhindered: profiles.len() as u32, showing: (rises.len() + moved) as u32 };
    if rises.len() < params.min_views {
        return Station { looks, measured: None };
    }
    let total: Vec<f64> = (0..widths.len()).map(|k| rises.iter().map(|r| r[k]).sum()).collect();
    let width_at = |at: f64| from * ratio.powf(at);
    let diameter_mm = width_at(lowest(&total));
    let mut off: Vec<f64> = rises.iter().map(|r| (width_at(lowest(r)) - diameter_mm).abs()).collect();
    off.sort_by(f64::total_cmp);
    let sd_mm = 1.4826 * off[off.len() / 2] / (rises.len() as f64).sqrt();
    let measured = Measured { diameter_mm, sd_mm: sd_mm.max(0.01 * diameter_mm), views: rises.len() as u32 };
    Station { looks, measured: Some(measured) }
}

/// Whether the photograph shows the root clearly beside its line: roots sway. A bar there would be taken for a wide one here.
fn is_aside(profile: &Profile, width_px: f64, bars: &Bars) -> bool {
    let here = fit(profile, 0.0, width_px, bars);
    let limit = here.rss * (-LIMIT / profile.pixels.len() as f64).exp();
    ASIDE.iter().flat_map(|a| [a * width_px.max(1.0), -a * width_px.max(1.0)]).any(|x| {
        let there = fit(profile, x, width_px, bars);
        there.rss < limit && shows(&there)
    })
}

/// Place of the minimum between the entries, by the parabola through the lowest and its neighbours.
fn lowest(values: &[f64]) -> f64 {
    let k = (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b])).unwrap_or(0);
    if k == 0 || k + 1 >= values.len() {
        return k as f64;
    }
    let (a, b, c) = (values[k - 1], values[k], values[k + 1]);
    let bend = a - 2.0 * b + c;
    if bend > 1e-12 && bend.is_finite() { k as f64 + (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { k as f64 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Vec3;

    #[test]
    fn light_beside_the_line_is_that_beyond_the_background_there() {
        let bars = Bars::new(0.4, 0.5);
        for (centre, contrast) in [(3.0, -0.02), (-3.0, 0.02), (0.0, 0.02)] {
            let pixels = (0..80)
                .map(|k| {
                    let x = 0.2 * f64::from(k) - 8.0;
                    let noise = (f64::from(k) * 12.9898).sin() * 43758.5453 % 1.0;
                    let [cover, bar, _] = bars.at(x - centre, 2.0);
                    let behind = 0.3 + 0.01 * x;
                    (x, behind * (1.0 - cover) + (0.3 + 0.01 * centre + contrast) * bar + 0.001 * noise)
                })
                .collect();
            let profile = Profile { pixels, scale: 2.0, across: Vec3::x() * 2.0, half_px: 8.0 };
            let found = fit(&profile, centre, 2.0, &bars);
            assert!((found.light - contrast).abs() < 0.004, "{} for {contrast}", found.light);
            assert_eq!(shows(&found), contrast > 0.0);
        }
    }
}
