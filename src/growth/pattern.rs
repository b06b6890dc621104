//! A print freed of light and shade: each cell against its surroundings, in units of their contrast.

use super::print::Print;
use ndarray::{Array2, ArrayView2};

/// Half the side of the surroundings, mm: several blots of a print.
const AROUND_MM: f64 = 4.0;
/// Standard deviation of gray values (of 255) below which surroundings hold no print.
const PLAIN: f32 = 6.0;

/// A normalised print: values of mean 0 and deviation 1 within their surroundings, 0 where nothing is known.
#[derive(Debug, Clone)]
pub struct Pattern {
    /// Depth of the first row's middle, mm.
    pub top_mm: f64,
    /// Radius of the printed surface, mm.
    pub radius_mm: f64,
    /// Height of a cell, mm.
    pub cell_mm: f64,
    /// Values (row, column).
    pub values: Array2<f32>,
    /// Share of the cells that hold print.
    pub printed: f64,
}

impl Pattern {
    /// Normalises a print after blurring it by `blur_mm` (standard deviation).
    pub fn of(print: &Print, blur_mm: f64) -> Self {
        let seen = print.gray.mapv(|g| if g.is_finite() { 1.0f32 } else { 0.0 });
        let gray = print.gray.mapv(|g| if g.is_finite() { g } else { 0.0 });
        // Three boxes are nearly a Gaussian.
        let half = (blur_mm / print.cell_mm).round() as usize;
        let blur = |a: Array2<f32>| (0..3).fold(a, |a, _| boxed(a.view(), half));
        let (gray, weight) = (blur(gray), blur(seen.clone()));
        let gray = ndarray::Zip::from(&gray).and(&weight).map_collect(|&g, &w| if w > 0.0 { g / w } else { 0.0 });
        let known = weight.mapv(|w| if w > 0.5 { 1.0f32 } else { 0.0 });
        let around = (AROUND_MM / print.cell_mm).round() as usize;
        let total = boxed(known.view(), around);
        let over = |a: Array2<f32>| {
            let sum = boxed((a * &known).view(), around);
            ndarray::Zip::from(&sum).and(&total).map_collect(|&s, &n| if n > 0.0 { s / n } else { 0.0 })
        };
        let mean = over(gray.clone());
        let square = over(gray.mapv(|g| g * g));
        let values = ndarray::Zip::from(&gray).and(&mean).and(&square).and(&known).map_collect(|&g, &m, &s, &k| {
            let sd = (s - m * m).max(0.0).sqrt();
            if k > 0.0 && sd > PLAIN { ((g - m) / sd).clamp(-3.0, 3.0) } else { 0.0 }
        });
        let printed = values.iter().filter(|v| **v != 0.0).count() as f64 / values.len().max(1) as f64;
        Self { top_mm: print.top_mm, radius_mm: print.radius_mm, cell_mm: print.cell_mm, values, printed }
    }

    /// The pattern with cells of about `cell_mm`, each the mean of those it holds.
    pub fn coarse(&self, cell_mm: f64) -> Array2<f32> {
        let (rows, columns) = self.values.dim();
        let by = (cell_mm / self.cell_mm).round().max(1.0) as usize;
        let across = (columns / by).max(1);
        let mean = |r: usize, c: usize| {
            let from = c * columns / across;
            let to = ((c + 1) * columns / across).max(from + 1);
            let block = self.values.slice(ndarray::s![r * by..((r + 1) * by).min(rows), from..to]);
            block.mean().unwrap_or(0.0)
        };
        Array2::from_shape_fn((rows / by, across), |(r, c)| mean(r, c))
    }

    /// Value and slopes (per mm around the wall, per mm down) at an azimuth and depth; `None` beside the belt.
    pub fn at(&self, azimuth: f64, z_mm: f64) -> Option<[f64; 3]> {
        let (rows, columns) = self.values.dim();
        let wide_mm = std::f64::consts::TAU * self.radius_mm / columns as f64;
        let x = (azimuth / std::f64::consts::TAU).rem_euclid(1.0) * columns as f64;
        let y = (z_mm - self.top_mm) / self.cell_mm;
        if !(y >= 0.0 && y < (rows - 1) as f64) {
            return None;
        }
        let (c, r) = (x as usize % columns, y as usize);
        let (fx, fy) = (x - x.floor(), y - r as f64);
        let at = |r: usize, c: usize| f64::from(self.values[(r, c % columns)]);
        let (a, b, d, e) = (at(r, c), at(r, c + 1), at(r + 1, c), at(r + 1, c + 1));
        let (upper, lower) = (a + fx * (b - a), d + fx * (e - d));
        let across = ((b - a) + fy * ((e - d) - (b - a))) / wide_mm;
        Some([upper + fy * (lower - upper), across, (lower - upper) / self.cell_mm])
    }
}

/// Mean over a square of `half` cells to each side: around the tank without end, up and down as far as there are rows.
fn boxed(a: ArrayView2<f32>, half: usize) -> Array2<f32> {
    if half == 0 {
        return a.to_owned();
    }
    let (rows, columns) = a.dim();
    let mut across = Array2::<f32>::zeros((rows, columns));
    let side = (2 * half + 1) as f64;
    for r in 0..rows {
        let mut sum: f64 = (0..=2 * half).map(|k| f64::from(a[(r, (k + columns * half - half) % columns)])).sum();
        for c in 0..columns {
            across[(r, c)] = (sum / side) as f32;
            sum += f64::from(a[(r, (c + half + 1) % columns)]);
            sum -= f64::from(a[(r, (c + columns * half - half) % columns)]);
        }
    }
    let mut all = Array2::<f32>::zeros((rows, columns));
    for c in 0..columns {
        for r in 0..rows {
            let (from, to) = (r.saturating_sub(half), (r + half).min(rows - 1));
            // Cells beside the belt count as nothing, here as in the weights that this is divided by.
            let sum: f64 = (from..=to).map(|k| f64::from(across[(k, c)])).sum();
            all[(r, c)] = (sum / side) as f32;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_go_around_the_tank() {
        let a = Array2::from_shape_fn((3, 10), |(r, c)| if (r, c) == (1, 0) { 9.0 } else { 0.0 });
        let b = boxed(a.view(), 1);
        let near: Vec<f32> = [9, 0, 1].map(|c| b[(0, c)]).to_vec();
        assert!(near.iter().all(|v| (v - 1.0).abs() < 1e-6) && b[(1, 2)].abs() < 1e-6, "{b}");
    }

    #[test]
    fn light_and_shade_do_not_matter() {
        let blot =
            |r: usize, c: usize| if (r / 5 + c / 5 + (c / 10) * (r / 10)).is_multiple_of(2) { 200.0 } else { 40.0f32 };
        let print = |shade: &dyn Fn(usize) -> f32| Print {
            top_mm: 0.0,
            radius_mm: 30.0,
            cell_mm: 0.25,
            gray: Array2::from_shape_fn((80, 754), |(r, c)| blot(r, c) * shade(c)),
        };
        let bright = Pattern::of(&print(&|_| 1.0), 0.0);
        let shaded = Pattern::of(&print(&|c| 0.6 + 0.3 * (c as f32 / 120.0).sin()), 0.0);
        let same = bright.values.iter().zip(&shaded.values).filter(|(a, b)| (*a - *b).abs() < 0.3).count();
        assert!(same as f64 > 0.97 * bright.values.len() as f64, "{same} of {}", bright.values.len());
        assert!(Pattern::of(&print(&|_| 0.01), 0.0).printed < 0.01);
    }
}
