//! The roots' colour, learned from the photographs.
//!
//! Ridge pixels teach it: they stand out from a background that is sure, more than what lies 2.2 mm to either side of
//! them, so that edges of the room, shadows and leaves are left out, and a root's middle is taken rather than its
//! half covered borders. Their mean and covariance are found by repeated trimming; the covariance is mostly shading, a long thin
//! ellipsoid along the light.

use super::smooth::smooth;
use crate::optics::{Mat3, Vec3};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

/// Beside a ridge of a root there is background again, mm at the axis; wider than half the thickest common roots.
const BESIDE_MM: f64 = 2.2;
/// Smoothing before ridges are sought, mm at the axis: about the thinnest roots' width.
const SMOOTH_MM: f64 = 0.35;
/// A ridge stands out by so many noise deviations beyond twice what is beside it.
const STANDS_OUT: f32 = 4.0;
/// Share of ridge pixels that a trimming keeps, and what its variance is enlarged by to be that of all.
const KEPT: f64 = 0.8;
const ENLARGED: f64 = 1.6;
/// Fewer ridge pixels teach nothing.
const FEWEST: usize = 200;
/// Width, in standard deviations, of an even band with a Gaussian's area and height: √(2π).
const EQUIVALENT: f64 = 2.506_628_274_631;
/// A colour this far from the roots' mean, in their deviations, squared, is not theirs: 97 % of a normal distribution.
const REACH: f64 = 9.0;

/// Mean and covariance of the roots' colours, in codes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RootColour {
    /// R, G, B.
    pub mean: [f64; 3],
    /// Of shading, species, age.
    pub covariance: [[f64; 3]; 3],
}

/// Mean and covariance, ready to be asked about many colours.
#[derive(Debug, Clone, Copy)]
pub struct Likeness {
    mean: [f32; 3],
    inverse: [[f32; 3]; 3],
}

impl Likeness {
    /// Whether a colour may be a root's.
    pub fn holds(&self, colour: [f32; 3]) -> bool {
        let d = [0, 1, 2].map(|c| colour[c] - self.mean[c]);
        let distance: f32 = (0..3).map(|i| d[i] * (0..3).map(|j| self.inverse[i][j] * d[j]).sum::<f32>()).sum();
        distance < REACH as f32
    }
}

impl RootColour {
    /// From ridge pixels' colours; `None` where they are too few. `noise_variance` in codes² keeps the covariance regular.
    pub fn learn(colours: &[[f32; 3]], noise_variance: f64) -> Option<Self> {
        if colours.len() < FEWEST {
            return None;
        }
        let all: Vec<Vec3> = colours.iter().map(|c| Vec3::from(c.map(f64::from))).collect();
        let median = |c: usize| {
            let mut values: Vec<f64> = all.iter().map(|x| x[c]).collect();
            let middle = values.len() / 2;
            *values.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        let mut mean = Vec3::new(median(0), median(1), median(2));
        let mut kept = all.clone();
        let mut covariance = Mat3::identity();
        for _ in 0..15 {
            let sum: Mat3 = kept.iter().map(|x| (x - mean) * (x - mean).transpose()).sum();
            covariance = sum / kept.len() as f64 + Mat3::identity() * (0.25 * noise_variance);
            let inverse = covariance.try_inverse()?;
            let distance = |x: &Vec3| ((x - mean).transpose() * inverse * (x - mean))[0];
            let mut distances: Vec<f64> = all.iter().map(distance).collect();
            let at = ((distances.len() - 1) as f64 * KEPT) as usize;
            let limit = *distances.select_nth_unstable_by(at, f64::total_cmp).1;
            kept = all.iter().filter(|x| distance(x) <= limit).copied().collect();
            mean = kept.iter().sum::<Vec3>() / kept.len() as f64;
        }
        Some(Self { mean: mean.into(), covariance: (covariance * ENLARGED).into() })
    }

    /// Ready to be asked.
    pub fn likeness(&self) -> Likeness {
        let inverse = Mat3::from(self.covariance).try_inverse().unwrap_or_else(Mat3::identity);
        let rows: [[f64; 3]; 3] = inverse.into();
        Likeness { mean: self.mean.map(|x| x as f32), inverse: rows.map(|row| row.map(|x| x as f32)) }
    }
}

/// A pixel on a root's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ridge {
    /// (y, x).
    pub at: (usize, usize),
    /// Width of the root, mm at the axis: what stands out across it, spread evenly at the middle's height, less the smoothing.
    pub width_mm: f32,
}

