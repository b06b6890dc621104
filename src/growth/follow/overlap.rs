//! How much of an earlier root lies on a later one, and runs with it.

use crate::optics::Vec3;
use crate::roots::Root;
use rstar::primitives::GeomWithData;
use rstar::{PointDistance, RTree};

/// Distance of the places that are looked at along an earlier root, mm.
const STEP_MM: f64 = 0.5;
/// Roots run together where their directions differ by less than 60 degrees.
const TOGETHER: f64 = 0.5;
/// Length over which a direction is taken, mm.
const DIRECTION_MM: f64 = 3.0;

/// An earlier root on a later one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Overlap {
    /// Place of the earlier root in its list.
    pub earlier: usize,
    /// Place of the later root.
    pub later: usize,
    /// Length of the earlier root that lies on the later, mm.
    pub length_mm: f64,
    /// Its share of the earlier root.
    pub share: f64,
}

impl Overlap {
    /// By what one pair goes before another.
    pub(super) fn weight(&self) -> f64 {
        self.length_mm * self.share
    }
}

/// A place along a root with the root's direction there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub point_mm: Vec3,
    pub direction: Vec3,
    /// Arc length from the base, mm.
    pub arc_mm: f64,
}

/// Places along a root, [`STEP_MM`] apart at most, base and tip among them.
pub(super) fn places(root: &Root) -> Vec<Place> {
    let points: Vec<Vec3> = root.points_mm.iter().map(|p| Vec3::from(*p)).collect();
    let (mut places, mut arc_mm) = (Vec::new(), 0.0);
    for pair in points.windows(2) {
        let way = pair[1] - pair[0];
        let steps = (way.norm() / STEP_MM).ceil().max(1.0);
        for k in 0..steps as usize {
            let share = k as f64 / steps;
            places.push((pair[0] + way * share, arc_mm + way.norm() * share));
        }
        arc_mm += way.norm();
    }
    places.extend(points.last().map(|p| (*p, arc_mm)));
    let reach = (DIRECTION_MM / 2.0 / STEP_MM) as usize;
    let direction = |k: usize| {
        let (from, to) = (places[k.saturating_sub(reach)].0, places[(k + reach).min(places.len() - 1)].0);
        (to - from).try_normalize(1e-9).unwrap_or_else(Vec3::z)
    };
    let of = |(k, (point_mm, arc_mm)): (usize, &(Vec3, f64))| Place {
        point_mm: *point_mm,
        direction: direction(k),
        arc_mm: *arc_mm,
    };
    places.iter().enumerate().map(of).collect()
}

/// All pairs of which any length lies together.
pub(super) fn overlaps(earlier: &[&Root], later: &[Root], within_mm: f64) -> Vec<Overlap> {
    let later_places: Vec<Vec<Place>> = later.iter().map(places).collect();
    let entries = later_places.iter().enumerate().flat_map(|(root, places)| {
        places
            .iter()
            .enumerate()
            .map(move |(k, p)| GeomWithData::new([p.point_mm.x, p.point_mm.y, p.point_mm.z], (root, k)))
    });
    let tree = RTree::bulk_load(entries.collect());
    let mut all = Vec::new();
    for (n, root) in earlier.iter().enumerate() {
        let own = places(root);
        let mut counts = vec![0usize; later.len()];
        let mut nearest: Vec<(f64, usize)> = vec![(f64::INFINITY, 0); later.len()];
        for place in &own {
            let at: [f64; 3] = place.point_mm.into();
            nearest.iter_mut().for_each(|n| *n = (f64::INFINITY, 0));
            for found in tree.locate_within_distance(at, within_mm * within_mm) {
                let (other, k) = found.data;
                let distance = found.geom().distance_2(&at);
                if distance < nearest[other].0 {
                    nearest[other] = (distance, k);
                }
            }
            for (other, (distance, k)) in nearest.iter().enumerate() {
                let together =
                    distance.is_finite() && later_places[other][*k].direction.dot(&place.direction) > TOGETHER;
                counts[other] += usize::from(together);
            }
        }
        let length_mm = own.last().map_or(0.0, |p| p.arc_mm);
        for (other, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let share = count as f64 / own.len() as f64;
            all.push(Overlap { earlier: n, later: other, length_mm: share * length_mm, share });
        }
    }
    all
}
