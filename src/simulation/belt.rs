//! The belts' random print: black and white blots of three sizes, good for feature matching.
//!
//! The belt is a raster of square cells (about 1.2 mm) once around the circumference. Cells are drawn from
//! random fields of cell width 1, 2 and 4, added and thresholded at their median: detail at several scales,
//! half black, and no repeat around the tank. The same raster is printed by the SVG belt.

use super::noise;

/// A belt's raster.
#[derive(Debug, Clone, PartialEq)]
pub struct BeltPrint {
    /// Width of a cell along the circumference, mm.
    pub cell_mm: f64,
    /// Cells around the circumference.
    pub columns: usize,
    /// Cells across the belt; the last row may be cut off by the belt's edge.
    pub rows: usize,
    black: Vec<bool>,
}

/// Aimed at width of a cell, mm: 2 px at 1.7 px/mm, the finest that a usual capture resolves.
const CELL_MM: f64 = 1.2;

impl BeltPrint {
    /// The print of a belt of that radius and height.
    pub fn new(radius_mm: f64, height_mm: f64, seed: u64) -> Self {
        let around = std::f64::consts::TAU * radius_mm;
        // A multiple of 4, so that the coarsest field closes around the tank.
        let columns = ((around / CELL_MM / 4.0).round() as usize).max(2) * 4;
        let cell_mm = around / columns as f64;
        let rows = (height_mm / cell_mm).ceil().max(1.0) as usize;
        let mut field = Vec::with_capacity(rows * columns);
        for row in 0..rows as u64 {
            for column in 0..columns as u64 {
                let octave = |size: u64| noise::uniform(noise::hash(seed, &[size, row / size, column / size]));
                field.push(0.8 * octave(1) + octave(2) + 0.8 * octave(4));
            }
        }
        let mut sorted = field.clone();
        sorted.sort_by(f64::total_cmp);
        let median = sorted[sorted.len() / 2];
        Self { cell_mm, columns, rows, black: field.iter().map(|&x| x < median).collect() }
    }

    /// Whether a cell is black; columns run to the right as seen from outside and wrap around.
    pub fn is_black(&self, row: usize, column: usize) -> bool {
        self.black[row.min(self.rows - 1) * self.columns + column % self.columns]
    }

    /// Whether the print is black at that azimuth (radians) and that far below the belt's upper edge.
    pub fn is_black_at(&self, azimuth: f64, below_edge_mm: f64) -> bool {
        // z points down: seen from outside, azimuth grows to the left, columns to the right.
        let turns = (-azimuth / std::f64::consts::TAU).rem_euclid(1.0);
        let column = (turns * self.columns as f64) as usize;
        self.is_black((below_edge_mm / self.cell_mm).max(0.0) as usize, column)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_is_black_and_the_print_closes() {
        let belt = BeltPrint::new(90.0, 28.0, 3);
        assert!((belt.cell_mm * belt.columns as f64 - std::f64::consts::TAU * 90.0).abs() < 1e-9);
        let black = (0..belt.rows).flat_map(|r| (0..belt.columns).map(move |c| (r, c)));
        let share = black.filter(|&(r, c)| belt.is_black(r, c)).count() as f64 / (belt.rows * belt.columns) as f64;
        assert!((share - 0.5).abs() < 0.02, "{share}");
        assert_eq!(belt.is_black_at(0.001, 5.0), belt.is_black_at(0.001 + std::f64::consts::TAU, 5.0));
    }
}
