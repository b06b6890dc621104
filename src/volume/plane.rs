//! A plane through the grid as a picture: which voxel each of its pixels shows.

use super::grid::Grid;
use crate::optics::Vec3;

/// A plane as a picture of pixels as wide as voxels. It spans the whole grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// The middle of the picture, tank frame, mm.
    pub centre_mm: Vec3,
    /// Unit vector along its rows.
    pub across: Vec3,
    /// Unit vector down its columns.
    pub down: Vec3,
    /// Unit vector across the plane.
    pub normal: Vec3,
    /// Edge of a pixel, mm.
    pub px_mm: f64,
    /// Rows and columns.
    pub size_px: [usize; 2],
    /// Greatest distance from the grid's middle, mm, at which such a plane meets the grid.
    pub reach_mm: f64,
}

impl Plane {
    /// The plane whose normal leans by `tilt_rad` from straight down (0: horizontal) towards the direction `turn_rad` (from x to y),
    /// at a distance along it from the grid's middle. Rows are horizontal.
    pub fn through(grid: &Grid, turn_rad: f64, tilt_rad: f64, distance_mm: f64) -> Self {
        let ((sin_turn, cos_turn), (sin_tilt, cos_tilt)) = (turn_rad.sin_cos(), tilt_rad.sin_cos());
        let normal = Vec3::new(sin_tilt * cos_turn, sin_tilt * sin_turn, cos_tilt);
        let across = Vec3::new(-sin_turn, cos_turn, 0.0);
        let down = normal.cross(&across);
        let [nz, ny, nx] = grid.shape;
        let half_mm = Vec3::new(nx as f64, ny as f64, nz as f64) * (0.5 * grid.spacing_mm);
        let reach = |axis: &Vec3| axis.iter().zip(half_mm.iter()).map(|(a, h)| a.abs() * h).sum::<f64>();
        let pixels = |axis: &Vec3| ((2.0 * reach(axis) / grid.spacing_mm - 1e-6).ceil() as usize).max(1);
        let middle = grid.point_mm((nz as f64 - 1.0) / 2.0, (ny as f64 - 1.0) / 2.0, (nx as f64 - 1.0) / 2.0);
        Self {
            centre_mm: middle + normal * distance_mm,
            px_mm: grid.spacing_mm,
            size_px: [pixels(&down), pixels(&across)],
            reach_mm: reach(&normal),
            across,
            down,
            normal,
        }
    }

    /// The voxel (k, j, i) nearest to the middle of a pixel; none outside of the grid.
    pub fn voxel(&self, grid: &Grid, row: usize, column: usize) -> Option<[usize; 3]> {
        let from_middle = |n: usize, of: usize| (n as f64 - (of as f64 - 1.0) / 2.0) * self.px_mm;
        let point = self.centre_mm
            + self.across * from_middle(column, self.size_px[1])
            + self.down * from_middle(row, self.size_px[0]);
        let mut voxel = [0; 3];
        for (axis, nearest) in voxel.iter_mut().enumerate() {
            let at = ((point[2 - axis] - grid.origin_mm[2 - axis]) / grid.spacing_mm).round();
            if !(at >= 0.0 && at < grid.shape[axis] as f64) {
                return None;
            }
            *nearest = at as usize;
        }
        Some(voxel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::f64::consts::FRAC_PI_2;

    fn grid() -> Grid {
        Grid { origin_mm: [-4.0, -6.0, 0.0], spacing_mm: 2.0, shape: [9, 7, 5] }
    }

    #[test]
    fn planes_along_the_axes_show_every_voxel_once() {
        let grid = grid();
        for (turn, tilt, size, constant) in
            [(-FRAC_PI_2, 0.0, [7, 5], 0), (0.0, FRAC_PI_2, [9, 7], 2), (FRAC_PI_2, FRAC_PI_2, [9, 5], 1)]
        {
            let plane = Plane::through(&grid, turn, tilt, 0.0);
            assert_eq!(plane.size_px, size, "{plane:?}");
            let pixels = (0..size[0]).flat_map(|r| (0..size[1]).map(move |c| (r, c)));
            let mut seen: Vec<[usize; 3]> = pixels.filter_map(|(r, c)| plane.voxel(&grid, r, c)).collect();
            assert!(seen.iter().all(|v| v[constant] == grid.shape[constant] / 2));
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), size[0] * size[1]);
        }
        let below = Plane::through(&grid, -FRAC_PI_2, 0.0, 4.0);
        assert_eq!((below.voxel(&grid, 0, 0), below.reach_mm), (Some([6, 0, 0]), 9.0));
        assert_eq!(Plane::through(&grid, -FRAC_PI_2, 0.0, 20.0).voxel(&grid, 0, 0), None);
    }

    proptest! {
        #[test]
        fn a_pixel_shows_the_voxel_that_it_lies_in(turn in -7.0..7.0f64, tilt in 0.0..3.2f64, at in -9.0..9.0f64, row in 0usize..12, column in 0usize..12) {
            let grid = grid();
            let plane = Plane::through(&grid, turn, tilt, at);
            if let Some([k, j, i]) = plane.voxel(&grid, row, column) {
                let off = grid.point_mm(k as f64, j as f64, i as f64) - plane.centre_mm;
                let half_diagonal = 0.5 * grid.spacing_mm * 3f64.sqrt() + 1e-9;
                prop_assert!(off.dot(&plane.normal).abs() <= half_diagonal);
                let column_mm = (column as f64 - (plane.size_px[1] as f64 - 1.0) / 2.0) * plane.px_mm;
                prop_assert!((off.dot(&plane.across) - column_mm).abs() <= half_diagonal);
            }
        }
    }
}
