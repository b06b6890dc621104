//! One day's tank frame in another's, from the printed belts alone.
//!
//! The unrolled prints of both days are normalised ([`Pattern`]). All azimuths and depths within 3 mm are tried on coarse
//! cells; from the best on, a rigid motion of six numbers is refined by Gauss-Newton on the finest cells of all belts. On the
//! wall a small turn ω and shift t of the frame move a point at azimuth θ and depth z by
//!
//! ```text
//! along the wall:  r ω_z − z (ω_x cos θ + ω_y sin θ) − t_x sin θ + t_y cos θ
//! down:            r (ω_x sin θ − ω_y cos θ) + t_z
//! ```
//!
//! so that belts above and below fix all six. Two prints are the same where they correlate by 0.35 at least; another print is
//! refused. Standard deviations follow from what of the prints does not lie upon each other (`spread`).

mod spread;

use super::motion::Motion;
use super::pattern::Pattern;
use super::print::Print;
use crate::optics::Vec3;
use nalgebra::{Matrix6, Vector6};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How far the depths of two days may differ, mm.
const REACH_MM: f64 = 3.0;
/// Cells of the search, mm.
const COARSE_MM: f64 = 1.0;
/// Least correlation of prints that are the same: blots in another order correlate by 0.05, the same ones by 0.7 and more.
const SAME: f64 = 0.35;
/// Least share of a belt that holds print.
const PRINTED: f64 = 0.2;
/// Blurs of the refinement, mm, in turn.
const BLURS_MM: [f64; 2] = [0.5, 0.0];
const ROUNDS: usize = 12;
/// Residuals beyond so many times their typical size count less.
const HUBER: f64 = 1.5;

/// How a day's frame was found in another's.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Alignment {
    /// From the later day's tank frame to the reference's.
    pub motion: Motion,
    /// By the printed belts, or by the roots.
    pub by_belts: bool,
    /// Correlation of the prints; where roots were matched, share of the earlier roots' length that lies on later ones.
    pub agreement: f64,
    /// Standard deviation of the azimuth, degrees.
    pub azimuth_sd_deg: f64,
    /// Standard deviation of a point on the wall, mm.
    pub place_sd_mm: f64,
}

/// Why no alignment came of two days' belts.
#[derive(Debug, Clone, PartialEq)]
pub enum Unmatched {
    /// There is too little print to go by; the share of the belts that hold any.
    Plain(f64),
    /// The prints are not the same; their correlation at best.
    Other(f64),
}

/// Finds the frame of `later` in that of `reference`; belts run alike.
///
/// # Errors
/// Belts without print, or with another.
pub fn align(reference: &[Print], later: &[Print]) -> Result<Alignment, Unmatched> {
    let patterns =
        |prints: &[Print], blur: f64| -> Vec<Pattern> { prints.iter().map(|p| Pattern::of(p, blur)).collect() };
    let [a, b] = [reference, later].map(|prints| patterns(prints, BLURS_MM[0]));
    let printed = |p: &[Pattern]| p.iter().map(|p| p.printed).fold(0.0, f64::max);
    let least = printed(&a).min(printed(&b));
    if least < PRINTED {
        return Err(Unmatched::Plain(least));
    }
    let mut motion = search(&a, &b);
    let mut fit = Fit::default();
    for blur in BLURS_MM {
        let [a, b] = [reference, later].map(|prints| patterns(prints, blur));
        for _ in 0..ROUNDS {
            fit = Fit::of(&a, &b, &motion);
            let Some(step) = fit.step() else { break };
            let (turn, shift) = (Vec3::new(step[0], step[1], step[2]), Vec3::new(step[3], step[4], step[5]));
            motion = motion.after(&Motion::small(&turn, &shift));
            if shift.norm() + turn.norm() * 100.0 < 1e-4 {
                break;
            }
        }
    }
    let agreement = fit.correlation();
    // A step that led astray is as little a match as none at all.
    if agreement < SAME {
        return Err(Unmatched::Other(agreement));
    }
    let [a, b] = [reference, later].map(|prints| patterns(prints, BLURS_MM[BLURS_MM.len() - 1]));
    let (azimuth_sd, place_sd_mm) = spread::deviations(&a, &b, &motion);
    // So far points went from the reference to the later day.
    Ok(Alignment {
        motion: motion.inverse(),
        by_belts: true,
        agreement,
        azimuth_sd_deg: azimuth_sd.to_degrees(),
        place_sd_mm,
    })
}

