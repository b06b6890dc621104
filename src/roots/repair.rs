//! The log of what the tracing changed against the bare ridge, each entry with its place and reason.

use crate::optics::Vec3;
use serde::{Deserialize, Serialize};

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A gap between two pieces of one root was closed.
    Bridged,
    /// A loose end was followed further.
    Extended,
    /// At a junction branches changed partners, or a root its parent.
    Repaired,
    /// A closed way was opened.
    Opened,
    /// A piece was cut in two: where it crosses the root that both halves spring from, or over the crown.
    Split,
    /// A piece was left out.
    Pruned,
    /// A root was tied to its parent over a stretch that shows no ridge.
    Attached,
    /// A root's parent was inferred without a visible tie.
    Inferred,
    /// A person's correction was applied.
    Corrected,
    /// A person's correction did not find its place.
    Uncorrected,
}

impl Kind {
    /// The name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bridged => "bridged",
            Self::Extended => "extended",
            Self::Repaired => "repaired",
            Self::Opened => "opened",
            Self::Split => "split",
            Self::Pruned => "pruned",
            Self::Attached => "attached",
            Self::Inferred => "inferred",
            Self::Corrected => "corrected",
            Self::Uncorrected => "uncorrected",
        }
    }
}

/// One entry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Repair {
    /// What was done.
    pub kind: Kind,
    /// Where, tank frame, mm.
    pub place_mm: [f64; 3],
    /// Length of the gap closed or of the piece left out, mm; 0 where that has no meaning.
    pub length_mm: f64,
    /// Why, with the numbers that decided.
    pub reason: String,
}

impl Repair {
    /// An entry.
    pub fn new(kind: Kind, place: &Vec3, length_mm: f64, reason: String) -> Self {
        Self { kind, place_mm: [place.x, place.y, place.z], length_mm, reason }
    }
}
