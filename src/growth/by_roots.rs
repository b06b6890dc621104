//! One day's tank frame in another's, from the roots themselves: where belts tell nothing.
//!
//! All azimuths in steps of a degree are tried: how much of the earlier roots' length lies near the later ones, within 3 mm. From the
//! best on, each place of an earlier root pulls the later day by its nearest point, fewer millimetres away in each round (iterated
//! closest points, the farthest left out). A best azimuth that another one equals, far from it, tells nothing.

use super::align::Alignment;
use super::motion::Motion;
use crate::optics::Vec3;
use crate::roots::Root;
use rayon::prelude::*;
use rstar::{PointDistance, RTree};

const STEP_DEG: f64 = 1.0;
const NEAR_MM: f64 = 3.0;
/// Distance of the places that are looked at, mm.
const PLACE_MM: f64 = 1.0;
/// Reaches of the rounds, mm.
const ROUNDS_MM: [f64; 12] = [4.0, 3.5, 3.0, 3.0, 2.5, 2.5, 2.0, 2.0, 1.5, 1.5, 1.5, 1.5];
/// Least share of the earlier roots that fits.
const FITS: f64 = 0.5;
/// Another azimuth, this far away, fits at most so much of what the best fits.
const APART_DEG: f64 = 10.0;
const RIVAL: f64 = 0.8;
/// Fewest places that tell a motion.
const FEWEST: usize = 10;
/// Length of a root that is off as a whole, mm: what counts as one observation.
const ALIKE_MM: f64 = 20.0;

/// Finds the frame of `later` in that of `reference`, an earlier day; `None` where no azimuth fits best.
pub fn align(reference: &[Root], later: &[Root]) -> Option<Alignment> {
    let (earlier, points) = (places(reference), places(later));
    if earlier.len() < 20 || points.len() < 20 {
        return None;
    }
    let tree = RTree::bulk_load(points.iter().map(|p| [p.x, p.y, p.z]).collect());
    // Places near the axis fit at any azimuth.
    let telling: Vec<Vec3> = earlier.iter().filter(|p| p.xy().norm() > 2.0 * NEAR_MM).copied().collect();
    // What lies nearer counts more: a turn by a degree or two tells.
    let fits = |motion: &Motion| {
        let near = |p: &Vec3| {
            let at: [f64; 3] = motion.apply(p).into();
            let found = tree.nearest_neighbor(at).map_or(f64::INFINITY, |q| q.distance_2(&at));
            (1.0 - found / (NEAR_MM * NEAR_MM)).max(0.0)
        };
        telling.iter().map(near).sum::<f64>() / telling.len().max(1) as f64
    };
    let steps = (360.0 / STEP_DEG) as usize;
    let turn = |k: usize| Motion::turn((k as f64 * STEP_DEG).to_radians());
    let scores: Vec<f64> = (0..steps).into_par_iter().map(|k| fits(&turn(k))).collect();
    let best = (0..steps).max_by(|&a, &b| scores[a].total_cmp(&scores[b]))?;
    let apart = |k: &usize| {
        let gap = k.abs_diff(best) as f64 * STEP_DEG;
        gap.min(360.0 - gap) > APART_DEG
    };
    let rival = (0..steps).filter(apart).map(|k| scores[k]).fold(0.0, f64::max);
    if scores[best] < FITS || rival > RIVAL * scores[best] {
        return None;
    }
    let mut motion = turn(best);
    let mut off = Vec::new();
    for reach in ROUNDS_MM {
        let (from, to): (Vec<Vec3>, Vec<Vec3>) = earlier
            .iter()
            .filter_map(|p| {
                let found = tree.nearest_neighbor(motion.apply(p).into())?;
                let found = Vec3::from(*found);
                ((found - motion.apply(p)).norm() < reach).then_some((*p, found))
            })
            .unzip();
        if from.len() < FEWEST {
            return None;
        }
        motion = Motion::nearest(&from, &to)?;
        off = from.iter().zip(&to).map(|(p, q)| (motion.apply(p) - q).norm_squared()).collect();
    }
    // Along a root its nearest point gives way: two of three coordinates count.
    let variance = off.iter().sum::<f64>() / off.len() as f64 / 2.0;
    let alike = (ALIKE_MM / PLACE_MM).min(earlier.len() as f64 / 4.0);
    let count = off.len() as f64 / alike;
    let far = (earlier.iter().map(|p| p.x * p.x + p.y * p.y).sum::<f64>() / earlier.len() as f64).sqrt();
    Some(Alignment {
        motion: motion.inverse(),
        by_belts: false,
        agreement: off.len() as f64 / earlier.len() as f64,
        azimuth_sd_deg: ((variance / count).sqrt() / far.max(1.0)).to_degrees(),
        place_sd_mm: (3.0 * variance / count).sqrt(),
    })
}

fn places(roots: &[Root]) -> Vec<Vec3> {
    let of = |root: &Root| {
        let points: Vec<[f64; 3]> = crate::roots::curve::resample(&root.points_mm, PLACE_MM);
        points.into_iter().map(Vec3::from).collect::<Vec<_>>()
    };
    roots.iter().filter(|r| r.points_mm.len() > 1).flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Roots that wind down at eight azimuths, each as long as `grown` lets it be.
    fn roots(grown: f64, count: usize) -> Vec<Root> {
        let one = |k: usize| {
            let turn = k as f64 * 0.9 + (k * k) as f64 * 0.13;
            let steps = ((20.0 + 3.0 * k as f64) * grown) as usize;
            let at = |s: usize| {
                let (s, bend) = (s as f64, turn + 0.02 * (k as f64 - 3.0) * s as f64);
                [0.6 * s * bend.cos(), 0.6 * s * bend.sin(), 20.0 + 4.0 * k as f64 + 0.7 * s]
            };
            let points_mm: Vec<[f64; 3]> = (0..=steps).map(at).collect();
            Root { id: k as i64, parent: -1, order: 0, radii_mm: vec![0.5; points_mm.len()], points_mm }
        };
        (0..count).map(one).collect()
    }

    #[test]
    fn roots_tell_the_frame_and_how_well() {
        let truth = Motion::small(&Vec3::new(0.003, -0.002, 0.0), &Vec3::new(0.4, 0.3, -0.3)).after(&Motion::turn(2.3));
        // The later day in its own frame.
        let later: Vec<Root> = roots(1.4, 8).iter().map(|r| truth.inverse().root(r)).collect();
        let found = align(&roots(1.0, 8), &later).unwrap();
        let off = found.motion.after(&truth.inverse());
        assert!(
            off.azimuth().to_degrees().abs() < 0.3
                && off.apply(&Vec3::new(20.0, 0.0, 40.0)).metric_distance(&Vec3::new(20.0, 0.0, 40.0)) < 0.3
        );
        assert!(!found.by_belts && found.agreement > 0.9 && found.place_sd_mm < 0.5, "{found:?}");
    }

    #[test]
    fn what_looks_alike_all_around_tells_nothing() {
        let straight = Root {
            id: 0,
            parent: -1,
            order: 0,
            points_mm: (0..60).map(|k| [0.0, 0.0, f64::from(k)]).collect(),
            radii_mm: vec![0.5; 60],
        };
        assert!(align(std::slice::from_ref(&straight), std::slice::from_ref(&straight)).is_none());
        assert!(align(&roots(1.0, 8), &[]).is_none());
    }
}