/// The ridge pixels of a photograph whose pixels stand out by `deviations` of their noise from a
/// background that is `sure`.
pub fn ridge_pixels(deviations: &Array2<f32>, sure: &Array2<bool>, px_per_mm: f64) -> Vec<Ridge> {
    let (height, width) = deviations.dim();
    let z = smooth(deviations, SMOOTH_MM * px_per_mm);
    let straight = (BESIDE_MM * px_per_mm).round().max(2.0) as usize;
    let diagonal = (BESIDE_MM * px_per_mm / std::f64::consts::SQRT_2).round().max(2.0) as usize;
    if height <= 2 * straight || width <= 2 * straight {
        return Vec::new();
    }
    let mut found = Vec::new();
    for y in straight..height - straight {
        for x in straight..width - straight {
            let here = z[[y, x]];
            if here <= STANDS_OUT || !sure[[y, x]] {
                continue;
            }
            let across = |dy: isize, dx: isize, beside: usize| {
                let at = |n: isize| z[[y.wrapping_add_signed(n * dy), x.wrapping_add_signed(n * dx)]];
                let beside = beside as isize;
                let ridge = here >= at(1) && here >= at(-1) && here - 2.0 * at(beside).max(at(-beside)) > STANDS_OUT;
                let step = ((dy * dy + dx * dx) as f32).sqrt();
                ridge.then(|| step * (-beside..=beside).map(|n| at(n).max(0.0)).sum::<f32>() / here)
            };
            // A slanting cut is longer than the root is wide: the narrowest counts.
            let cuts = [(0, 1, straight), (1, 0, straight), (1, 1, diagonal), (1, -1, diagonal)];
            let narrowest = cuts.into_iter().filter_map(|(dy, dx, beside)| across(dy, dx, beside)).reduce(f32::min);
            if let Some(width_px) = narrowest {
                let width_mm = f64::from(width_px) / px_per_mm;
                let sharp = (width_mm * width_mm - (EQUIVALENT * SMOOTH_MM).powi(2)).max(0.0).sqrt();
                found.push(Ridge { at: (y, x), width_mm: sharp as f32 });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ridges_are_taken_and_edges_left() {
        let deviations = Array2::from_shape_fn((60, 80), |(y, _)| {
            let line = if (y as i32 - 20).abs() <= 1 { 30.0 } else { 0.0 };
            let edge = if y > 35 { 40.0f32 } else { 0.0 };
            edge.max(line)
        });
        let found = ridge_pixels(&deviations, &Array2::from_elem((60, 80), true), 2.3);
        assert!(found.len() > 40 && found.iter().all(|ridge| ridge.at.0.abs_diff(20) <= 1), "{found:?}");
        // Three pixels at 2.3 px/mm.
        assert!(found.iter().all(|ridge| (ridge.width_mm - 1.3).abs() < 0.4), "{found:?}");
    }

    #[test]
    fn a_colour_is_learned_beside_others() {
        let colours: Vec<[f32; 3]> = (0..3000)
            .map(|n| {
                let shade = ((n * 37) % 101) as f32 - 50.0;
                if n % 8 == 0 { [20.0, 200.0, 90.0] } else { [150.0 + shade, 140.0 + shade, 120.0 + 0.8 * shade] }
            })
            .collect();
        let roots = RootColour::learn(&colours, 4.0).unwrap();
        assert!((roots.mean[0] - 150.0).abs() < 8.0 && (roots.mean[2] - 120.0).abs() < 8.0, "{roots:?}");
        let likeness = roots.likeness();
        assert!(likeness.holds([170.0, 160.0, 136.0]) && !likeness.holds([150.0, 140.0, 150.0]));
        assert_eq!(RootColour::learn(&colours[..10], 4.0), None);
    }
}
