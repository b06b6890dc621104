//! Next to the wall, the water surface, the floor and the belts, where mirrored and half-seen light could raise roots
//! that are none: how much of the water there is out of sight, and how right the reconstruction is.
//!
//! A place of the water belongs to the first of [`Place::ALL`] that it lies in.

use super::points::{STEP_MM, sampled};
use super::score::{distances, turned};
use crate::optics::Tank;
use crate::roots::Root;
use crate::volume::Grid;
use ndarray::ArrayView3;
use rstar::RTree;
use serde::{Deserialize, Serialize};

/// Width of the bands, mm.
pub const BAND_MM: f64 = 3.0;
/// A point within this of the other side is right, mm.
const NEAR_MM: f64 = 1.0;

/// Part of the water.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Place {
    /// Level with a belt: in sight over or under it at best.
    Belt,
    /// Within [`BAND_MM`] under the water surface.
    Surface,
    /// Within [`BAND_MM`] over the inner floor.
    Floor,
    /// Within [`BAND_MM`] of the inner wall.
    Wall,
    /// All other water.
    Elsewhere,
}

impl Place {
    /// All places, the first to be asked first.
    pub const ALL: [Self; 5] = [Self::Belt, Self::Surface, Self::Floor, Self::Wall, Self::Elsewhere];

    /// Where a point (tank frame, mm) lies; `None` outside the water.
    pub fn of(tank: &Tank, [x, y, z]: [f64; 3]) -> Option<Self> {
        let (to_wall, to_floor, to_surface) =
            (tank.inner_radius_mm() - x.hypot(y), tank.floor_mm() - z, z - tank.water_level_mm);
        if !(to_wall >= 0.0 && to_floor >= 0.0 && to_surface >= 0.0) {
            return None;
        }
        Some(if !tank.is_clear(z) {
            Self::Belt
        } else if to_surface < BAND_MM {
            Self::Surface
        } else if to_floor < BAND_MM {
            Self::Floor
        } else if to_wall < BAND_MM {
            Self::Wall
        } else {
            Self::Elsewhere
        })
    }
}

/// What the views see of a part of the water.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sight {
    /// The part.
    pub place: Place,
    /// Voxels of the grid in it.
    pub voxels: usize,
    /// Voxels of these that too few views see: no root can be found in them.
    pub unseen: usize,
    /// Length of the true roots in the grid there, mm; none where no truth is known.
    pub true_length_mm: Option<f64>,
    /// Length of these in unseen voxels, mm: what of recall is lost by not seeing.
    pub unseen_length_mm: Option<f64>,
}

/// How right a reconstruction is in a part of the water.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// The part.
    pub place: Place,
    /// Length of the true roots in it, mm.
    pub true_length_mm: f64,
    /// Share of it within 1 mm of a reconstructed point, 0..1; none of none.
    pub recall: Option<f64>,
    /// Reconstructed points in it.
    pub points: usize,
    /// Share of them within 1 mm of a true root, 0..1; none of none.
    pub precision: Option<f64>,
}

/// What is seen of each [`Place`], by the coverage (z, y, x: views that see the voxel) of a grid.
pub fn sight(
    coverage: ArrayView3<u8>,
    min_views: usize,
    grid: &Grid,
    tank: &Tank,
    truth: Option<&[Root]>,
) -> Vec<Sight> {
    let known = |n: u8| usize::from(n) >= min_views;
    let mut all = Place::ALL.map(|place| {
        let length = truth.map(|_| 0.0);
        Sight { place, voxels: 0, unseen: 0, true_length_mm: length, unseen_length_mm: length }
    });
    for ((k, j, i), &n) in coverage.indexed_iter() {
        if let Some(place) = Place::of(tank, grid.point_mm(k as f64, j as f64, i as f64).into()) {
            all[place as usize].voxels += 1;
            all[place as usize].unseen += usize::from(!known(n));
        }
    }
    for p in truth.map(sampled).unwrap_or_default() {
        // Negative and too large ones both lie outside.
        let [x, y, z] = [0, 1, 2].map(|c| ((p[c] - grid.origin_mm[c]) / grid.spacing_mm).round() as isize as usize);
        let (Some(place), Some(&n)) = (Place::of(tank, p), coverage.get([z, y, x])) else { continue };
        let of_place = &mut all[place as usize];
        let add = |length: &mut Option<f64>| *length = length.map(|l| l + STEP_MM);
        add(&mut of_place.true_length_mm);
        if !known(n) {
            add(&mut of_place.unseen_length_mm);
        }
    }
    all.to_vec()
}

