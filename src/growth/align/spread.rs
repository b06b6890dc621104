//! How far a found frame may be off: from what of the two prints does not lie upon each other.
//!
//! Prints that were unrolled with cameras that are a little off are bent: smoothly along the wall, since every photograph sees a third of
//! it. What of the bend looks like a motion (its mean and its first harmonic around the tank) went into the motion and is seen no more; the next
//! harmonics, which no motion makes, are what is left. The bend's spectrum is taken to go on as these begin: the variance of harmonics 2
//! and 3 is that of 0 and 1. Noise of the print has all harmonics alike and is in it. Belts are seen by the same cameras, so that they count as one.

use super::{Cell, cells, slopes};
use crate::growth::motion::Motion;
use crate::growth::pattern::Pattern;
use nalgebra::{Matrix2, Matrix6, Vector2, Vector6};
use rayon::prelude::*;

/// Pieces of the wall whose shift is looked at, around the tank.
const PIECES: usize = 36;
/// Harmonics that tell.
const TELLING: [usize; 2] = [2, 3];

/// Normal equations of a piece's own shift.
#[derive(Clone, Copy, Default)]
struct Piece {
    normal: Matrix2<f64>,
    right: Vector2<f64>,
}

/// Standard deviations of the azimuth, radians, and of a point on the printed wall, mm, worst of some; not a number where too little is seen.
pub(super) fn deviations(a: &[Pattern], b: &[Pattern], motion: &Motion) -> (f64, f64) {
    let (mut power, mut coefficients) = (0.0, 0);
    let mut seen = Matrix6::zeros();
    for (a, b) in a.iter().zip(b) {
        let shifts = shifts(a, b, motion);
        let known: Vec<(usize, Vector2<f64>)> =
            shifts.iter().enumerate().filter_map(|(k, s)| Some((k, (*s)?))).collect();
        let z = a.top_mm + 0.5 * a.cell_mm * (a.values.dim().0 - 1) as f64;
        for (k, _) in &known {
            let (sin, cos) = azimuth(*k).sin_cos();
            for row in slopes(a.radius_mm, z, sin, cos).map(Vector6::from) {
                seen += row * row.transpose();
            }
        }
        // A belt of which half is seen has no harmonics.
        if 4 * known.len() < 3 * PIECES {
            continue;
        }
        for harmonic in TELLING {
            for side in 0..2 {
                for phase in [0.0, std::f64::consts::FRAC_PI_2] {
                    let wave = |k: usize| (harmonic as f64 * azimuth(k) + phase).cos();
                    let sum: f64 = known.iter().map(|(k, s)| s[side] * wave(*k)).sum();
                    power += (2.0 * sum / known.len() as f64).powi(2);
                    coefficients += 1;
                }
            }
        }
    }
    // A wave's coefficient varies by 2 / PIECES of what each piece, by itself, would.
    let variance = power / f64::from(coefficients) * PIECES as f64 / 2.0;
    let Some(covariance) = seen.try_inverse().map(|m| m * variance * a.len() as f64) else {
        return (f64::NAN, f64::NAN);
    };
    let mut worst: f64 = 0.0;
    for a in a {
        for k in 0..12 {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 12.0).sin_cos();
            let [along, below] = slopes(a.radius_mm, a.top_mm, sin, cos).map(Vector6::from);
            let of = |v: &Vector6<f64>| (v.transpose() * covariance * v)[(0, 0)];
            worst = worst.max((of(&along) + of(&below)).sqrt());
        }
    }
    (covariance[(2, 2)].sqrt(), worst)
}

/// The middle of a piece, radians.
fn azimuth(piece: usize) -> f64 {
    std::f64::consts::TAU * (piece as f64 + 0.5) / PIECES as f64
}

/// By how much each piece of the wall would have to be moved further, along and down, mm.
fn shifts(a: &Pattern, b: &Pattern, motion: &Motion) -> Vec<Option<Vector2<f64>>> {
    let (rows, columns) = a.values.dim();
    let of_row = |r: usize| {
        let mut pieces = [Piece::default(); PIECES];
        cells(a, b, motion, r, |cell: &Cell| {
            let piece = &mut pieces[(cell.column * PIECES / columns).min(PIECES - 1)];
            let slope = Vector2::new(cell.across, cell.down);
            piece.normal += cell.weight * slope * slope.transpose();
            piece.right += cell.weight * cell.residual * slope;
        });
        pieces
    };
    // Rows by themselves, added in order: the same bits on any number of threads.
    let parts: Vec<[Piece; PIECES]> = (0..rows).into_par_iter().map(of_row).collect();
    let mut sums = [Piece::default(); PIECES];
    for part in &parts {
        for (sum, piece) in sums.iter_mut().zip(part) {
            sum.normal += piece.normal;
            sum.right += piece.right;
        }
    }
    sums.iter().map(|piece| piece.normal.cholesky().map(|c| c.solve(&piece.right))).collect()
}
