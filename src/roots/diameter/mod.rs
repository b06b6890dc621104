//! Diameters from the photographs.
//!
//! At every measured centreline point and in every photograph that sees it through a regular, clear ray, the pixels of
//! the photograph as taken (not undistorted, not interpolated, in linear light) about the projected centreline are
//! compared with a blurred bar:
//!
//! `light(x) = (a + b x) (1 − cover(x; w s, σ)) + (a + c) · bar(x; w s, σ) + d · shade(x; w s, σ)`,
//! cover(x; w, σ) = ½ [erf((x + w/2) / σ√2) − erf((x − w/2) / σ√2)], bar: the same with light that falls off towards its
//! limbs ([`bar`]), shade: with one that rises across it
//!
//! A root hides what is behind it, so its limbs' fall counts against all its light, not against its contrast. Light is that
//! along the colour axis on which roots differ from what is behind them.
//!
//! x is the pixel's distance across the projected line (px; from the bar's middle where that is sought beside it), w the diameter (mm), s the scale across the line (px/mm)
//! from the Jacobian of the refracted projection, σ the point spread (px). a, b, c, d are solved for each photograph
//! (d: roots are lit from one side); w is common to all photographs: it minimises the sum over
//! photographs of `n ln RSS(w)` (noise of unknown size), each photograph's rise limited so that no photograph
//! decides alone ([`width`]). Pixels that other roots cover in the photograph are left out ([`clutter`]): in the sparse
//! rounds those of strong ridges, in the last one those that the photographs were then found to show. σ is sought in the
//! photographs ([`blur`]).
//!
//! Before, the centrelines are moved to where the photographs show the roots ([`refine`]): the bars are not let
//! free to shift in each photograph, since a bar that follows the lit side only is too narrow.
//!
//! Along a root the diameters are smoothed; their standard deviation is that of the photographs' own best
//! widths about the common one, over the root of their number. Points that fewer than `min_views` photographs measure
//! take their diameter from their neighbours; a root that has none takes the median of all, and where nothing is measured
//! at all the scale-space estimate stays.

pub mod bar;
pub mod blur;
pub mod clutter;
pub mod profile;
pub mod refine;
pub mod sight;
pub mod track;
pub mod width;

use super::curve;
use super::system::TracedRoot;
use super::trace::Looks;
use crate::error::{Error, Result};
use crate::optics::Vec3;
use bar::Bars;
use clutter::Clutter;
use profile::{Profile, Seen, profile};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use sight::Sight;
use track::{Beads, STRIDE, Track};

/// Point spread of the pixel's own square, px.
pub(super) const SHARPEST_PX: f64 = 0.29;
/// What at least this share of the photographs that look at it show is no illusion.
const SHOWN: f64 = 0.5;
/// Sparse rounds measure every so many stations.
const SPARSE: usize = 4;

/// How diameters are measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DiameterParams {
    /// Measure diameters in the photographs; `false` keeps those of the scale that fitted each root best, which are
    /// rough: with one scale all alike.
    pub enabled: bool,
    /// Distance between measured points along a root, mm, 0.2 to 10: a small part of `smooth_mm`; the centreline's
    /// points between take interpolated values.
    pub every_mm: f64,
    /// Half length of the stretch whose pixels are taken together, mm, 0.2 to 10: the diameter hardly changes over it.
    pub stretch_mm: f64,
    /// Width of background taken on either side of the root, px, 2 to 20.
    pub margin_px: f64,
    /// Standard deviation of the photographs' point spread, px, up to 5: the pixel's own square gives 0.29, a soft lens,
    /// JPEG or interpolated colours more. Too much makes thin roots too thin. 0 seeks it in the photographs ([`blur`]).
    pub spread_px: f64,
    /// How far light falls off towards a root's limbs, 0 to 1: 0 where it comes from everywhere, 1 where all comes from the
    /// camera's side.
    pub limb: f64,
    /// Fewest photographs that give a diameter, 1 to 100.
    pub min_views: usize,
    /// Waves of the diameter along a root shorter than this are noise, mm, 1 to 100.
    pub smooth_mm: f64,
    /// Furthest way that a centreline point is moved in one of the rounds, mm, 0 to 10; 0 leaves the centrelines.
    pub furthest_mm: f64,
    /// Waves of these shifts along a root shorter than this are noise, mm, 1 to 100.
    pub shift_smooth_mm: f64,
    /// Thinnest diameter looked for, mm.
    pub thinnest_mm: f64,
    /// Thickest diameter looked for, mm.
    pub thickest_mm: f64,
}

