//! Days help each other find roots: one that is sure on a day is looked for on another that misses it.
//!
//! - **Who** ([`wanted`]): roots that are missed on a day and seen on another. Roots do not move and only grow, so a later day's line holds the root
//!   from its base on as far as it had come; the nearest later day that sees it gives the line, else the last earlier one, whose line is there
//!   as a whole.
//! - **Where** ([`contrast`]): the line, brought into the day's frame, is looked at in all photographs of that day: per half millimetre the share of
//!   root on it less that beside it, past the roots that are known there. It may lie a little off, for plants sway: lines shifted sideways
//!   by `OFF_MM` at most are tried. Of a line from its base on, the stretch counts that stands out most, by the mean of its contrasts times the
//!   root of their number: with no contrast beyond the tip that is the least-squares estimate of where the root ends (change of a mean).
//! - **Whether**: the same is asked of [`DECOYS`] copies of the line, each elsewhere at the same depths, where no root is known. The root is there where
//!   it stands out more than all but [`RecallParams::chance`] of these. So noise, veil and background of that very day say what chance
//!   does, and no threshold of another stage does.
//!
//! A lateral is added only where its parent is, as far down as it springs. What is added keeps the radii of the day it comes from.

pub mod contrast;
mod join;
#[cfg(test)]
mod tests;

pub use join::{joined, wanted};

use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3};
use crate::roots::explain::Witness;
use crate::roots::{Root, TracedRoot};
use contrast::{Found, Photographs};
use serde::{Deserialize, Serialize};

/// Whether days help each other find roots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RecallParams {
    /// Look on each day for the roots that only other days show.
    pub enabled: bool,
    /// A root is added where no more than this share of lines that are none stand out as much, 0.025 to 0.5.
    pub chance: f64,
}

impl Default for RecallParams {
    fn default() -> Self {
        Self { enabled: false, chance: 0.03 }
    }
}

impl RecallParams {
    /// Fails where the share is one that the copies cannot tell, or none.
    ///
    /// # Errors
    /// Names the number.
    pub fn check(&self) -> Result<()> {
        if (0.025..=0.5).contains(&self.chance) {
            return Ok(());
        }
        Err(Error::usage(format!("recall.chance is {}", self.chance)).help("give 0.025 to 0.5"))
    }
}

/// Copies of a line that show what chance does: with one in 40 as rare as the rarest that is asked for.
pub const DECOYS: usize = 39;
/// How far a root may lie off its place on the other day, mm, and the steps in between.
const OFF_MM: f64 = 0.8;
const STEP_MM: f64 = 0.4;
/// Distances of the copies from the line, mm, sideways.
const APART_MM: [f64; 2] = [4.0, 12.0];
/// Copies keep so far from the wall, mm.
const WALL_MM: f64 = 2.0;
/// Fewest copies that tell what chance does.
const FEWEST: usize = 20;

/// A root that a day misses.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// The root as another day has it, in the frame of this day, under its common number.
    pub line: TracedRoot,
    /// The day that has it, in order.
    pub by: usize,
    /// Length that is there at least, if it is there, mm: what an earlier day saw.
    pub least_mm: f64,
}

/// A root that was found with another day's help.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recalled {
    /// The root under its common number, in the frame of the first day.
    pub root: TracedRoot,
    /// The day it was found on and the day that told of it, in order.
    pub days: [usize; 2],
    /// Mean over its length of the share of root on it less that beside it, 0 to 1.
    pub contrast: f64,
    /// Share of lines elsewhere that stand out as much, with itself: 1 of 40 at the least.
    pub chance: f64,
}

