//! The print of a belt unrolled: what the photographs show on the tank's outer wall, by azimuth and depth.
//!
//! Columns run around the tank from azimuth 0 in the sense of rising azimuth, rows down; cells are squares of about
//! [`CELL_MM`]. A cell's gray is the mean over the photographs that see it within 60 degrees of the wall's normal,
//! weighted by the squared cosine of that angle: the sides of a cylinder cancel. Belts lie in air, so lines of sight are straight.

use crate::optics::{Vec3, View};
use ndarray::{Array2, ArrayView2};
use rayon::prelude::*;

/// Aimed at width of a cell, mm: about a pixel.
pub const CELL_MM: f64 = 0.25;
/// Beyond it the print is foreshortened to less than half.
const MAX_INCIDENCE_DEG: f64 = 60.0;

/// An unrolled belt.
#[derive(Debug, Clone, PartialEq)]
pub struct Print {
    /// Depth of the first row's middle, mm.
    pub top_mm: f64,
    /// Radius of the printed surface, mm.
    pub radius_mm: f64,
    /// Height of a cell, mm; its width is the circumference over the number of columns.
    pub cell_mm: f64,
    /// Gray values (row, column), 0 to 255; NaN where no photograph sees the print.
    pub gray: Array2<f32>,
}

/// Unrolls the belt at depths `belt_mm` of a printed surface of that radius from gray photographs (y, x) and their views, which have
/// ideal lenses.
pub fn unroll(photographs: &[(View, Array2<u8>)], radius_mm: f64, belt_mm: [f64; 2]) -> Print {
    let columns = (std::f64::consts::TAU * radius_mm / CELL_MM).round().max(8.0) as usize;
    let rows = ((belt_mm[1] - belt_mm[0]) / CELL_MM).floor().max(1.0) as usize;
    let cell_mm = (belt_mm[1] - belt_mm[0]) / rows as f64;
    let top_mm = belt_mm[0] + 0.5 * cell_mm;
    let least = MAX_INCIDENCE_DEG.to_radians().cos();
    let centres: Vec<Vec3> = photographs.iter().map(|(view, _)| view.centre_in_tank()).collect();
    let cell = |row: usize, column: usize| {
        let azimuth = std::f64::consts::TAU * column as f64 / columns as f64;
        let normal = Vec3::new(azimuth.cos(), azimuth.sin(), 0.0);
        let point = normal * radius_mm + Vec3::z() * (top_mm + row as f64 * cell_mm);
        let (mut sum, mut weights) = (0.0, 0.0);
        for ((view, gray), centre) in photographs.iter().zip(&centres) {
            let facing = normal.dot(&(centre - point).normalize());
            if facing < least {
                continue;
            }
            let seen = view.pixel_of_direction(&(point - centre)).and_then(|(u, v)| bilinear(gray.view(), u, v));
            if let Some(value) = seen {
                sum += facing * facing * value;
                weights += facing * facing;
            }
        }
        if weights > 0.0 { (sum / weights) as f32 } else { f32::NAN }
    };
    let gray: Vec<f32> = (0..rows * columns).into_par_iter().map(|k| cell(k / columns, k % columns)).collect();
    let gray = Array2::from_shape_vec((rows, columns), gray).unwrap_or_default();
    Print { top_mm, radius_mm, cell_mm, gray }
}

/// The value between four pixels; `None` outside the picture.
fn bilinear(gray: ArrayView2<u8>, u: f64, v: f64) -> Option<f64> {
    let (height, width) = gray.dim();
    if !(u >= 0.0 && v >= 0.0 && u < (width - 1) as f64 && v < (height - 1) as f64) {
        return None;
    }
    let (x, y) = (u as usize, v as usize);
    let (fx, fy) = (u - x as f64, v - y as f64);
    let at = |y: usize, x: usize| f64::from(gray[(y, x)]);
    let row = |y: usize| at(y, x) + fx * (at(y, x + 1) - at(y, x));
    Some(row(y) + fy * (row(y + 1) - row(y)))
}
