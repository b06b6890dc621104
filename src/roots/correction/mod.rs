//! Corrections of a traced root system by a person.
//!
//! A correction names what is wrong by places in the tank frame, mm, never by numbers of roots, which change with every
//! setting. Corrections are applied in their order, each to what the ones before left. What changes is only what was asked
//! for: all other roots keep their points, numbers, parents and orders.
//!
//! - **Finding** ([`place`]): a place means the root whose line is nearest, within `within_mm`. Where two roots are about as
//!   near, or none is near, the correction is not applied but reported: settings that changed since may have moved the root.
//!   The ends of `join` and `base` are looked for among the roots' ends alone.
//! - **Editing** ([`tree`]): a root hangs on its parent at the parent's point nearest to its own first point. A root that loses its
//!   parent keeps its order until it is given another; what springs from a root follows its order.
//! - **Reading off** ([`difference`]): the corrections that lead to roots corrected elsewhere.
//! - **Adding** ([`draw`]): through given places or places seen in two or more photographs, moved onto the evidence ([`evidence`]).
//! - **Setting the base** ([`rebase`]): orders are counted anew from the end that is the base.

pub mod difference;
pub mod draw;
pub mod evidence;
pub mod nearest;
pub mod place;
pub mod rebase;
#[cfg(test)]
mod tests;
pub mod tree;

use super::repair::{Kind, Repair};
use super::system::RootSystem;
use crate::error::Result;
use crate::optics::{Vec3, WaterRay};
use evidence::Evidence;
use serde::{Deserialize, Serialize};
use tree::Tree;

/// How corrections find their places.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionParams {
    /// A correction means the root within this of its place, mm, 0.01 to 20; rays of one place seen in several photographs
    /// pass within this of each other.
    pub within_mm: f64,
    /// Points of an added root are moved to the crest of the rootness within this, mm, 0 to 20; 0 leaves them where they are.
    pub snap_mm: f64,
}

impl Default for CorrectionParams {
    fn default() -> Self {
        Self { within_mm: 1.0, snap_mm: 1.0 }
    }
}

/// Where a photograph shows a place.
#[derive(Debug, Clone, PartialEq)]
pub struct Sighting {
    /// Name of the photograph.
    pub photo: String,
    /// Column and row in the undistorted photograph, as overlays and the report show it; the centre of the top-left pixel is
    /// (0, 0).
    pub px: [f64; 2],
}

/// A place of an added root.
#[derive(Debug, Clone, PartialEq)]
pub enum Spot {
    /// Tank frame, mm.
    Place(Vec3),
    /// As two or more photographs show it.
    Seen(Vec<Sighting>),
}

/// What an added root hangs on; places in the tank frame, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Tie {
    /// Nothing: it has order 1.
    Free,
    /// A parent, there.
    Parent(Vec3),
    /// The root that ends there goes on in it.
    Continues(Vec3),
}

/// What is to be changed; places in the tank frame, mm.
#[derive(Debug, Clone, PartialEq)]
pub enum Change {
    /// The root there goes, with all that springs from it.
    Remove {
        /// On the root.
        at: Vec3,
    },
    /// The stretch of one root between two places goes. What lies beyond it, and what springs from it, stay as roots without a parent.
    RemoveStretch {
        /// Where it begins or ends.
        from: Vec3,
        /// Where it ends or begins.
        to: Vec3,
    },
    /// The root there ends; what lies beyond the next point becomes a root without a parent.
    Cut {
        /// On the root.
        at: Vec3,
    },
    /// The ends of two roots are joined to one root.
    Join {
        /// An end of one.
        from: Vec3,
        /// An end of the other.
        to: Vec3,
    },
    /// The root there springs from the one at `parent`, with its nearer end.
    Parent {
        /// On the root.
        at: Vec3,
        /// On its parent.
        parent: Vec3,
    },
    /// The root there has this order.
    Order {
        /// On the root.
        at: Vec3,
        /// Its order.
        order: u32,
    },
    /// The end there is the base of the plant.
    Base {
        /// The end.
        at: Vec3,
    },
    /// A root through these spots, base first.
    Add {
        /// At least two.
        through: Vec<Spot>,
        /// That of the roots of its order when absent.
        diameter_mm: Option<f64>,
        /// What it hangs on.
        tie: Tie,
    },
    /// The root there was looked at and is right.
    Checked {
        /// On the root.
        at: Vec3,
    },
}

impl Change {
    /// The name in files.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Remove { .. } => "remove",
            Self::RemoveStretch { .. } => "remove-stretch",
            Self::Cut { .. } => "cut",
            Self::Join { .. } => "join",
            Self::Parent { .. } => "parent",
            Self::Order { .. } => "order",
            Self::Base { .. } => "base",
            Self::Add { .. } => "add",
            Self::Checked { .. } => "checked",
        }
    }

    /// Where it applies, mm; none where photographs alone tell.
    pub fn place_mm(&self) -> Option<Vec3> {
        match self {
            Self::Remove { at }
            | Self::Cut { at }
            | Self::Parent { at, .. }
            | Self::Order { at, .. }
            | Self::Base { at }
            | Self::Checked { at } => Some(*at),
            Self::RemoveStretch { from, .. } | Self::Join { from, .. } => Some(*from),
            Self::Add { through, .. } => through.iter().find_map(|spot| match spot {
                Spot::Place(at) => Some(*at),
                Spot::Seen(_) => None,
            }),
        }
    }
}

