//! Where a reconstruction is right and where it fails: by diameter, depth and distance to the wall, at tips and
//! branch points, and at its worst.
//!
//! All distances are to the other side's points of the whole tank; all counts are of points inside the region
//! of [`ScoreParams`]. A point is right within [`NEAR_MM`].
//!
//! ```text
//! Hausdorff-95 = the greater of the 95th percentiles of the distances found -> true and true -> found
//! tips         = last points of the roots, branch points = first points of laterals: each found one is
//!                given to at most one true one and the other way round, nearest pairs first, within 2 mm
//! diameter bias = median of (found / true diameter) - 1 over found points within 1 mm of the truth
//! ```

use super::points::{Found, Region, sampled, sampled_with_radii};
use super::score::{ScoreParams, distances, turned};
use crate::error::Result;
use crate::optics::Tank;
use crate::roots::Root;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use serde::{Deserialize, Serialize};

/// A point within this of the other side is right, mm.
const NEAR_MM: f64 = 1.0;
/// Tips and branch points within this belong together, mm.
const END_MM: f64 = 2.0;
const DIAMETERS_MM: [f64; 7] = [0.0, 0.4, 0.6, 0.8, 1.0, 1.5, f64::INFINITY];
const WALL_MM: [f64; 6] = [1.0, 5.0, 10.0, 20.0, 40.0, f64::INFINITY];
const DEPTH_STEP_MM: f64 = 20.0;

/// Part of the roots, from one bound to another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Class {
    /// Lower bound, mm (inclusive).
    pub from_mm: f64,
    /// Upper bound, mm (exclusive); none for the last, open class.
    pub to_mm: Option<f64>,
    /// True length in the class, mm.
    pub true_length_mm: f64,
    /// Share of it that was found, 0..1; none where there is none.
    pub recall: Option<f64>,
    /// Share of the found points in the class that are right, 0..1; none where there are none, and by diameter.
    pub precision: Option<f64>,
    /// Median relative error of the diameters; only by diameter, where the reconstruction has some.
    pub diameter_bias: Option<f64>,
}

/// Points that belong to each other one to one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Matched {
    /// True points in the region.
    pub truth: usize,
    /// Found points in the region.
    pub found: usize,
    /// Pairs within 2 mm.
    pub matched: usize,
}

impl Matched {
    /// Share of the found points that are right; 0 where nothing was found.
    pub fn precision(&self) -> f64 {
        if self.found > 0 { self.matched as f64 / self.found as f64 } else { 0.0 }
    }

    /// Share of the true points that were found; 0 where there are none.
    pub fn recall(&self) -> f64 {
        if self.truth > 0 { self.matched as f64 / self.truth as f64 } else { 0.0 }
    }
}

/// A reconstruction in detail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Detail {
    /// Hausdorff-95, mm; none where nothing was found.
    pub hausdorff95_mm: Option<f64>,
    /// By true diameter.
    pub by_diameter: Vec<Class>,
    /// By depth z.
    pub by_depth: Vec<Class>,
    /// By distance to the inner wall.
    pub by_wall_distance: Vec<Class>,
    /// Tips; only for roots.
    pub tips: Option<Matched>,
    /// Branch points; only for roots.
    pub branch_points: Option<Matched>,
}

/// Truth and reconstruction point by point, for pictures.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Hits {
    /// True points that were found.
    pub hit: Vec<[f64; 3]>,
    /// True points that were missed.
    pub missed: Vec<[f64; 3]>,
    /// Found points that are none of the truth.
    pub spurious: Vec<[f64; 3]>,
}

/// One side's points inside the region with what is known of each.
struct Side {
    points: Vec<[f64; 3]>,
    distances: Vec<f64>,
}

impl Side {
    fn new(points: &[[f64; 3]], other: &[[f64; 3]], region: &Region) -> Self {
        let points: Vec<_> = points.iter().copied().filter(|p| region.holds(p)).collect();
        let distances = distances(&points, &RTree::bulk_load(other.to_vec()));
        Self { points, distances }
    }

    /// 95th percentile of the distances; none of no points.
    fn percentile95(&self) -> Option<f64> {
        let mut sorted = self.distances.clone();
        sorted.sort_by(f64::total_cmp);
        (!sorted.is_empty()).then(|| sorted[((sorted.len() as f64 * 0.95).ceil() as usize).clamp(1, sorted.len()) - 1])
    }

    /// Number of points whose measure lies in [from, to), and the share of them that are right.
    fn share(&self, from: f64, to: f64, measure: impl Fn(usize) -> f64) -> (usize, Option<f64>) {
        let inside: Vec<usize> = (0..self.points.len()).filter(|&i| (from..to).contains(&measure(i))).collect();
        let right = inside.iter().filter(|&&i| self.distances[i] <= NEAR_MM).count();
        (inside.len(), (!inside.is_empty()).then(|| right as f64 / inside.len() as f64))
    }
}