/// The turn and shift along the axis, from the reference to the later day, at which coarse prints correlate best.
fn search(a: &[Pattern], b: &[Pattern]) -> Motion {
    let coarse = |all: &[Pattern]| all.iter().map(|p| p.coarse(COARSE_MM)).collect::<Vec<_>>();
    let (ca, cb) = (coarse(a), coarse(b));
    let columns = ca.first().map_or(1, |p| p.dim().1);
    let reach = (REACH_MM / COARSE_MM) as i64;
    let score = |turn: usize, down: i64| -> f64 {
        let of_belt = |(a, b): (&ndarray::Array2<f32>, &ndarray::Array2<f32>)| {
            let (rows, columns) = a.dim();
            let mut sum = 0.0f64;
            for r in 0..rows as i64 {
                let other = r + down;
                if other < 0 || other >= b.dim().0 as i64 || b.dim().1 != columns {
                    continue;
                }
                for c in 0..columns {
                    sum += f64::from(a[(r as usize, c)] * b[(other as usize, (c + turn) % columns)]);
                }
            }
            sum / (rows as i64 - down.abs()).max(1) as f64
        };
        ca.iter().zip(&cb).map(of_belt).sum()
    };
    let all: Vec<(usize, i64)> = (0..columns).flat_map(|turn| (-reach..=reach).map(move |down| (turn, down))).collect();
    let scores: Vec<f64> = all.par_iter().map(|&(turn, down)| score(turn, down)).collect();
    let best = scores.iter().zip(&all).max_by(|a, b| a.0.total_cmp(b.0)).map_or((0, 0), |(_, at)| *at);
    let turn = Motion::turn(std::f64::consts::TAU * best.0 as f64 / columns as f64);
    Motion { translation_mm: Vec3::z() * (best.1 as f64 * COARSE_MM), ..turn }
}

/// By how much a turn ω and shift t move a point along the wall and down, per unit of each.
fn slopes(r: f64, z: f64, sin: f64, cos: f64) -> [[f64; 6]; 2] {
    [[-z * cos, -z * sin, r, -sin, cos, 0.0], [r * sin, -r * cos, 0.0, 0.0, 0.0, 1.0]]
}

/// A cell of one print with what the other shows there.
struct Cell {
    column: usize,
    /// Sine and cosine of its azimuth.
    sin_cos: (f64, f64),
    /// Values here and there.
    here: f64,
    there: f64,
    /// Their difference, and how much it counts.
    residual: f64,
    weight: f64,
    /// Slopes of the other print, per mm around the wall and down.
    across: f64,
    down: f64,
}

/// Goes over the cells of a row that hold print on both days.
fn cells(a: &Pattern, b: &Pattern, motion: &Motion, r: usize, mut each: impl FnMut(&Cell)) {
    let columns = a.values.dim().1;
    let z = a.top_mm + r as f64 * a.cell_mm;
    for column in 0..columns {
        let here = f64::from(a.values[(r, column)]);
        if here == 0.0 {
            continue;
        }
        let (sin, cos) = (std::f64::consts::TAU * column as f64 / columns as f64).sin_cos();
        let moved = motion.apply(&Vec3::new(a.radius_mm * cos, a.radius_mm * sin, z));
        let Some([there, across, down]) = b.at(moved.y.atan2(moved.x), moved.z) else { continue };
        if there == 0.0 {
            continue;
        }
        let residual = here - there;
        let weight = if residual.abs() > HUBER { HUBER / residual.abs() } else { 1.0 };
        each(&Cell { column, sin_cos: (sin, cos), here, there, residual, weight, across, down });
    }
}

/// Normal equations of one round.
#[derive(Default)]
struct Fit {
    normal: Matrix6<f64>,
    right: Vector6<f64>,
    products: [f64; 3],
}

impl Fit {
    fn of(a: &[Pattern], b: &[Pattern], motion: &Motion) -> Self {
        let mut fit = Self::default();
        for (a, b) in a.iter().zip(b) {
            let rows = a.values.dim().0;
            // Rows by themselves, added in order: the same bits on any number of threads.
            let parts: Vec<Self> = (0..rows).into_par_iter().map(|r| Self::of_row(a, b, motion, r)).collect();
            parts.iter().for_each(|part| fit.add(part));
        }
        fit
    }

    fn of_row(a: &Pattern, b: &Pattern, motion: &Motion, r: usize) -> Self {
        let mut fit = Self::default();
        let z = a.top_mm + r as f64 * a.cell_mm;
        cells(a, b, motion, r, |cell| {
            // A small motion before this one moves along the wall and down there by nearly as much as here.
            let [along, below] = slopes(a.radius_mm, z, cell.sin_cos.0, cell.sin_cos.1);
            let slope = Vector6::from_fn(|k, _| cell.across * along[k] + cell.down * below[k]);
            fit.normal += cell.weight * slope * slope.transpose();
            fit.right += cell.weight * cell.residual * slope;
            let [ab, aa, bb] = &mut fit.products;
            *ab += cell.here * cell.there;
            *aa += cell.here * cell.here;
            *bb += cell.there * cell.there;
        });
        fit
    }

    fn add(&mut self, other: &Self) {
        self.normal += other.normal;
        self.right += other.right;
        self.products.iter_mut().zip(other.products).for_each(|(a, b)| *a += b);
    }

    /// Turn and shift that better the match; `None` where nothing is seen.
    fn step(&self) -> Option<Vector6<f64>> {
        self.normal.cholesky().map(|c| c.solve(&self.right))
    }

    fn correlation(&self) -> f64 {
        let [ab, aa, bb] = self.products;
        if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
    }
}

#[cfg(test)]
mod tests;
