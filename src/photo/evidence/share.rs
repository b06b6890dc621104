//! The share of root in a pixel, and how sure it is.
//!
//! x = a R + (1 - a) B + noise, with the background's colour B and variances S², the roots' mean R and covariance Σ (shading). The
//! best linear estimate weighs the channels by w = (Σ + diag S²)⁻¹ (R - B), Fisher's direction between what roots and
//! background vary in:
//!
//!   a = w·(x - B) / w·(R - B),   σ² = w·diag(S²) w / (w·(R - B))².
//!
//! Where R and B are alike σ is large. The confidence is ½² / (½² + σ²): a half, between root and none, is told or not.
//! What fits neither root nor background nor a mixture (a leaf, a coloured reflection, a highlight brighter than roots
//! are shaded) is foreign and has no say.
//!
//! A pixel that is [`FULL`] of root says no more by being brighter: width and shading are for the diameters to measure.

use super::Codes;
use super::roots::RootColour;
use super::smooth::smooth;
use crate::optics::{Mat3, Vec3};
use crate::photo::Picture;
use ndarray::{Array2, Array3};
use rayon::prelude::*;

/// Share from which a pixel counts as root.
pub const FULL: f32 = 0.7;
/// Share below none that is kept: a place darker than its background speaks no more against a root than that.
const LEAST: f32 = -0.2;
/// Code of no root.
pub const ZERO: f32 = 40.0;
/// Codes from none to [`FULL`].
pub const SPAN: f32 = 215.0;
/// Share that a pixel's error must not exceed to be told, ½.
const TOLD: f32 = 0.5;
/// Distance from mixtures of root and background, in deviations squared, at which half the confidence is gone.
const FOREIGN: f32 = 64.0;
/// Share beyond which brightness is no shading of roots.
const BRIGHTEST: f64 = 1.2;

/// Share and confidence as a picture of the store: (y, x, [share, confidence, 0]).
///
/// Share is [`ZERO`] + [`SPAN`] a / [`FULL`], a within -0.2..0.7; confidence 0..255, 0 where the pixel does not look into the
/// water. `background` (y, x, rgb) in codes, `variance` in codes², `blur_px` the deviation of the smoothing.
pub fn share(
    codes: &Codes,
    clear: &Array2<bool>,
    background: &Codes,
    variance: &Array3<f32>,
    roots: &RootColour,
    blur_px: f64,
) -> Picture {
    let (height, width) = clear.dim();
    let matte = Matte::new(roots);
    let rows: Vec<Vec<(f32, f32)>> = (0..height)
        .into_par_iter()
        .map(|y| {
            let at = |array: &Array3<f32>, x: usize| [0, 1, 2].map(|c| array[[y, x, c]]);
            (0..width)
                .map(|x| {
                    if !clear[[y, x]] {
                        return (0.0, 0.0);
                    }
                    let (a, confidence) = matte.of(at(codes, x), at(background, x), at(variance, x));
                    (a.clamp(LEAST, FULL) * confidence, confidence)
                })
                .collect()
        })
        .collect();
    let weighted = Array2::from_shape_fn((height, width), |(y, x)| rows[y][x].0);
    let confidence = Array2::from_shape_fn((height, width), |(y, x)| rows[y][x].1);
    let (near, near_confidence) = (smooth(&weighted, blur_px), smooth(&confidence, blur_px));
    // Where hardly anything is told, what is told farther around stands in, so that interpolation has no steps.
    let wide_px = (4.0 * blur_px).max(2.0);
    let (wide, wide_confidence) = (smooth(&weighted, wide_px), smooth(&confidence, wide_px));
    let mut out = Picture::zeros((height, width, 3));
    for ((y, x), &confidence) in near_confidence.indexed_iter() {
        let a = if confidence > 0.02 {
            near[[y, x]] / confidence
        } else {
            wide[[y, x]] / wide_confidence[[y, x]].max(1e-4)
        };
        out[[y, x, 0]] = (ZERO + SPAN / FULL * a).round().clamp(0.0, 255.0) as u8;
        if clear[[y, x]] {
            out[[y, x, 1]] = (255.0 * confidence).round().clamp(0.0, 255.0) as u8;
        }
    }
    out
}

/// The estimator for one colour of roots.
struct Matte {
    mean: Vec3,
    covariance: Mat3,
}