/// Looks at a reconstruction in detail; `turned_deg` is the turn that [`Score`](super::Score) reports.
///
/// # Errors
/// Where the region or a tolerance is unusable.
pub fn detail(
    truth: &[Root],
    tank: &Tank,
    found: Found<'_>,
    params: &ScoreParams,
    turned_deg: Option<f64>,
) -> Result<Detail> {
    let region = params.region(tank)?;
    let turn = turned_deg.unwrap_or(0.0);
    let (true_points, true_radii): (Vec<_>, Vec<_>) = sampled_with_radii(truth).into_iter().unzip();
    let found_points = turned(&found.points(), turn);
    let true_side = Side::new(&true_points, &found_points, &region);
    let found_side = Side::new(&found_points, &true_points, &region);
    let inside_radii: Vec<f64> =
        true_points.iter().zip(&true_radii).filter(|(p, _)| region.holds(p)).map(|(_, r)| *r).collect();
    let ratios = match found {
        Found::Roots(roots) => diameter_ratios(roots, turn, &true_points, &true_radii, &region),
        _ => Vec::new(),
    };
    let class = |from: f64, to: f64, length: usize, recall, precision, diameter_bias| Class {
        from_mm: from,
        to_mm: to.is_finite().then_some(to),
        true_length_mm: length as f64 * super::STEP_MM,
        recall,
        precision,
        diameter_bias,
    };
    let by_diameter = DIAMETERS_MM
        .windows(2)
        .map(|w| {
            let (length, recall) = true_side.share(w[0], w[1], |i| 2.0 * inside_radii[i]);
            let mut here: Vec<f64> =
                ratios.iter().filter(|(d, _)| (w[0]..w[1]).contains(d)).map(|(_, ratio)| ratio - 1.0).collect();
            here.sort_by(f64::total_cmp);
            class(w[0], w[1], length, recall, None, here.get(here.len() / 2).copied())
        })
        .collect();
    let by = |bounds: &[f64], measure: &dyn Fn(&[f64; 3]) -> f64| -> Vec<Class> {
        bounds
            .windows(2)
            .map(|w| {
                let (length, recall) = true_side.share(w[0], w[1], |i| measure(&true_side.points[i]));
                let (_, precision) = found_side.share(w[0], w[1], |i| measure(&found_side.points[i]));
                class(w[0], w[1], length, recall, precision, None)
            })
            .collect()
    };
    let first = (region.z_min_mm / DEPTH_STEP_MM).floor() as i64;
    let last = (region.z_max_mm / DEPTH_STEP_MM).ceil() as i64;
    let depths: Vec<f64> = (first..=last).map(|i| i as f64 * DEPTH_STEP_MM).collect();
    let inner = tank.inner_radius_mm();
    let ends = |pick: fn(&Root) -> Option<[f64; 3]>| match found {
        Found::Roots(roots) => {
            let at = |roots: &[Root], turn| {
                let mut points = turned(&roots.iter().filter_map(pick).collect::<Vec<_>>(), turn);
                points.retain(|p| region.holds(p));
                points
            };
            Some(matched(&at(truth, 0.0), &at(roots, turn)))
        }
        _ => None,
    };
    Ok(Detail {
        hausdorff95_mm: found_side.percentile95().and_then(|a| true_side.percentile95().map(|b| a.max(b))),
        by_diameter,
        by_depth: by(&depths, &|p| p[2]),
        by_wall_distance: by(&WALL_MM, &|p| inner - p[0].hypot(p[1])),
        tips: ends(|r| r.points_mm.last().copied()),
        branch_points: ends(|r| r.points_mm.first().copied().filter(|_| r.parent >= 0)),
    })
}

/// Sorts the points of truth and reconstruction inside the region into hits, misses and spurious ones.
///
/// # Errors
/// Where the region or a tolerance is unusable.
pub fn hits(
    truth: &[Root],
    tank: &Tank,
    found: Found<'_>,
    params: &ScoreParams,
    turned_deg: Option<f64>,
) -> Result<Hits> {
    let region = params.region(tank)?;
    let true_points = sampled(truth);
    let found_points = turned(&found.points(), turned_deg.unwrap_or(0.0));
    let mut hits = Hits::default();
    let true_side = Side::new(&true_points, &found_points, &region);
    for (p, &d) in true_side.points.iter().zip(&true_side.distances) {
        if d <= NEAR_MM { hits.hit.push(*p) } else { hits.missed.push(*p) }
    }
    let found_side = Side::new(&found_points, &true_points, &region);
    hits.spurious =
        found_side.points.iter().zip(&found_side.distances).filter(|(_, d)| **d > NEAR_MM).map(|(p, _)| *p).collect();
    Ok(hits)
}