impl Default for DiameterParams {
    fn default() -> Self {
        Self {
            enabled: true,
            every_mm: 2.0,
            stretch_mm: 1.0,
            margin_px: 4.0,
            spread_px: 0.0,
            limb: 0.5,
            min_views: 3,
            smooth_mm: 20.0,
            furthest_mm: 1.0,
            shift_smooth_mm: 6.0,
            thinnest_mm: 0.1,
            thickest_mm: 6.0,
        }
    }
}

impl DiameterParams {
    /// Distance between the points that are projected, mm.
    fn bead_mm(&self) -> f64 {
        self.every_mm / STRIDE as f64
    }
}

/// What the photographs say of one centreline point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Diameter, mm.
    pub diameter_mm: f64,
    /// Its standard deviation, mm.
    pub sd_mm: f64,
    /// Photographs that it stands on.
    pub views: u32,
}

/// A centreline point that the photographs were asked about.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Station {
    /// How many looked, and how many show a root.
    pub looks: Looks,
    /// The diameter.
    pub measured: Option<Measured>,
}

/// What the photographs say beyond the diameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Measurement {
    /// Of each root as a whole.
    pub looks: Vec<Looks>,
    /// The point spread that the diameters were measured with, px.
    pub spread_px: f64,
}

/// Measures all roots in place: radii, their standard deviations, numbers of views, confidence. `strengths` are the roots'
/// rootness.
///
/// # Errors
/// Where a parameter is out of range.
pub fn measure(
    roots: &mut [TracedRoot],
    strengths: &[f64],
    sights: &[Sight<'_>],
    params: &DiameterParams,
) -> Result<Measurement> {
    for (name, value) in [
        ("every_mm", params.every_mm),
        ("stretch_mm", params.stretch_mm),
        ("margin_px", params.margin_px),
        ("smooth_mm", params.smooth_mm),
        ("thinnest_mm", params.thinnest_mm),
        ("thickest_mm", params.thickest_mm - params.thinnest_mm),
    ] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::usage(format!("diameters.{name} is {value}")).help("give a positive number"));
        }
    }
    if !(0.0..=1.0).contains(&params.limb) {
        return Err(Error::usage(format!("diameters.limb is {}", params.limb)).help("give 0 to 1"));
    }
    if !(0.0..=5.0).contains(&params.spread_px) {
        return Err(
            Error::usage(format!("diameters.spread_px is {}", params.spread_px)).help("give 0 to 5 px, 0 to seek it")
        );
    }
    let beads: Vec<Beads> = roots.iter().map(|r| Beads::new(&r.root.points_mm, params.bead_mm())).collect();
    let tracks: Vec<Vec<Track>> =
        sights.par_iter().map(|sight| beads.iter().map(|b| Track::new(sight, b)).collect()).collect();
    let mut spread_px = if params.spread_px > 0.0 { params.spread_px } else { SHARPEST_PX };
    let mut work =
        Work { sights, strengths: strengths.to_vec(), beads, tracks, bars: Bars::new(spread_px, params.limb), params };
    // The scale-space radii are coarse: two sparse rounds give the last one a width to expect.
    let mut looks = Vec::new();
    for (stride, expected) in [(SPARSE, false), (SPARSE, true), (1, true)] {
        work.shift(roots, stride, expected);
        if params.spread_px <= 0.0 && !expected {
            spread_px = blur::spread_px(&work.places(roots), params);
            work.bars = Bars::new(spread_px, params.limb);
        }
        looks = work.widths(roots, stride, expected);
        if stride > 1 && expected {
            // From now on all that is shown hides, and nothing else does.
            let shown = |looks: &Looks| if looks.share().is_some_and(|share| share >= SHOWN) { 1.0 } else { 0.0 };
            work.strengths = looks.iter().map(shown).collect();
        }
    }
    fall_back(roots);
    Ok(Measurement { looks, spread_px })
}

/// Gives roots that no photograph measured the median radius of the others, with their spread as its deviation.
fn fall_back(roots: &mut [TracedRoot]) {
    let measured = |r: &TracedRoot| r.views.iter().any(|&v| v > 0);
    let mut radii: Vec<f64> = roots.iter().filter(|r| measured(r)).flat_map(|r| r.root.radii_mm.clone()).collect();
    radii.sort_by(f64::total_cmp);
    let Some(&median) = radii.get(radii.len() / 2) else { return };
    let sd = 0.5 * (radii[radii.len() * 84 / 100] - radii[radii.len() * 16 / 100]);
    for root in roots.iter_mut().filter(|r| !measured(r)) {
        root.root.radii_mm.fill(median);
        root.radius_sd_mm.fill(sd);
    }
}

