//! Precision, recall and F1 of a reconstruction at several tolerances.
//!
//! ```text
//! precision(t) = share of the reconstructed points whose distance to the true centrelines is <= t
//! recall(t)    = share of the true points with a reconstructed point within t
//! F1(t)        = their harmonic mean, 0 where both are 0
//! rms          = rms distance of the reconstructed points within 2 mm of the truth
//! length bias  = reconstructed / true length - 1, where centrelines are given
//! ```
//!
//! Only points inside the [`Region`] are counted, but a reconstructed point outside it may still explain a
//! true one inside, and the other way round. Where the cameras came from photographs alone, the turn about
//! the tank's axis is free: [`best_turn`] looks for the one that brings most points within 1 mm.

use super::points::{Found, Region, STEP_MM, sampled};
use crate::error::{Error, Result};
use crate::optics::Tank;
use crate::roots::Root;
use rayon::prelude::*;
use rstar::RTree;
use serde::{Deserialize, Serialize};

/// How to score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ScoreParams {
    /// Upper limit of the region, mm; not given: 16 mm under the water level.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub z_min_mm: Option<f64>,
    /// Lower limit of the region, mm.
    pub z_max_mm: f64,
    /// Tolerances, mm.
    pub tolerances_mm: Vec<f64>,
    /// Turn the reconstruction about the tank's axis to where it fits best.
    pub free_azimuth: bool,
}

impl Default for ScoreParams {
    fn default() -> Self {
        Self { z_min_mm: None, z_max_mm: 178.0, tolerances_mm: vec![0.5, 1.0, 2.0], free_azimuth: false }
    }
}

impl ScoreParams {
    /// The region in which points count.
    ///
    /// # Errors
    /// Where the limits or a tolerance are unusable.
    pub fn region(&self, tank: &Tank) -> Result<Region> {
        let mut region = Region::of_tank(tank, self.z_max_mm);
        if let Some(z) = self.z_min_mm {
            region.z_min_mm = z;
        }
        if region.z_min_mm.partial_cmp(&region.z_max_mm) != Some(std::cmp::Ordering::Less) {
            return Err(Error::usage(format!(
                "the scored region from z = {} to {} mm is empty",
                region.z_min_mm, region.z_max_mm
            ))
            .help("give z_min < z_max; by default z_min lies 16 mm under the water level"));
        }
        if let Some(t) = self.tolerances_mm.iter().find(|t| !(t.is_finite() && **t > 0.0)) {
            return Err(Error::usage(format!("tolerance {t} mm")).help("give positive tolerances in mm"));
        }
        Ok(region)
    }
}

/// Precision, recall and F1 at one tolerance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AtTolerance {
    /// Tolerance, mm.
    pub tolerance_mm: f64,
    /// Share of the reconstructed points near the truth, 0..1.
    pub precision: f64,
    /// Share of the truth near reconstructed points, 0..1.
    pub recall: f64,
    /// Harmonic mean of the two, 0..1.
    pub f1: f64,
}

/// A reconstruction's score.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// Turn about z that was applied to the reconstruction, degrees; none unless asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub turned_deg: Option<f64>,
    /// Length of the true roots in the region, mm.
    pub true_length_mm: f64,
    /// Reconstructed points in the region.
    pub points: usize,
    /// In the order of the tolerances asked for.
    pub at: Vec<AtTolerance>,
    /// Rms distance to the truth of the points within 2 mm of it, mm; none where there are none.
    pub rms_mm: Option<f64>,
    /// Reconstructed over true length, less 1; none for bare points.
    pub length_bias: Option<f64>,
}

impl Score {
    /// F1 at a tolerance that was asked for.
    pub fn f1(&self, tolerance_mm: f64) -> Option<f64> {
        self.at.iter().find(|a| a.tolerance_mm == tolerance_mm).map(|a| a.f1)
    }
}

/// Scores a reconstruction against the true roots.
///
/// # Errors
/// Where the region or a tolerance is unusable, a coordinate is not finite, or no true root lies in the region.
pub fn score(truth: &[Root], tank: &Tank, found: Found<'_>, params: &ScoreParams) -> Result<Score> {
    let region = params.region(tank)?;
    let truth = sampled(truth);
    let mut points = found.points();
    if points.iter().chain(&truth).flatten().any(|x| !x.is_finite()) {
        return Err(Error::failed("a point's coordinate is not finite").help("look for NaN in the points' table"));
    }
    let true_tree = RTree::bulk_load(truth.clone());
    let mut turned_deg = None;
    if params.free_azimuth && !points.is_empty() {
        let turn = best_turn(&points, &true_tree);
        points = turned(&points, turn);
        turned_deg = Some(turn);
    }
    let true_inside: Vec<_> = truth.into_iter().filter(|p| region.holds(p)).collect();
    if true_inside.is_empty() {
        return Err(Error::failed("no true root lies in the scored region").help("look at z_min and z_max"));
    }
    let inside: Vec<_> = points.iter().copied().filter(|p| region.holds(p)).collect();
    let to_truth = distances(&inside, &true_tree);
    let to_found = distances(&true_inside, &RTree::bulk_load(points));
    let share = |d: &[f64], t: f64| {
        if d.is_empty() { 0.0 } else { d.iter().filter(|&&d| d <= t).count() as f64 / d.len() as f64 }
    };
    // Nothing found inside: nothing is right, even if points outside lie near the truth.
    let recall = |t: f64| if inside.is_empty() { 0.0 } else { share(&to_found, t) };
    let at = params
        .tolerances_mm
        .iter()
        .map(|&t| {
            let (p, r) = (share(&to_truth, t), recall(t));
            let f1 = if p + r > 0.0 { 2.0 * p * r / (p + r) } else { 0.0 };
            AtTolerance { tolerance_mm: t, precision: p, recall: r, f1 }
        })
        .collect();
    let near: Vec<f64> = to_truth.iter().copied().filter(|&d| d <= 2.0).collect();
    let rms_mm = (!near.is_empty()).then(|| (near.iter().map(|d| d * d).sum::<f64>() / near.len() as f64).sqrt());
    let length_bias = match found {
        Found::Lines(_) | Found::Roots(_) => Some(inside.len() as f64 / true_inside.len() as f64 - 1.0),
        Found::Points(_) => None,
    };
    Ok(Score {
        turned_deg,
        true_length_mm: true_inside.len() as f64 * STEP_MM,
        points: inside.len(),
        at,
        rms_mm,
        length_bias,
    })
}

