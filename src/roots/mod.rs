//! Roots as curves: centrelines with radii, their graph, their traits.

pub mod bridge;
pub mod correction;
pub mod crossing;
pub mod crown;
pub mod curve;
pub mod diameter;
pub mod explain;
pub mod extend;
pub mod hierarchy;
pub mod ink;
pub mod link;
pub mod paint;
pub mod repair;
pub mod ridge;
pub mod strand;
pub mod system;
pub mod tie;
pub mod trace;
pub mod traits;
pub mod tube;

pub use hierarchy::{HierarchyParams, arrange};
pub use repair::Repair;
pub use ridge::{Field, RidgePoint};
pub use system::{RootSystem, TracedRoot};
pub use trace::{Looks, Pieces, TraceParams, trace};

use serde::{Deserialize, Serialize};

/// One root: a polyline from its base to its tip with a radius at every point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Root {
    /// Number of the root, unique in its system.
    pub id: i64,
    /// The root it springs from; -1 for none.
    pub parent: i64,
    /// Branching order: 0 for the taproot, or for all crown roots of a plant without one; 1 for their laterals and so on.
    pub order: u32,
    /// Centreline points in the tank frame, mm.
    #[serde(rename = "points")]
    pub points_mm: Vec<[f64; 3]>,
    /// Radius at each point, mm.
    #[serde(rename = "radii")]
    pub radii_mm: Vec<f64>,
}