/// How right the found points (tank frame, mm) are in each [`Place`] above `z_max_mm`; `turned_deg` is the turn that
/// [`Score`](super::Score) reports.
pub fn bands(truth: &[Root], tank: &Tank, found: &[[f64; 3]], z_max_mm: f64, turned_deg: Option<f64>) -> Vec<Band> {
    let (found, truth) = (turned(found, turned_deg.unwrap_or(0.0)), sampled(truth));
    let near = |points: &[[f64; 3]], others: &[[f64; 3]]| -> Vec<(Option<Place>, bool)> {
        let distances = distances(points, &RTree::bulk_load(others.to_vec()));
        let place = |p: &[f64; 3]| Place::of(tank, *p).filter(|_| p[2] < z_max_mm);
        points.iter().zip(distances).map(|(p, d)| (place(p), d <= NEAR_MM)).collect()
    };
    let (found, truth) = (near(&found, &truth), near(&truth, &found));
    Place::ALL
        .into_iter()
        .map(|place| {
            let share = |side: &[(Option<Place>, bool)]| {
                let right: Vec<bool> =
                    side.iter().filter(|(at, _)| *at == Some(place)).map(|(_, near)| *near).collect();
                let count = right.iter().filter(|&&near| near).count();
                (right.len(), (!right.is_empty()).then(|| count as f64 / right.len() as f64))
            };
            let ((points, precision), (length, recall)) = (share(&found), share(&truth));
            Band { place, true_length_mm: length as f64 * STEP_MM, recall, points, precision }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use ndarray::Array3;

    fn tank() -> Tank {
        Tank {
            radius_mm: 20.0,
            height_mm: 60.0,
            wall_mm: 2.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 12.0]],
        }
    }

    fn upright(x: f64, from: f64, to: f64) -> Root {
        let points_mm: Vec<_> = (0..=100).map(|n| [x, 0.0, from + (to - from) * f64::from(n) / 100.0]).collect();
        Root { id: 0, parent: -1, order: 0, radii_mm: vec![0.5; points_mm.len()], points_mm }
    }

    #[test]
    fn every_place_of_the_water_has_its_name() {
        for (point, place) in [
            ([0.0, 0.0, 9.0], None),
            ([0.0, 0.0, 11.0], Some(Place::Belt)),
            ([17.0, 0.0, 12.5], Some(Place::Surface)),
            ([0.0, 17.0, 30.0], Some(Place::Wall)),
            ([0.0, 18.5, 30.0], None),
            ([17.0, 0.0, 56.0], Some(Place::Floor)),
            ([0.0, 0.0, 58.5], None),
            ([f64::NAN, 0.0, 30.0], None),
            ([1.0, 2.0, 30.0], Some(Place::Elsewhere)),
        ] {
            assert_eq!(Place::of(&tank(), point), place, "{point:?}");
        }
    }

    #[test]
    fn a_root_at_the_wall_out_of_sight_is_lost_there() {
        let grid = Grid::of_tank(&tank(), 1.0, 50.0).unwrap();
        let mut coverage = Array3::from_elem(grid.shape, 5u8);
        // Nothing of x > 15.5 mm is seen.
        for ((.., i), n) in coverage.indexed_iter_mut() {
            *n = if grid.origin_mm[0] + i as f64 > 15.5 { 2 } else { 5 };
        }
        let truth = [upright(16.0, 20.0, 40.0), upright(0.0, 20.0, 70.0)];
        let sight = sight(coverage.view(), 3, &grid, &tank(), Some(&truth));
        let [wall, elsewhere] = [Place::Wall, Place::Elsewhere].map(|p| sight[p as usize]);
        assert_eq!((wall.true_length_mm, wall.unseen_length_mm), (Some(20.0), Some(20.0)));
        assert!(wall.unseen > 0 && wall.unseen < wall.voxels);
        // From z = 20 to the grid's end at 49.5, all of it seen.
        assert!((elsewhere.true_length_mm.unwrap() - 29.5).abs() <= 0.5 && elsewhere.unseen_length_mm == Some(0.0));
        assert!(super::sight(coverage.view(), 3, &grid, &tank(), None)[0].true_length_mm.is_none());
    }

    #[test]
    fn bands_tell_the_wall_from_the_rest() {
        let truth = [upright(16.0, 20.0, 40.0), upright(0.0, 20.0, 40.0)];
        let mut found = truth[1].points_mm.clone();
        found.push([0.0, 16.0, 30.0]);
        let bands = bands(&truth, &tank(), &found, 50.0, None);
        let [wall, elsewhere] = [Place::Wall, Place::Elsewhere].map(|p| bands[p as usize]);
        assert_eq!((wall.recall, wall.precision, wall.points), (Some(0.0), Some(0.0), 1));
        assert_eq!((elsewhere.recall, elsewhere.precision), (Some(1.0), Some(1.0)));
        assert_eq!(bands[Place::Floor as usize].recall, None);
    }
}