/// A correction with its record.
#[derive(Debug, Clone, PartialEq)]
pub struct Correction {
    /// What is to be changed.
    pub change: Change,
    /// Who says so; may be empty.
    pub by: String,
    /// When, as RFC 3339; may be empty.
    pub when: String,
    /// Why; may be empty.
    pub note: String,
}

/// What became of a correction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Its kind.
    pub kind: String,
    /// Whether it was applied.
    pub applied: bool,
    /// Where, tank frame, mm; none where no place could be told.
    pub place_mm: Option<[f64; 3]>,
    /// What was found there, or why it was not applied.
    pub found: String,
    /// As the correction says.
    pub by: String,
    /// As the correction says.
    pub when: String,
    /// As the correction says.
    pub note: String,
}

/// What corrections are judged by besides the roots themselves.
pub struct World<'a> {
    /// The ray in the water of a sighting.
    pub ray: &'a dyn Fn(&Sighting) -> Result<Option<WaterRay>>,
    /// What added roots are moved onto.
    pub evidence: Option<Evidence<'a>>,
    /// How places are found.
    pub params: CorrectionParams,
}

/// Done: the place and what was found there. Not done: the place, where it is known, and why.
pub(super) type Done = std::result::Result<(Vec3, String), (Option<Vec3>, String)>;

/// The corrected system, and what became of each correction; these stand in its repairs too.
///
/// # Errors
/// Where a sighting names a photograph that is not there.
pub fn correct(system: RootSystem, list: &[Correction], world: &World<'_>) -> Result<(RootSystem, Vec<Outcome>)> {
    let RootSystem { roots, spread_px, mut repairs } = system;
    let mut tree = Tree::new(roots);
    let mut outcomes = Vec::with_capacity(list.len());
    for correction in list {
        let done = one(&mut tree, &correction.change, world)?;
        let applied = done.is_ok();
        let (place, found) = match done {
            Ok((place, found)) => (Some(place), found),
            Err((place, why)) => (place.or(correction.change.place_mm()), why),
        };
        let outcome = Outcome {
            kind: correction.change.kind().to_owned(),
            applied,
            place_mm: place.map(|p| [p.x, p.y, p.z]),
            found,
            by: correction.by.clone(),
            when: correction.when.clone(),
            note: correction.note.clone(),
        };
        let kind = if applied { Kind::Corrected } else { Kind::Uncorrected };
        repairs.push(Repair::new(kind, &place.unwrap_or_else(Vec3::zeros), 0.0, outcome.told()));
        outcomes.push(outcome);
    }
    Ok((RootSystem { roots: tree.finish(), spread_px, repairs }, outcomes))
}

impl Outcome {
    /// All that is known of it in one line.
    pub fn told(&self) -> String {
        let mut text = format!("{}: {}", self.kind, self.found);
        for (word, value) in [("by", &self.by), ("on", &self.when)] {
            if !value.is_empty() {
                text.push_str(&format!("; {word} {value}"));
            }
        }
        if !self.note.is_empty() {
            text.push_str(&format!(" ({})", self.note));
        }
        text
    }
}

fn one(tree: &mut Tree, change: &Change, world: &World<'_>) -> Result<Done> {
    let within = world.params.within_mm;
    Ok(match change {
        Change::Add { through, diameter_mm, tie } => {
            return draw::add(tree, through, *diameter_mm, tie, world);
        }
        Change::Remove { at } => tree.on(at, within).map(|spot| {
            let found = tree.told(&spot);
            let gone = tree.remove(spot.root);
            (*at, if gone > 1 { format!("{found}, and {} springing from it", gone - 1) } else { found })
        }),
        Change::RemoveStretch { from, to } => tree.stretch(from, to, within),
        Change::Cut { at } => tree.on(at, within).and_then(|spot| {
            let found = tree.told(&spot);
            match tree.cut(spot.root, spot.point) {
                true => Ok((*at, found)),
                false => Err((Some(*at), format!("{found}, at its end: there is nothing to cut"))),
            }
        }),
        Change::Join { from, to } => tree.join(from, to, within),
        Change::Parent { at, parent } => tree.on(at, within).and_then(|child| {
            let (found, onto) = (tree.told(&child), tree.on_other(parent, within, Some(child.root))?);
            let on = tree.told(&onto);
            tree.adopt(child.root, onto.root, parent).map_err(|why| (Some(*at), format!("{found}: {why}")))?;
            Ok((*at, format!("{found}; now on a {on}")))
        }),
        Change::Order { at, order } => tree.on(at, within).map(|spot| {
            let found = tree.told(&spot);
            tree.set_order(spot.root, *order);
            (*at, format!("{found}; now of order {order}"))
        }),
        Change::Base { at } => rebase::rebase(tree, at, within),
        Change::Checked { at } => tree.on(at, within).map(|spot| (*at, tree.told(&spot))),
    })
}
