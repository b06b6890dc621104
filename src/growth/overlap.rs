//! How much of one root lies on another, and runs with it.

use crate::optics::Vec3;
use crate::roots::Root;
use rstar::primitives::GeomWithData;
use rstar::{PointDistance, RTree};

/// Distance of the places that are looked at along a root, mm.
const STEP_MM: f64 = 0.5;
/// Roots run together where their directions differ by less than 60 degrees.
const TOGETHER: f64 = 0.5;
/// Length over which a direction is taken, mm.
const DIRECTION_MM: f64 = 3.0;

/// One root, the earlier, on another.
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

/// All places of the roots of a day, to ask what lies where.
pub(super) struct Known {
    /// Of each root.
    places: Vec<Vec<Place>>,
    tree: RTree<GeomWithData<[f64; 3], (usize, usize)>>,
    within_mm: f64,
}

/// A root that runs together with a place: its number in the list, the distance squared, mm², and the arc position there, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Beside {
    pub root: usize,
    pub distance_2: f64,
    pub arc_mm: f64,
}

impl Known {
    /// The roots, asked within a distance.
    pub(super) fn of<'a>(roots: impl Iterator<Item = &'a Root>, within_mm: f64) -> Self {
        let places: Vec<Vec<Place>> = roots.map(places).collect();
        let entry = |root: usize, k: usize, p: &Place| GeomWithData::new(p.point_mm.into(), (root, k));
        let all = places.iter().enumerate().flat_map(|(n, of)| of.iter().enumerate().map(move |(k, p)| entry(n, k, p)));
        let tree = RTree::bulk_load(all.collect());
        Self { places, tree, within_mm }
    }

    /// How many roots there are.
    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Every root that runs with `direction`, either way where `any_way`, at a point: by its nearest place that does; the nearest root first.
    pub(super) fn beside(&self, point_mm: &Vec3, direction: &Vec3, any_way: bool) -> Vec<Beside> {
        let at: [f64; 3] = (*point_mm).into();
        let mut all: Vec<Beside> = Vec::new();
        for found in self.tree.locate_within_distance(at, self.within_mm * self.within_mm) {
            let (root, k) = found.data;
            let place = &self.places[root][k];
            let cosine = place.direction.dot(direction);
            if (if any_way { cosine.abs() } else { cosine }) > TOGETHER {
                all.push(Beside { root, distance_2: found.geom().distance_2(&at), arc_mm: place.arc_mm });
            }
        }
        all.sort_by(|a, b| {
            a.distance_2.total_cmp(&b.distance_2).then(a.root.cmp(&b.root)).then(a.arc_mm.total_cmp(&b.arc_mm))
        });
        let mut nearest: Vec<Beside> = Vec::new();
        for one in all {
            if !nearest.iter().any(|known| known.root == one.root) {
                nearest.push(one);
            }
        }
        nearest
    }
}

/// All pairs of which any length lies together; roots that run against each other count where `any_way`.
pub(super) fn overlaps(earlier: &[&Root], later: &[&Root], within_mm: f64, any_way: bool) -> Vec<Overlap> {
    let known = Known::of(later.iter().copied(), within_mm);
    let mut all = Vec::new();
    for (n, root) in earlier.iter().enumerate() {
        let own = places(root);
        let mut counts = vec![0usize; later.len()];
        for place in &own {
            known.beside(&place.point_mm, &place.direction, any_way).iter().for_each(|b| counts[b.root] += 1);
        }
        let length_mm = own.last().map_or(0.0, |p| p.arc_mm);
        for (other, &count) in counts.iter().enumerate().filter(|(_, count)| **count > 0) {
            let share = count as f64 / own.len() as f64;
            all.push(Overlap { earlier: n, later: other, length_mm: share * length_mm, share });
        }
    }
    all
}
