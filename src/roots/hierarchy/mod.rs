//! Pieces become roots: who hangs on whom, where a root goes on and what springs from it.
//!
//! - **Support** ([`support`]): pieces that most photographs do not show are left out.
//! - **Base** ([`base`]): of the pieces near the top of what is seen the one from which the thickest way leads down farthest.
//! - **Hanging** ([`attach`]): every piece hangs by one tie. Ties lead from a piece's own end, rather the thicker one, on to
//!   another piece, rather a thicker one; for more, a piece may hang by its body on another's end, or by a crossing; an end
//!   that runs out of sight may hang on the hidden crown above or, for more, on the base root below; a piece that passes
//!   through a thicker one may spring there to both sides. Of all ways to hang all pieces the cheapest is taken (an
//!   arborescence: [`arborescence`]), so a ring is opened at its most costly tie.
//! - **Going on** ([`walk`]): ridges do not know which branch of a junction is the root: walked from the base, a root
//!   goes on, wherever something hangs, in the branch that bends least, keeps its thickness and leads farthest:
//!   the greatest `− ½ (bend / bend_deg)² − ½ (ln (thickness ratio) / thinner)² + ½ ln reach`, each term limited; for the base
//!   root, which grows downwards, also `− ½ (angle to the vertical / down_deg)²`. The others are its laterals.
//! - **Crown** ([`crown`]): a base root that is no thicker than what else runs out of sight upwards is no taproot; all these are
//!   of order 0.
//! - **Rejoining** ([`rejoin`]): roots that seem to end at a crossing go on in what lies beyond.
//! - **Drawing** ([`draw`]): one smooth line each. A lateral that springs where its parent still runs along an older root
//!   hangs on that one. Left out are tips that few photographs show, roots that few see past others, specks, spurs; numbers by
//!   order, parents first.

pub mod arborescence;
pub mod attach;
pub mod base;
pub mod crown;
pub mod draw;
pub mod part;
pub mod passing;
pub mod rejoin;
pub mod support;
#[cfg(test)]
mod tests;
pub mod walk;

use super::system::{RootSystem, TracedRoot};
use super::trace::Pieces;
use crate::error::{Error, Result};
use crate::optics::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How roots are told apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct HierarchyParams {
    /// A piece is a root when at least this share of the photographs that look at it unhindered show one, 0 to 1; a root
    /// ends where so many show it last.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub shown: f64,
    /// A root without laterals stays when the photographs that measure it are on average at least this share of those that
    /// measure the plant's roots in the median, 0 to 1; points that none measures count as 0, the way from the parent too.
    /// What only few see past other roots may be their chance meeting.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub seen: f64,
    /// Hanging on what is hidden above costs as much as a tie of this cost, mm, 0 to 100; below `by_body_mm` more.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub unseen_mm: f64,
    /// Hanging by an end as thick as the other one costs as much as a tie of this cost, mm, 0 to 100; by an end that is
    /// thicker less, since roots taper towards their tips.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub taper_mm: f64,
    /// Hanging on a root as thick as the piece costs as much as a tie of this cost, mm, 0 to 100; on a thinner one more, on a
    /// thicker one less.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub thicker_mm: f64,
    /// Hanging by the body instead of an own end costs as much as a tie of this cost, mm, 0 to 100.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub by_body_mm: f64,
    /// Standard deviation of the base root's direction against straight down, degrees, 1 to 90: it grows downwards.
    #[schemars(range(min = 1.0, max = 90.0))]
    pub down_deg: f64,
    /// Standard deviation of a root's own bends over `trace.smooth_mm`, degrees, 1 to 90.
    #[schemars(range(min = 1.0, max = 90.0))]
    pub bend_deg: f64,
    /// Standard deviation of the logarithm of a root's thickness along it, as measured, 0.01 to 2.
    #[schemars(range(min = 0.01, max = 2.0))]
    pub thinner: f64,
    /// Shortest piece that hangs on nothing, mm.
    #[schemars(range(min = 0.0))]
    pub speck_mm: f64,
    /// Shortest lateral beyond its parent's surface, in radii of the parent, 0 to 20 (and no shorter than a link).
    #[schemars(range(min = 0.0, max = 20.0))]
    pub spur_radii: f64,
}

