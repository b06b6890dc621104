//! What the paper's interpolated search costs in accuracy: its pixels against those of the exact inverse.

use super::Grid;
use super::patch_rbf::PatchMap;
use crate::optics::ViewMap;

/// Voxels within this of the inner wall are near it, mm: there pixels change fastest from voxel to voxel.
pub const NEAR_WALL_MM: f64 = 10.0;

/// How far the pixels of both methods lie apart at one voxel that the exact inverse sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Deviation {
    /// Distance of the voxel from the inner wall, mm.
    pub to_wall_mm: f64,
    /// Distance of the pixels, px; `None` where the search sees nothing.
    pub px: Option<f64>,
}

/// Deviations over some voxels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapError {
    /// Half of the distances are smaller, px; NaN without voxels, as the others.
    pub median_px: f64,
    /// 95 of 100 are smaller.
    pub p95_px: f64,
    /// The largest.
    pub max_px: f64,
    /// Voxels that both methods see.
    pub voxels: usize,
    /// Voxels that only the exact inverse sees.
    pub lost: usize,
}

/// The deviation at every `step`-th voxel along each axis, of those that a regular, unhindered ray of the exact inverse
/// `map` goes through and whose pixel lies in the picture.
pub fn deviations(search: &PatchMap, map: &ViewMap, grid: &Grid, step: usize) -> Vec<Deviation> {
    let (inner, view) = (map.tank().inner_radius_mm(), map.view());
    let [depth, rows, columns] = grid.shape;
    let mut found = Vec::new();
    for k in (0..depth).step_by(step) {
        for j in (0..rows).step_by(step) {
            for i in (0..columns).step_by(step) {
                let point = grid.point_mm(k as f64, j as f64, i as f64);
                if point.z <= map.tank().water_level_mm || point.z >= map.tank().floor_mm() {
                    continue;
                }
                let seen = map.project(&point).filter(|p| p.clear && p.distance_mm < 1e-6 && view.holds(p.u, p.v));
                let Some(exact) = seen else { continue };
                let px = search.pixel([k, j, i]).map(|(u, v)| (u - exact.u).hypot(v - exact.v));
                found.push(Deviation { to_wall_mm: inner - point.xy().norm(), px });
            }
        }
    }
    found
}

impl MapError {
    /// Sums up the deviations of which `counts` holds.
    pub fn of(deviations: &[Deviation], counts: impl Fn(&Deviation) -> bool) -> Self {
        let counted = || deviations.iter().filter(|d| counts(d));
        let mut px: Vec<f64> = counted().filter_map(|d| d.px).collect();
        px.sort_by(f64::total_cmp);
        let at = |share: f64| px.get((px.len().saturating_sub(1) as f64 * share) as usize).copied().unwrap_or(f64::NAN);
        Self {
            median_px: at(0.5),
            p95_px: at(0.95),
            max_px: at(1.0),
            voxels: px.len(),
            lost: counted().count() - px.len(),
        }
    }

    /// Those farther from the wall than [`NEAR_WALL_MM`], and those nearer.
    pub fn inside_and_near_wall(deviations: &[Deviation]) -> [Self; 2] {
        [Self::of(deviations, |d| d.to_wall_mm > NEAR_WALL_MM), Self::of(deviations, |d| d.to_wall_mm <= NEAR_WALL_MM)]
    }
}
