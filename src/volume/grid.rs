//! The voxel grid: arrays are (z, y, x); voxel (k, j, i) sits at `origin + spacing * (i, j, k)`.  Paper 2.3.2.

use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3};
use serde::{Deserialize, Serialize};

/// Finer spacings than this, mm, are mistakes in any tank.
pub(super) const FINEST_MM: f64 = 1e-3;

/// A regular grid of cubic voxels in the tank frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Centre (x, y, z) of voxel (0, 0, 0), mm.
    pub origin_mm: [f64; 3],
    /// Edge δ of a voxel, mm.
    pub spacing_mm: f64,
    /// Number of voxels (z, y, x).
    pub shape: [usize; 3],
}

impl Grid {
    /// The grid about the tank's axis that spans its inner diameter and goes from the rim's plane
    /// (z = 0) down to `depth_mm` (exclusive): 171 x 171 x 180 for the paper's tank at 1 mm.
    ///
    /// # Errors
    /// Where a length is not positive and finite, the depth exceeds the tank's height, or the grid would hold over 2³² voxels or be less than five across.
    pub fn of_tank(tank: &Tank, spacing_mm: f64, depth_mm: f64) -> Result<Self> {
        for (name, value) in [("grid.spacing", spacing_mm), ("grid.depth", depth_mm)] {
            if !(value.is_finite() && value > 0.0) {
                return Err(Error::usage(format!("{name} is {value} mm")).help("give a positive length in mm"));
            }
        }
        if depth_mm > tank.height_mm {
            return Err(Error::usage(format!("grid.depth is {depth_mm} mm, the tank {} mm high", tank.height_mm))
                .help("depth counts from the rim's plane down; leave it out to go down to the floor"));
        }
        let half = (tank.inner_radius_mm() / spacing_mm + 1e-9).floor();
        let depth = (depth_mm / spacing_mm + 1e-9).floor().max(1.0);
        let voxels = (2.0 * half + 1.0).powi(2) * depth;
        if spacing_mm < FINEST_MM || voxels > f64::from(u32::MAX) {
            return Err(Error::usage(format!("grid.spacing = {spacing_mm:?} mm is too fine: {voxels:.1e} voxels"))
                .help("raise it, or lower grid.depth; under 0.1 mm no photograph carries the detail"));
        }
        if half < 2.0 {
            let across_mm = 2.0 * tank.inner_radius_mm();
            return Err(Error::usage(format!(
                "grid.spacing = {spacing_mm:?} mm is too coarse: the tank is {across_mm} mm wide inside"
            ))
            .help("a root is some voxels wide and the tank many: 0.3 to 1 mm is usual"));
        }
        let across = 2 * half as usize + 1;
        Ok(Self {
            origin_mm: [-half * spacing_mm, -half * spacing_mm, 0.0],
            spacing_mm,
            shape: [depth as usize, across, across],
        })
    }

    /// Centre of voxel (k, j, i) in the tank frame, mm; fractional indices lie between centres.
    pub fn point_mm(&self, k: f64, j: f64, i: f64) -> Vec3 {
        let [x, y, z] = self.origin_mm;
        Vec3::new(x + self.spacing_mm * i, y + self.spacing_mm * j, z + self.spacing_mm * k)
    }

    /// Number of voxels.
    pub fn len(&self) -> usize {
        self.shape.iter().product()
    }

    /// Whether the grid holds no voxel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    #[test]
    fn the_papers_grid() {
        let tank = Tank {
            radius_mm: 90.0,
            height_mm: 246.6,
            wall_mm: 5.0,
            water_level_mm: 12.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let grid = Grid::of_tank(&tank, 1.0, 180.0).unwrap();
        assert_eq!(grid.shape, [180, 171, 171]);
        assert_eq!(grid.point_mm(0.0, 85.0, 85.0), Vec3::zeros());
        for (spacing, depth, named) in [
            (0.0, 180.0, "grid.spacing"),
            (-1.0, 180.0, "grid.spacing"),
            (1.0, 1e9, "grid.depth"),
            (0.01, 180.0, "grid.spacing = 0.01 mm is too fine: 5.2e12"),
            (1e-300, 180.0, "grid.spacing = 1e-300 mm is too fine"),
        ] {
            let error = Grid::of_tank(&tank, spacing, depth).unwrap_err();
            assert!(error.message.contains(named) && error.help.is_some(), "{}", error.message);
        }
    }
}
