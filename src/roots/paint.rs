//! The label volume: numbers of roots painted along their tubes.

use super::Root;
use crate::optics::Vec3;
use crate::volume::Grid;
use ndarray::Array3;

/// (z, y, x) u32: 0 outside, else the root's number plus one. A voxel belongs to the root whose centreline is nearest in
/// radii, its centre within the tube; every voxel that a centreline runs through is painted, however thin the root.
/// On a tie the earlier root keeps the voxel.
pub fn labels(roots: &[Root], grid: &Grid) -> Array3<u32> {
    let mut volume = Array3::zeros(grid.shape);
    let mut nearness = Array3::from_elem(grid.shape, f32::INFINITY);
    let origin = Vec3::from(grid.origin_mm);
    let spacing = grid.spacing_mm;
    for root in roots {
        let label = (root.id + 1).clamp(1, i64::from(u32::MAX)) as u32;
        for k in 0..root.points_mm.len() {
            let a = Vec3::from(root.points_mm[k]);
            let b = root.points_mm.get(k + 1).map_or(a, |p| Vec3::from(*p));
            let (ra, rb) = (root.radii_mm[k], root.radii_mm.get(k + 1).copied().unwrap_or(root.radii_mm[k]));
            // Half a voxel's diagonal reaches the voxel that holds the line.
            let reach = ra.max(rb).max(0.87 * spacing);
            let low = (a.inf(&b) - origin - Vec3::repeat(reach)) / spacing;
            let high = (a.sup(&b) - origin + Vec3::repeat(reach)) / spacing;
            let range = |d: usize, n: usize| {
                low[d].ceil().max(0.0) as usize..((high[d].floor() + 1.0).max(0.0) as usize).min(n)
            };
            for z in range(2, grid.shape[0]) {
                for y in range(1, grid.shape[1]) {
                    for x in range(0, grid.shape[2]) {
                        let p = grid.point_mm(z as f64, y as f64, x as f64);
                        let way = b - a;
                        let f = ((p - a).dot(&way) / way.norm_squared().max(1e-18)).clamp(0.0, 1.0);
                        let foot = a + way * f;
                        let radius = (ra + f * (rb - ra)).max(1e-6);
                        let off = p - foot;
                        let through = off.amax() <= 0.5 * spacing;
                        let near = (off.norm() / radius) as f32;
                        if (near <= 1.0 || through) && near < nearness[[z, y, x]] {
                            nearness[[z, y, x]] = near;
                            volume[[z, y, x]] = label;
                        }
                    }
                }
            }
        }
    }
    volume
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tubes_have_their_volume_and_thin_roots_are_unbroken() {
        let grid = Grid { origin_mm: [-5.0, -5.0, 0.0], spacing_mm: 0.25, shape: [80, 41, 41] };
        let line = |id, x: f64, radius: f64| Root {
            id,
            parent: -1,
            order: 0,
            points_mm: (0..=30).map(|k| [x, 0.1 * f64::from(k) - 1.5, 2.0 + 0.5 * f64::from(k)]).collect(),
            radii_mm: vec![radius; 31],
        };
        let volume = labels(&[line(0, -2.0, 1.5), line(4, 3.0, 0.05)], &grid);
        let count = volume.iter().filter(|&&v| v == 1).count() as f64 * 0.25f64.powi(3);
        let length = 30.0 * 0.1f64.hypot(0.5);
        let truth = std::f64::consts::PI * 1.5 * 1.5 * (length + 4.0 / 3.0 * 1.5);
        assert!((count / truth - 1.0).abs() < 0.03, "{count} of {truth} mm³");
        for z in 9..68 {
            assert!(volume.index_axis(ndarray::Axis(0), z).iter().any(|&v| v == 5), "plane {z}");
        }
    }
}
