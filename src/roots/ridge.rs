//! What the extraction hands to the tracing: ridge points, and the dense rootness that they stand on.

use crate::optics::Vec3;
use crate::volume::Grid;
use ndarray::ArrayView3;
use serde::{Deserialize, Serialize};

/// A voxel on the crest of the rootness, with what is known of the root there.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RidgePoint {
    /// Sub-voxel position of the crest, tank frame, mm.
    pub position_mm: Vec3,
    /// Unit tangent of the root (eigenvector of λ₁); its sign carries no meaning.
    pub tangent: Vec3,
    /// Rootness, ≥ 0.
    pub rootness: f64,
    /// Scale σ of the strongest response, mm.
    pub sigma_mm: f64,
    /// Whether the point survived the hysteresis; along weaker ones loose ends may be followed.
    pub strong: bool,
}

/// The dense rootness, read between voxel centres.
#[derive(Debug, Clone, Copy)]
pub struct Field<'a> {
    /// Where the voxels are.
    pub grid: Grid,
    /// Rootness (z, y, x), NaN where no view sees the voxel.
    pub rootness: ArrayView3<'a, f32>,
}

impl Field<'_> {
    /// Trilinear rootness at a point of the tank frame; NaN outside the grid and beside an unseen voxel.
    pub fn at(&self, point_mm: &Vec3) -> f64 {
        let origin = Vec3::from(self.grid.origin_mm);
        let index = (point_mm - origin) / self.grid.spacing_mm;
        let (nz, ny, nx) = self.rootness.dim();
        let inside = |v: f64, n: usize| v >= 0.0 && v <= (n as f64) - 1.0;
        if !(inside(index.x, nx) && inside(index.y, ny) && inside(index.z, nz)) {
            return f64::NAN;
        }
        let corner = |v: f64, n: usize| {
            let low = (v.floor() as usize).min(n.saturating_sub(2));
            (low, (low + 1).min(n - 1), v - low as f64)
        };
        let (i0, i1, fx) = corner(index.x, nx);
        let (j0, j1, fy) = corner(index.y, ny);
        let (k0, k1, fz) = corner(index.z, nz);
        let along_x = |k: usize, j: usize| {
            let (a, b) = (f64::from(self.rootness[[k, j, i0]]), f64::from(self.rootness[[k, j, i1]]));
            a + fx * (b - a)
        };
        let along_y = |k: usize| {
            let (a, b) = (along_x(k, j0), along_x(k, j1));
            a + fy * (b - a)
        };
        let (a, b) = (along_y(k0), along_y(k1));
        a + fz * (b - a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    #[test]
    fn reads_a_linear_field_exactly_and_nothing_outside() {
        let grid = Grid { origin_mm: [1.0, 2.0, 3.0], spacing_mm: 0.5, shape: [4, 5, 6] };
        let at = |k: usize, j: usize, i: usize| grid.point_mm(k as f64, j as f64, i as f64);
        let values = Array3::from_shape_fn((4, 5, 6), |(k, j, i)| {
            let p = at(k, j, i);
            (2.0 * p.x - p.y + 0.5 * p.z) as f32
        });
        let field = Field { grid, rootness: values.view() };
        let p = Vec3::new(1.8, 3.1, 3.9);
        assert!((field.at(&p) - (2.0 * p.x - p.y + 0.5 * p.z)).abs() < 1e-5);
        assert!((field.at(&at(3, 4, 5)) - f64::from(values[[3, 4, 5]])).abs() < 1e-6);
        assert!(field.at(&Vec3::new(0.9, 3.0, 3.5)).is_nan());
    }
}