/// True diameter, and found over true diameter, of the found points within [`NEAR_MM`] of the truth.
fn diameter_ratios(
    found: &[Root],
    turn: f64,
    true_points: &[[f64; 3]],
    true_radii: &[f64],
    region: &Region,
) -> Vec<(f64, f64)> {
    let tree = RTree::bulk_load(
        true_points.iter().zip(true_radii).map(|(p, r)| GeomWithData::new(*p, *r)).collect::<Vec<_>>(),
    );
    let (points, radii): (Vec<_>, Vec<_>) = sampled_with_radii(found).into_iter().unzip();
    turned(&points, turn)
        .iter()
        .zip(radii)
        .filter(|(p, _)| region.holds(p))
        .filter_map(|(p, radius)| {
            let near = tree.nearest_neighbor(*p)?;
            let squared: f64 = (0..3).map(|k| (near.geom()[k] - p[k]).powi(2)).sum();
            (squared <= NEAR_MM * NEAR_MM).then(|| (2.0 * near.data, radius / near.data))
        })
        .collect()
}

/// Pairs nearest points first, each at most once.
fn matched(truth: &[[f64; 3]], found: &[[f64; 3]]) -> Matched {
    let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
    for (i, p) in truth.iter().enumerate() {
        for (j, q) in found.iter().enumerate() {
            let d = (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
            if d <= END_MM {
                pairs.push((d, i, j));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut used_true, mut used_found) = (vec![false; truth.len()], vec![false; found.len()]);
    let mut count = 0;
    for (_, i, j) in pairs {
        if !used_true[i] && !used_found[j] {
            used_true[i] = true;
            used_found[j] = true;
            count += 1;
        }
    }
    Matched { truth: truth.len(), found: found.len(), matched: count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use crate::simulation::{GrowthParams, grow};

    fn tank() -> Tank {
        Tank {
            radius_mm: 60.0,
            height_mm: 200.0,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    #[test]
    fn the_truth_is_perfect_in_every_class() {
        let truth = grow(&GrowthParams::default(), &tank(), 1).unwrap();
        let d = detail(&truth, &tank(), Found::Roots(&truth), &ScoreParams::default(), None).unwrap();
        assert_eq!(d.hausdorff95_mm, Some(0.0));
        for class in d.by_depth.iter().chain(&d.by_wall_distance).chain(&d.by_diameter) {
            assert!(class.recall.is_none_or(|r| r == 1.0) && class.precision.is_none_or(|p| p == 1.0));
            assert!(class.diameter_bias.is_none_or(|b| b.abs() < 1e-9));
        }
        let (tips, branches) = (d.tips.unwrap(), d.branch_points.unwrap());
        assert!(tips.truth > 30 && tips.matched == tips.truth && branches.matched == branches.found);
        let length: f64 = d.by_diameter.iter().map(|c| c.true_length_mm).sum();
        assert!((length - d.by_depth.iter().map(|c| c.true_length_mm).sum::<f64>()).abs() < 1e-9);
    }

    #[test]
    fn faults_show_where_they_are() {
        let truth = grow(&GrowthParams::default(), &tank(), 1).unwrap();
        // Without what lies below 100 mm, and thicker by a tenth.
        let found: Vec<Root> = truth
            .iter()
            .map(|r| {
                let keep = r.points_mm.iter().position(|p| p[2] > 100.0).unwrap_or(r.points_mm.len());
                Root {
                    points_mm: r.points_mm[..keep].to_vec(),
                    radii_mm: r.radii_mm[..keep].iter().map(|x| 1.1 * x).collect(),
                    ..r.clone()
                }
            })
            .collect();
        let d = detail(&truth, &tank(), Found::Roots(&found), &ScoreParams::default(), None).unwrap();
        let at = |z: f64| d.by_depth.iter().find(|c| c.from_mm == z).unwrap().recall.unwrap();
        assert!(at(40.0) > 0.9 && at(140.0) < 0.1, "{} {}", at(40.0), at(140.0));
        assert!(d.hausdorff95_mm.unwrap() > 10.0);
        for bias in d.by_diameter.iter().filter_map(|c| c.diameter_bias) {
            assert!((bias - 0.1).abs() < 0.03, "{bias}");
        }
        let hits = hits(&truth, &tank(), Found::Roots(&found), &ScoreParams::default(), None).unwrap();
        assert!(hits.spurious.is_empty() && hits.missed.iter().all(|p| p[2] > 40.0) && !hits.hit.is_empty());
    }
}