/// Distance of each point to the nearest of the tree's; infinite for an empty tree.
pub(super) fn distances(points: &[[f64; 3]], tree: &RTree<[f64; 3]>) -> Vec<f64> {
    let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]) * (a[k] - b[k])).sum::<f64>().sqrt();
    points.par_iter().map(|p| tree.nearest_neighbor(*p).map_or(f64::INFINITY, |q| distance(p, q))).collect()
}

/// Points turned about the tank's axis.
pub fn turned(points: &[[f64; 3]], degrees: f64) -> Vec<[f64; 3]> {
    let (s, c) = degrees.to_radians().sin_cos();
    points.iter().map(|p| [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]).collect()
}

/// Turn about z, degrees, that brings most of (up to about 2000 of) the points within 1 mm of the truth: steps of
/// 0.5° all around, then 0.1° and 0.02° about the best; the first of equals wins.
pub fn best_turn(points: &[[f64; 3]], truth: &RTree<[f64; 3]>) -> f64 {
    let some: Vec<[f64; 3]> = points.iter().copied().step_by((points.len() / 2000).max(1)).collect();
    let fit = |degrees: f64| {
        turned(&some, degrees).iter().filter(|p| truth.locate_within_distance(**p, 1.0).next().is_some()).count()
    };
    let best_of = |angles: Vec<f64>| {
        let fits: Vec<usize> = angles.par_iter().map(|&a| fit(a)).collect();
        let mut best = 0;
        for (i, &f) in fits.iter().enumerate() {
            if f > fits[best] {
                best = i;
            }
        }
        angles[best]
    };
    let mut best = best_of((0..720).map(|i| 0.5 * f64::from(i)).collect());
    for step in [0.1, 0.02] {
        best = best_of((-6..=6).map(|i| best + step * f64::from(i)).collect());
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn tank() -> Tank {
        Tank {
            radius_mm: 50.0,
            height_mm: 200.0,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    fn line(x: f64, y: f64, from: f64, to: f64) -> Root {
        let n = 1 + ((to - from) / 0.4).round() as usize;
        let points_mm: Vec<[f64; 3]> = (0..n).map(|i| [x, y, from + (to - from) * i as f64 / (n - 1) as f64]).collect();
        Root { id: 0, parent: -1, order: 0, radii_mm: vec![0.5; n], points_mm }
    }

    #[test]
    fn the_truth_itself_is_perfect() {
        let truth = [line(3.0, 0.0, 5.0, 120.0), line(0.0, 20.0, 30.0, 160.0)];
        let lines: Vec<_> = truth.iter().map(|r| r.points_mm.clone()).collect();
        let s = score(&truth, &tank(), Found::Lines(&lines), &ScoreParams::default()).unwrap();
        assert_eq!((s.f1(0.5), s.length_bias, s.rms_mm), (Some(1.0), Some(0.0), Some(0.0)));
    }

    #[test]
    fn half_the_truth_at_an_offset() {
        let truth = [line(3.0, 0.0, 30.0, 130.0)];
        let found = [line(3.8, 0.0, 30.0, 80.0).points_mm];
        let s = score(&truth, &tank(), Found::Lines(&found), &ScoreParams::default()).unwrap();
        let (half, one) = (s.at[0], s.at[1]);
        assert_eq!((half.precision, half.recall, half.f1), (0.0, 0.0, 0.0));
        assert_eq!(one.precision, 1.0);
        assert!((one.recall - 0.505).abs() < 0.01, "{}", one.recall);
        assert!((s.rms_mm.unwrap() - 0.8).abs() < 1e-3);
        assert!((s.length_bias.unwrap() + 0.5).abs() < 1e-2);
    }

    #[test]
    fn a_free_turn_is_found() {
        let truth = [line(3.0, 0.0, 30.0, 130.0), line(-10.0, 22.0, 30.0, 130.0), line(25.0, 20.0, 40.0, 150.0)];
        let lines: Vec<_> = truth.iter().map(|r| turned(&r.points_mm, -77.3)).collect();
        let params = ScoreParams { free_azimuth: true, ..Default::default() };
        let s = score(&truth, &tank(), Found::Lines(&lines), &params).unwrap();
        assert_eq!(s.f1(1.0), Some(1.0));
    }

    #[test]
    fn nothing_found_scores_zero() {
        let truth = [line(3.0, 0.0, 30.0, 130.0)];
        let s = score(&truth, &tank(), Found::Points(&[]), &ScoreParams::default()).unwrap();
        assert_eq!((s.f1(1.0), s.points, s.rms_mm), (Some(0.0), 0, None));
    }
}