impl Default for HierarchyParams {
    fn default() -> Self {
        Self {
            shown: 0.5,
            seen: 0.25,
            unseen_mm: 3.0,
            taper_mm: 1.0,
            thicker_mm: 1.0,
            by_body_mm: 6.0,
            down_deg: 45.0,
            bend_deg: 20.0,
            thinner: 0.25,
            speck_mm: 6.0,
            spur_radii: 3.0,
        }
    }
}

/// Makes roots of the pieces.
///
/// # Errors
/// Where a parameter is out of range.
pub fn arrange(pieces: &Pieces, params: &HierarchyParams) -> Result<RootSystem> {
    for (name, value) in [("bend_deg", params.bend_deg), ("down_deg", params.down_deg), ("thinner", params.thinner)] {
        if !(value.is_finite() && value > 0.0) {
            return Err(Error::usage(format!("hierarchy.{name} is {value}")).help("give a positive number"));
        }
    }
    let mut repairs = pieces.repairs.clone();
    let pieces = &support::supported(pieces, params, &mut repairs);
    let lines: Vec<Line<'_>> = pieces.pieces.iter().map(Line::new).collect();
    let passings = passing::passings(&lines, pieces.link_mm);
    let grow = |base: usize| {
        let mut log = Vec::new();
        let hangs = attach::attach(pieces, &lines, &passings, base, params, &mut log);
        let grown = walk::walk(&lines, base, &hangs, pieces, params);
        (base::seen_from_side(&lines, &grown[0].parts).0, grown, log)
    };
    let tried = base::candidates(&lines).into_iter().map(grow);
    let Some((_, mut grown, log)) = tried.reduce(|best, next| if next.0 > best.0 { next } else { best }) else {
        return Ok(RootSystem { roots: Vec::new(), spread_px: pieces.spread_px, repairs });
    };
    repairs.extend(log);
    crown::share(&lines, pieces, &mut grown, &mut repairs);
    let grown = rejoin::rejoin(&lines, grown, pieces, &mut repairs);
    let roots = draw::draw(&lines, grown, pieces, params, &mut repairs);
    Ok(RootSystem { roots, spread_px: pieces.spread_px, repairs })
}

/// A piece with the arc position of its points.
#[derive(Debug)]
pub struct Line<'a> {
    /// The piece.
    pub piece: &'a TracedRoot,
    /// Arc length from the first point to each, mm.
    pub arc_mm: Vec<f64>,
}

impl<'a> Line<'a> {
    fn new(piece: &'a TracedRoot) -> Self {
        Self { piece, arc_mm: super::curve::chord_lengths(&piece.root.points_mm) }
    }

    fn at(&self, k: usize) -> Vec3 {
        Vec3::from(self.piece.root.points_mm[k])
    }

    fn radius_mm(&self, k: usize) -> f64 {
        self.piece.root.radii_mm[k]
    }

    fn last(&self) -> usize {
        self.arc_mm.len() - 1
    }

    fn length_mm(&self) -> f64 {
        self.arc_mm[self.last()]
    }

    /// The point at the given way from point `k` towards an end, or the end.
    fn beyond(&self, k: usize, towards: super::strand::End, way_mm: f64) -> usize {
        match towards {
            super::strand::End::First => {
                let s = self.arc_mm[k] - way_mm;
                self.arc_mm[..=k].partition_point(|a| *a < s)
            }
            super::strand::End::Last => {
                let s = self.arc_mm[k] + way_mm;
                (k + self.arc_mm[k..].partition_point(|a| *a < s)).min(self.last())
            }
        }
    }

    /// Median radius between two points, mm.
    fn typical_radius_mm(&self, a: usize, b: usize) -> f64 {
        let mut radii = self.piece.root.radii_mm[a.min(b)..=a.max(b)].to_vec();
        radii.sort_by(f64::total_cmp);
        radii[radii.len() / 2]
    }
}