/// Everything that measuring needs.
struct Work<'a> {
    sights: &'a [Sight<'a>],
    /// Per root: its rootness, later whether the photographs show it (1, else 0).
    strengths: Vec<f64>,
    /// Per root.
    beads: Vec<Beads>,
    /// Per photograph and root.
    tracks: Vec<Vec<Track>>,
    bars: Bars,
    params: &'a DiameterParams,
}

impl Work<'_> {
    /// The beads that are measured when every `stride`-th station is.
    fn stations(&self, root: usize, stride: usize) -> impl Iterator<Item = usize> + use<> {
        (0..self.beads[root].places.len()).step_by(STRIDE * stride)
    }

    fn clutter(&self, roots: &[TracedRoot]) -> Vec<Clutter<'_>> {
        self.sights
            .par_iter()
            .zip(&self.tracks)
            .map(|(sight, tracks)| Clutter::new(sight, roots, &self.strengths, &self.beads, tracks))
            .collect()
    }

    fn profiles(&self, clutter: &[Clutter<'_>], root: usize, b: usize, radius_mm: f64) -> Vec<Profile> {
        self.place(clutter, root, b, radius_mm).into_iter().map(|(_, profile)| profile).collect()
    }

    /// The profiles with the numbers of their photographs.
    fn place(&self, clutter: &[Clutter<'_>], root: usize, b: usize, radius_mm: f64) -> blur::Place {
        let views = self.sights.iter().zip(clutter).zip(&self.tracks).enumerate();
        views
            .filter_map(|(view, ((sight, clutter), tracks))| {
                let seen = Seen { sight, clutter, track: &tracks[root] };
                Some((view, profile(&seen, &self.beads[root], root, b, radius_mm, self.params)?))
            })
            .collect()
    }

    /// Sparse places of all roots.
    fn places(&self, roots: &[TracedRoot]) -> Vec<blur::Place> {
        let clutter = self.clutter(roots);
        let one = |r: usize| -> Vec<blur::Place> {
            self.stations(r, SPARSE).map(|b| self.place(&clutter, r, b, self.expected(roots, r, b))).collect()
        };
        (0..roots.len()).into_par_iter().flat_map_iter(one).collect()
    }

    /// Whether photographs have measured the root before: else its radius is that of the scale, which tells nothing.
    fn is_known(roots: &[TracedRoot], root: usize) -> bool {
        roots[root].views.iter().any(|&views| views > 0)
    }

    fn expected(&self, roots: &[TracedRoot], root: usize, b: usize) -> f64 {
        roots[root].root.radii_mm[self.beads[root].points[b]]
    }

    /// Moves the roots across to where the photographs show them; at half as many stations as are measured.
    fn shift(&mut self, roots: &mut [TracedRoot], stride: usize, expected: bool) {
        if self.params.furthest_mm <= 0.0 {
            return;
        }
        let clutter = self.clutter(roots);
        let step_mm = 2.0 * self.params.every_mm * stride as f64;
        let one = |r: usize| -> Vec<Vec3> {
            let shifts: Vec<[f64; 4]> = self
                .stations(r, 2 * stride)
                .filter_map(|b| {
                    let radius = self.expected(roots, r, b);
                    let profiles = self.profiles(&clutter, r, b, radius);
                    let diameter = if expected && Self::is_known(roots, r) {
                        2.0 * radius
                    } else {
                        width::common(&profiles, &self.bars, None, self.params).measured?.diameter_mm
                    };
                    let tangent = self.beads[r].tangent(b)?;
                    let s = refine::shift(&profiles, &tangent, diameter, &self.bars, self.params)?;
                    Some([self.beads[r].arc_mm[b], s.x, s.y, s.z])
                })
                .collect();
            let arc = curve::chord_lengths(&roots[r].root.points_mm);
            refine::spread(&arc, &shifts, step_mm, self.params.shift_smooth_mm)
        };
        let all: Vec<Vec<Vec3>> = (0..roots.len()).into_par_iter().map(one).collect();
        for (r, shifts) in all.iter().enumerate() {
            for (p, shift) in roots[r].root.points_mm.iter_mut().zip(shifts) {
                (0..3).for_each(|d| p[d] += shift[d]);
            }
            let Beads { points, places, .. } = &mut self.beads[r];
            points.iter().zip(places).for_each(|(&k, place)| *place += shifts[k]);
        }
        self.tracks.par_iter_mut().for_each(|tracks| {
            for ((track, beads), shifts) in tracks.iter_mut().zip(&self.beads).zip(&all) {
                beads.points.iter().enumerate().for_each(|(b, &k)| track.shift(b, &shifts[k]));
            }
        });
    }

    /// Measures every root's stations and settles its radii.
    fn widths(&self, roots: &mut [TracedRoot], stride: usize, expected: bool) -> Vec<Looks> {
        let clutter = self.clutter(roots);
        let read_only: &[TracedRoot] = roots;
        let one = |r: usize| -> Vec<(f64, Station)> {
            let expected = expected && Self::is_known(read_only, r);
            self.stations(r, stride)
                .map(|b| {
                    let radius = self.expected(read_only, r, b);
                    let profiles = self.profiles(&clutter, r, b, radius);
                    let about = expected.then_some(2.0 * radius);
                    (self.beads[r].arc_mm[b], width::common(&profiles, &self.bars, about, self.params))
                })
                .collect()
        };
        let all: Vec<Vec<(f64, Station)>> = (0..roots.len()).into_par_iter().map(one).collect();
        for (root, stations) in roots.iter_mut().zip(&all) {
            settle(root, stations, self.params);
        }
        all.iter().map(|stations| stations.iter().map(|(_, s)| s.looks).sum()).collect()
    }
}

/// Carries the stations (arc position, what the photographs say) over to all points of the root. Where no photograph
/// looks unhindered the confidence is that of the nearest station where one does.
fn settle(traced: &mut TracedRoot, stations: &[(f64, Station)], params: &DiameterParams) {
    let arc = curve::chord_lengths(&traced.root.points_mm);
    let good: Vec<(f64, Measured)> = stations.iter().filter_map(|&(s, m)| m.measured.map(|m| (s, m))).collect();
    let shares: Vec<(f64, f64)> = stations.iter().filter_map(|(s, m)| Some((*s, m.looks.share()?))).collect();
    for (k, confidence) in traced.confidence.iter_mut().enumerate() {
        let near = shares.iter().min_by(|a, b| (a.0 - arc[k]).abs().total_cmp(&(b.0 - arc[k]).abs()));
        *confidence = near.map_or(0.0, |(_, share)| *share);
    }
    if good.is_empty() {
        // What a sparse round measured does not hold.
        traced.views.fill(0);
        return;
    }
    let smooth = smoothed(&good, params);
    let at = |s: f64| {
        let after = good.iter().position(|g| g.0 >= s).unwrap_or(good.len() - 1);
        let before = if good[after].0 >= s { after.saturating_sub(1) } else { after };
        let width = good[after].0 - good[before].0;
        let f = if width > 0.0 { ((s - good[before].0) / width).clamp(0.0, 1.0) } else { 0.0 };
        let sd = good[before].1.sd_mm + f * (good[after].1.sd_mm - good[before].1.sd_mm);
        let nearer = if f < 0.5 { before } else { after };
        (smooth[before] + f * (smooth[after] - smooth[before]), sd, good[nearer])
    };
    for (k, &s) in arc.iter().enumerate() {
        let (diameter, sd, (station, m)) = at(s);
        traced.root.radii_mm[k] = 0.5 * diameter;
        // Away from a measured station the diameter is a neighbour's; a taper of 1 % per mm bounds what that costs.
        traced.radius_sd_mm[k] = 0.5 * sd.hypot(0.01 * (s - station).abs() * diameter);
        traced.views[k] = if (s - station).abs() <= params.every_mm { m.views } else { 0 };
    }
}

/// The stations' diameters, outliers against the running median replaced, smoothed along the root.
fn smoothed(good: &[(f64, Measured)], params: &DiameterParams) -> Vec<f64> {
    let half = (0.25 * params.smooth_mm / params.every_mm).ceil() as usize;
    let n = good.len();
    let steady: Vec<[f64; 1]> = (0..n)
        .map(|k| {
            let mut window: Vec<f64> =
                good[k.saturating_sub(half)..(k + half + 1).min(n)].iter().map(|g| g.1.diameter_mm).collect();
            window.sort_by(f64::total_cmp);
            let middle = window[window.len() / 2];
            let mut off: Vec<f64> = window.iter().map(|d| (d - middle).abs()).collect();
            off.sort_by(f64::total_cmp);
            let limit = (3.0 * 1.4826 * off[off.len() / 2]).max(0.05 * middle);
            [good[k].1.diameter_mm.clamp(middle - limit, middle + limit)]
        })
        .collect();
    let arc: Vec<f64> = good.iter().map(|g| g.0).collect();
    curve::smooth_values(&arc, &steady, params.every_mm, params.smooth_mm).into_iter().map(|v| v[0].max(0.0)).collect()
}