/// Looks for the wanted roots, parents first, among what the photographs of the day show past the `known` roots of that day.
pub fn recall(
    day: usize,
    known: &[TracedRoot],
    wanted: Vec<Wanted>,
    witnesses: &[Witness<'_>],
    tank: &Tank,
    params: &RecallParams,
) -> Vec<Recalled> {
    let photographs = Photographs::new(witnesses, known);
    let mut recalled: Vec<Recalled> = Vec::new();
    for one in wanted {
        let line = &one.line.root;
        let parent = known.iter().chain(recalled.iter().map(|r| &r.root)).find(|r| r.root.id == line.parent);
        if line.points_mm.len() < 2 || (line.parent >= 0 && !parent.is_some_and(|p| bears(&p.root, line))) {
            continue;
        }
        let Some((shift, found)) = best(&photographs, line, one.least_mm) else { continue };
        let decoys: Vec<f64> = elsewhere(line, tank)
            .iter()
            .filter_map(|copy| best(&photographs, copy, one.least_mm))
            .map(|(_, found)| found.stands_out)
            .collect();
        let as_much = decoys.iter().filter(|other| **other >= found.stands_out).count();
        let chance = (1 + as_much) as f64 / (1 + decoys.len()) as f64;
        if decoys.len() >= FEWEST && chance <= params.chance {
            let root = cut(&one.line, &shift, &found);
            recalled.push(Recalled { root, days: [day, one.by], contrast: found.contrast, chance });
        }
    }
    recalled
}

/// Whether the parent reaches as far as the lateral springs.
fn bears(parent: &Root, lateral: &Root) -> bool {
    /// Ends of traced laterals lie on the parent's surface or a little off it.
    const NEAR_MM: f64 = 3.0;
    let base = Vec3::from(lateral.points_mm[0]);
    let reach = |(p, radius): (&[f64; 3], &f64)| (Vec3::from(*p) - base).norm() <= NEAR_MM + radius;
    parent.points_mm.iter().zip(&parent.radii_mm).any(reach)
}

/// The shift sideways at which a line stands out most.
fn best(photographs: &Photographs<'_>, line: &Root, least_mm: f64) -> Option<(Vec3, Found)> {
    let steps = (OFF_MM / STEP_MM).round() as i32;
    let shifts = (-steps..=steps).flat_map(|x| (-steps..=steps).map(move |y| (x, y)));
    let shifts = shifts.map(|(x, y)| Vec3::new(f64::from(x), f64::from(y), 0.0) * STEP_MM);
    let within = shifts.filter(|shift| shift.norm() <= OFF_MM + 1e-9);
    let all = within.filter_map(|shift| Some((shift, photographs.along(&moved(line, &shift), least_mm)?)));
    all.reduce(|a, b| if b.1.stands_out > a.1.stands_out { b } else { a })
}

/// Copies of a line beside it, all round by the golden angle, which keep off the wall.
fn elsewhere(line: &Root, tank: &Tank) -> Vec<Root> {
    let most = tank.inner_radius_mm() - WALL_MM;
    let copy = |k: usize| {
        let share = ((k as f64 + 0.5) / (2 * DECOYS) as f64).sqrt();
        let far = APART_MM[0] + (APART_MM[1] - APART_MM[0]) * share;
        let (sin, cos) = (k as f64 * std::f64::consts::PI * (3.0 - 5.0_f64.sqrt())).sin_cos();
        moved(line, &(Vec3::new(cos, sin, 0.0) * far))
    };
    let inside = |copy: &Root| copy.points_mm.iter().all(|p| p[0].hypot(p[1]) < most);
    (0..2 * DECOYS).map(copy).filter(inside).take(DECOYS).collect()
}

fn moved(line: &Root, shift: &Vec3) -> Root {
    let points_mm = line.points_mm.iter().map(|p| (Vec3::from(*p) + shift).into()).collect();
    Root { points_mm, ..line.clone() }
}

/// The line as far as the root was found.
fn cut(line: &TracedRoot, shift: &Vec3, found: &Found) -> TracedRoot {
    let root = moved(&line.root, shift);
    let (mut arc_mm, mut last) = (0.0, 1);
    for (k, pair) in root.points_mm.windows(2).enumerate() {
        arc_mm += (Vec3::from(pair[1]) - Vec3::from(pair[0])).norm();
        if arc_mm <= found.length_mm + 1e-9 {
            last = k + 1;
        }
    }
    let n = last + 1;
    let root = Root { points_mm: root.points_mm[..n].to_vec(), radii_mm: root.radii_mm[..n].to_vec(), ..root };
    // Not measured in the photographs of this day.
    let views = vec![0; n];
    TracedRoot { root, radius_sd_mm: line.radius_sd_mm[..n].to_vec(), views, confidence: vec![found.shown; n] }
}