impl Matte {
    fn new(roots: &RootColour) -> Self {
        Self { mean: Vec3::from(roots.mean), covariance: Mat3::from(roots.covariance) }
    }

    /// Share and confidence of a colour before a background.
    fn of(&self, colour: [f32; 3], background: [f32; 3], variance: [f32; 3]) -> (f32, f32) {
        let noise = Vec3::from(variance.map(f64::from));
        let behind = Vec3::from(background.map(f64::from));
        let (towards, off) = (self.mean - behind, Vec3::from(colour.map(f64::from)) - behind);
        let Some(weights) = solve(&(self.covariance + Mat3::from_diagonal(&noise)), &towards) else {
            return (0.0, 0.0);
        };
        let full = weights.dot(&towards).max(1e-9);
        let a = weights.dot(&off) / full;
        let error = weights.component_mul(&weights).dot(&noise) / (full * full);
        let told = f64::from(TOLD * TOLD);
        let shading = a.clamp(0.0, BRIGHTEST);
        let left = off - shading * towards;
        let distance = solve(&(self.covariance * (shading * shading) + Mat3::from_diagonal(&noise)), &left)
            .map_or(f64::INFINITY, |x| left.dot(&x));
        let foreign = (distance / f64::from(FOREIGN)).powi(2);
        (a as f32, (told / (told + error) / (1.0 + foreign * foreign)) as f32)
    }
}

/// Solves a symmetric 3 x 3 system by cofactors.
fn solve(m: &Mat3, v: &Vec3) -> Option<Vec3> {
    let [xx, xy, xz, yy, yz, zz] = [m[(0, 0)], m[(0, 1)], m[(0, 2)], m[(1, 1)], m[(1, 2)], m[(2, 2)]];
    let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let det = xx * a + xy * b + xz * c;
    if det.is_nan() || det <= 0.0 {
        return None;
    }
    let (d, e, f) = (xx * zz - xz * xz, xy * xz - xx * yz, xx * yy - xy * xy);
    Some(Vec3::new(a * v.x + b * v.y + c * v.z, b * v.x + d * v.y + e * v.z, c * v.x + e * v.y + f * v.z) / det)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn matte() -> Matte {
        Matte::new(&RootColour {
            mean: [170.0, 165.0, 150.0],
            // A shade of 30 codes, hues of 3.
            covariance: [[909.0, 900.0, 900.0], [900.0, 909.0, 900.0], [900.0, 900.0, 909.0]],
        })
    }

    #[test]
    fn mixtures_before_any_background_give_their_share() {
        for background in [[40.0, 42.0, 50.0], [230.0, 235.0, 245.0], [90.0, 140.0, 60.0]] {
            for share in [0.0, 0.3, 1.0] {
                let colour = [0, 1, 2].map(|c| share * [170.0f32, 165.0, 150.0][c] + (1.0 - share) * background[c]);
                let (a, confidence) = matte().of(colour, background, [4.0; 3]);
                assert!((a - share).abs() < 1e-4 && confidence > 0.9, "{background:?} {share}: {a} {confidence}");
            }
        }
    }

    #[test]
    fn a_background_of_the_roots_colour_leaves_no_say() {
        let (_, confidence) = matte().of([170.0, 165.0, 150.0], [168.0, 164.0, 150.0], [4.0; 3]);
        assert!(confidence < 0.2, "{confidence}");
    }

    #[test]
    fn other_hues_are_foreign() {
        for foreign in [[255.0, 255.0, 190.0], [60.0, 170.0, 80.0]] {
            let (_, confidence) = matte().of(foreign, [40.0, 42.0, 50.0], [4.0; 3]);
            assert!(confidence < 0.5, "{foreign:?}: {confidence}");
        }
    }

    proptest! {
        #[test]
        fn the_system_is_solved(seed in prop::array::uniform9(-3.0f64..3.0), v in prop::array::uniform3(-9.0f64..9.0)) {
            let m = Mat3::from_row_slice(&seed);
            let m = m * m.transpose() + Mat3::identity() * 0.1;
            let x = solve(&m, &Vec3::from(v)).unwrap();
            prop_assert!((m * x - Vec3::from(v)).norm() < 1e-6 * (1.0 + Vec3::from(v).norm()) * m.norm().powi(2));
        }
    }
}
