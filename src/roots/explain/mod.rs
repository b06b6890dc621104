//! Roots judged by what they account for in the photographs.
//!
//! Where roots are many, chance lines them up: the merge shows ridges at which every photograph sees *some* root. And true roots lie
//! behind others in most photographs. Both look alike when each piece is judged by itself. They differ in what happens
//! to the photographs when one is left out: a ghost's pixels are accounted for by the roots that made it; a
//! true root leaves pixels that nothing explains.
//!
//! - **Beads** ([`beads`]): every traced piece as points half a millimetre apart; each photograph's look at each bead with the share
//!   of root that it shows there ([`look`]).
//! - **Tubes** ([`tubes`]): beads drawn into a photograph as opaque tubes, blurred ([`cover`]).
//! - **Widths** ([`width`]) from the photographs' own shares, first from their narrowest views, then from those past all other roots.
//! - **Overlap** ([`overlap`]): with the share `m` that a photograph shows at a bead, the share `o` that others account for and the
//!   share `e` that the bead would, it tells `[(m − o)² − (m − max(o, e))²] / 2 s²` for the bead: a logarithm of likelihood,
//!   limited and weighted with its confidence, at the bead's middle and at its sides, so that a tube beside its root tells
//!   less than one in it. A photograph in which the bead hides behind others says nothing.
//! - **Choice** ([`choose`], [`gain`], [`stretch`]): a description should be short. A step of a root costs what `photographs` of them can tell
//!   for it, an end of a piece costs `end` of what all can, and breaking a piece costs `cut` of it at either end. The set of
//!   stretches that is worth most is sought as a whole, by mean field with falling heat and an exchange piece by piece.
//!
//! Reason of the costs: two-part description length (Rissanen 1978). As in difference matting the photographs' shares are
//! measurements; the model is that of opaque tubes, which roots in water are.

pub mod beads;
pub mod choose;
pub mod cover;
pub mod gain;
pub mod look;
pub mod overlap;
pub mod stretch;
pub mod tubes;
pub mod width;

#[cfg(test)]
pub(crate) mod tests;

use super::link::tree_of;
use super::ridge::RidgePoint;
use super::system::TracedRoot;
use crate::error::{Error, Result};
use crate::optics::{Vec3, ViewMap};
use beads::Chain;
use cover::Cover;
use look::Looking;
use ndarray::ArrayView3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// How roots are judged by what they account for.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExplainParams {
    /// Judge by what the photographs need; `false` leaves the judgement to `hierarchy.shown` and `hierarchy.seen`.
    pub enabled: bool,
    /// A stretch of root stays when more than this many photographs need it, each as far as one can tell, 0 to 100: one
    /// alone fixes no place.
    pub photographs: f64,
    /// ... and more than this share of all photographs, 0 to 1: the more look, the more are wrong by chance.
    pub share: f64,
    /// An end of a piece costs as much as a step that this share of all photographs needs, 0 to 100: roots are rather long than many.
    pub end: f64,
    /// An end within a piece costs so much: a ridge breaks off where photographs speak against it, not where they tell little.
    pub cut: f64,
}

impl Default for ExplainParams {
    fn default() -> Self {
        Self { enabled: true, photographs: 1.5, share: 0.06, end: 0.25, cut: 1.0 }
    }
}

impl ExplainParams {
    /// Fails where a value is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self) -> Result<()> {
        let ranges = [
            ("photographs", self.photographs, 100.0),
            ("share", self.share, 1.0),
            ("end", self.end, 100.0),
            ("cut", self.cut, 100.0),
        ];
        let faults = ranges.into_iter().filter(|(_, value, most)| !(0.0..=*most).contains(value));
        Error::many(
            faults
                .map(|(name, value, most)| {
                    Error::usage(format!("explain.{name} is {value}")).help(format!("give 0 to {most}"))
                })
                .collect(),
        )
    }
}

/// A photograph's evidence with its way of seeing.
#[derive(Debug, Clone, Copy)]
pub struct Witness<'a> {
    /// From the water to the undistorted photograph's pixels.
    pub map: &'a ViewMap,
    /// (y, x, [share, confidence, 0]) as [`crate::photo::evidence::share::share`] gives it.
    pub evidence: ArrayView3<'a, u8>,
    /// Point spread of the evidence, px.
    pub spread_px: f64,
}

/// What the photographs need of the pieces, as lines in the tank frame, mm.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Explained {
    /// Stretches that they need.
    pub kept: Vec<Vec<[f64; 3]>>,
    /// Stretches that others account for, or that they speak against.
    pub left: Vec<Vec<[f64; 3]>>,
}

/// How far from a bead a ridge point may lie and still be of its piece, in voxels: lines are smooth, points lie on voxels.
const BESIDE: f64 = 2.0;

impl Explained {
    /// The ridge points that belong to what is needed, and those that belong to no candidate and are followed from loose ends.
    pub fn needed(&self, points: Vec<RidgePoint>, spacing_mm: f64) -> Vec<RidgePoint> {
        let beads = |lines: &[Vec<[f64; 3]>]| -> Vec<Vec3> { lines.iter().flatten().map(|p| Vec3::from(*p)).collect() };
        let (kept, left) = (beads(&self.kept), beads(&self.left));
        let tree = tree_of(kept.iter().chain(&left).enumerate());
        let nearest = |p: &RidgePoint| {
            let found = tree.nearest_neighbor([p.position_mm.x, p.position_mm.y, p.position_mm.z])?;
            let way = Vec3::from(*found.geom()) - p.position_mm;
            (way.norm() <= BESIDE * spacing_mm).then_some(found.data)
        };
        points.into_iter().filter(|p| nearest(p).map_or(!p.strong, |bead| bead < kept.len())).collect()
    }
}

/// Judges the pieces by the photographs.
///
/// # Errors
/// Where a parameter is out of range.
pub fn explain(pieces: &[TracedRoot], witnesses: &[Witness<'_>], params: &ExplainParams) -> Result<Explained> {
    params.check()?;
    let chain = Chain::new(pieces.iter().map(|p| &p.root.points_mm[..]));
    let looking: Vec<Looking<'_>> = witnesses
        .par_iter()
        .map(|witness| Looking {
            witness: *witness,
            cover: Cover::new(witness.spread_px),
            looks: look::looks(witness, &chain),
        })
        .collect();
    let kept = choose::choose(&chain, &looking, params);
    let mut explained = Explained::default();
    for range in &chain.pieces {
        let mut from = range.start;
        while from < range.end {
            let same = kept[from..range.end].iter().take_while(|&&k| k == kept[from]).count();
            let line = chain.places[from..from + same].iter().map(|p| (*p).into()).collect();
            if kept[from] {
                explained.kept.push(line)
            } else {
                explained.left.push(line)
            }
            from += same;
        }
    }
    Ok(explained)
}
