//! A root system and what is known of it beyond places and radii.

use super::Root;
use super::repair::Repair;
use serde::{Deserialize, Serialize};

/// A root with what is known of its points beyond place and radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TracedRoot {
    /// The root.
    pub root: Root,
    /// Standard deviation of each radius, mm.
    pub radius_sd_mm: Vec<f64>,
    /// Photographs that each radius was measured in; 0 where it stands on the scale of the ridge alone.
    pub views: Vec<u32>,
    /// How well each point is supported, 0 to 1: the share of the photographs that show a root there among those that
    /// look at it unhindered or, where none was asked, its rootness against the median of the system's.
    pub confidence: Vec<f64>,
}

/// A root system and how it came about.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct RootSystem {
    /// The roots; a parent stands before its laterals.
    pub roots: Vec<TracedRoot>,
    /// The photographs' point spread, px, where diameters were measured in them.
    pub spread_px: Option<f64>,
    /// Every change against the bare ridge.
    pub repairs: Vec<Repair>,
}

impl RootSystem {
    /// The roots alone.
    pub fn plain(&self) -> Vec<Root> {
        self.roots.iter().map(|r| r.root.clone()).collect()
    }
}
