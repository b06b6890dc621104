//! Dirt on the outer wall and air bubbles on the inner one; both turn with the tank.
//!
//! Marks are discs of random place and size on the clear wall, looked up by cells of the unrolled cylinder.
//! Dirt hides what lies behind with a soft edge. A bubble mirrors the room at its rim, where light meets it beyond
//! the angle of total reflection, and dims what is seen through its middle; or its rim is dark, and the lamps make a spot.

use super::noise::{hash, uniform};
use crate::optics::{Tank, Vec3};

/// Width of a cell of the lookup, mm; no mark is larger.
const CELL_MM: f64 = 6.0;

/// Where a point lies on a mark, in radii of the mark.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Distance from the centre, 0..1.
    pub out: f64,
    /// Offset from the centre towards growing azimuth.
    pub across: f64,
    /// Offset downwards.
    pub down: f64,
}

/// Discs on a cylinder.
#[derive(Debug, Clone)]
pub struct Marks {
    radius_mm: f64,
    columns: usize,
    rows: usize,
    /// Marks (arc, z, radius), by cell of their centre.
    cells: Vec<Vec<[f64; 3]>>,
}

impl Marks {
    /// `count` discs of radii around `size_mm` (half to one and a half times that), on the clear part of the cylinder.
    pub fn new(tank: &Tank, radius_mm: f64, count: usize, size_mm: f64, seed: u64) -> Self {
        let around = std::f64::consts::TAU * radius_mm;
        let columns = ((around / CELL_MM).floor() as usize).max(3);
        let rows = (tank.height_mm / CELL_MM).ceil() as usize + 1;
        let mut cells = vec![Vec::new(); columns * rows];
        for i in 0..count as u64 {
            let draw = |j: u64| uniform(hash(seed, &[83, i, j]));
            let (arc, z) = (draw(0) * around, draw(1) * tank.height_mm);
            let size = (size_mm * (0.5 + draw(2))).min(CELL_MM / 2.0);
            if tank.is_clear(z) && count > 0 {
                let cell =
                    (z / CELL_MM) as usize * columns + ((arc / around * columns as f64) as usize).min(columns - 1);
                cells[cell].push([arc, z, size]);
            }
        }
        Self { radius_mm, columns, rows, cells }
    }

    /// Where a point of the cylinder lies on a mark; `None` off all marks. Of overlapping marks the one whose centre is
    /// relatively nearest.
    pub fn at(&self, p: &Vec3) -> Option<Place> {
        let around = std::f64::consts::TAU * self.radius_mm;
        let arc = (p.y.atan2(p.x) / std::f64::consts::TAU).rem_euclid(1.0) * around;
        let (column, row) = ((arc / around * self.columns as f64) as usize, (p.z / CELL_MM) as usize);
        let mut best: Option<Place> = None;
        for row in row.saturating_sub(1)..=(row + 1).min(self.rows - 1) {
            for shift in [self.columns - 1, 0, 1] {
                for [a, z, size] in &self.cells[row * self.columns + (column + shift) % self.columns] {
                    let across = (arc - a + 1.5 * around).rem_euclid(around) - 0.5 * around;
                    let out = across.hypot(p.z - z) / size;
                    if out < 1.0 && best.is_none_or(|b| out < b.out) {
                        best = Some(Place { out, across: across / size, down: (p.z - z) / size });
                    }
                }
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    #[test]
    fn lookup_finds_every_mark_across_cells_and_the_seam() {
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 100.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 15.0]],
        };
        let marks = Marks::new(&tank, 40.0, 300, 1.5, 5);
        let all: Vec<[f64; 3]> = marks.cells.iter().flatten().copied().collect();
        assert!(all.len() > 200);
        for i in 0..4000u64 {
            let (azimuth, z) = (uniform(hash(1, &[i, 0])) * 6.3 - 3.1, uniform(hash(1, &[i, 1])) * 100.0);
            let p = Vec3::new(40.0 * azimuth.cos(), 40.0 * azimuth.sin(), z);
            let slow = all
                .iter()
                .map(|[arc, mz, size]| {
                    let turn = (azimuth - arc / 40.0).sin().atan2((azimuth - arc / 40.0).cos());
                    (turn * 40.0).hypot(z - mz) / size
                })
                .fold(f64::INFINITY, f64::min);
            let fast = marks.at(&p).map_or(f64::INFINITY, |place| place.out);
            assert!((slow < 1.0) == (fast < 1.0) && (slow >= 1.0 || (slow - fast).abs() < 1e-9), "{slow} {fast}");
        }
    }
}
