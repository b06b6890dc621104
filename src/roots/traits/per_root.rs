//! Traits of each root.

use super::{Step, TraitParams, steps, topology};
use crate::optics::Vec3;
use crate::roots::{Root, curve};
use serde::{Serialize, Serializer};

/// Columns of `per_root.csv`: the fields of [`PerRoot`] in their order.
pub const COLUMNS: [&str; 18] = [
    "root_id",
    "parent_id",
    "order",
    "length_mm",
    "tortuosity",
    "mean_diameter_mm",
    "base_diameter_mm",
    "tip_diameter_mm",
    "volume_mm3",
    "surface_area_mm2",
    "insertion_mm",
    "insertion_angle_deg",
    "emergence_angle_deg",
    "midpoint_angle_deg",
    "tip_angle_deg",
    "laterals",
    "lateral_density_per_mm",
    "tip_depth_mm",
];

/// A row of `per_root.csv`; NaN where a trait has no meaning (no parent).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PerRoot {
    /// Number.
    pub root_id: i64,
    /// Parent's number; -1 for none.
    pub parent_id: i64,
    /// Branching order.
    pub order: u32,
    /// Arc length of the centreline, mm.
    pub length_mm: f64,
    /// Path over chord of base and tip, ≥ 1.
    #[serde(serialize_with = "finite")]
    pub tortuosity: f64,
    /// Length-weighted mean, mm.
    #[serde(serialize_with = "finite")]
    pub mean_diameter_mm: f64,
    /// At the first point, mm.
    pub base_diameter_mm: f64,
    /// At the last point, mm.
    pub tip_diameter_mm: f64,
    /// mm³.
    pub volume_mm3: f64,
    /// mm².
    pub surface_area_mm2: f64,
    /// Arc position on the parent, from its base, mm.
    #[serde(serialize_with = "finite")]
    pub insertion_mm: f64,
    /// Between the root's first stretch and the parent's direction towards its tip there, degrees.
    #[serde(serialize_with = "finite")]
    pub insertion_angle_deg: f64,
    /// Between the first stretch and straight down, degrees.
    #[serde(serialize_with = "finite")]
    pub emergence_angle_deg: f64,
    /// Between the middle stretch and straight down, degrees.
    #[serde(serialize_with = "finite")]
    pub midpoint_angle_deg: f64,
    /// Between the last stretch and straight down, degrees.
    #[serde(serialize_with = "finite")]
    pub tip_angle_deg: f64,
    /// Roots that spring from it.
    pub laterals: usize,
    /// Laterals over length, 1/mm.
    #[serde(serialize_with = "finite")]
    pub lateral_density_per_mm: f64,
    /// Depth of the tip under the water surface, mm.
    pub tip_depth_mm: f64,
}

/// An empty cell instead of NaN or infinity.
fn finite<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    value.is_finite().then_some(*value).serialize(serializer)
}

/// Unit direction over the stretch of `length` about arc position `s`.
fn direction(root: &Root, s: f64, length: f64) -> Option<Vec3> {
    let arc = curve::chord_lengths(&root.points_mm);
    let at = |s: f64| {
        let after = arc.iter().position(|a| *a >= s).unwrap_or(arc.len() - 1).max(1);
        let f = ((s - arc[after - 1]) / (arc[after] - arc[after - 1]).max(1e-12)).clamp(0.0, 1.0);
        let (a, b) = (Vec3::from(root.points_mm[after - 1]), Vec3::from(root.points_mm[after]));
        a + (b - a) * f
    };
    if root.points_mm.len() < 2 {
        return None;
    }
    (at(s + 0.5 * length) - at(s - 0.5 * length)).try_normalize(1e-9)
}

fn degrees(a: Option<Vec3>, b: Option<Vec3>) -> f64 {
    match (a, b) {
        (Some(a), Some(b)) => a.dot(&b).clamp(-1.0, 1.0).acos().to_degrees(),
        _ => f64::NAN,
    }
}

/// One row per root, in their order.
pub fn per_root(roots: &[Root], water_level_mm: f64, params: &TraitParams) -> Vec<PerRoot> {
    let row = |root: &Root| {
        let steps = steps(std::slice::from_ref(root));
        let length_mm = topology::length_mm(root);
        let parent = roots.iter().find(|r| r.id == root.parent);
        let insertion_mm = parent.map_or(f64::NAN, |p| topology::insertion_mm(root, p));
        let half = 0.5 * params.angle_mm.min(length_mm);
        let first = direction(root, half, 2.0 * half);
        let down = Some(Vec3::z());
        let end = |k: Option<&[f64; 3]>| k.map_or(Vec3::repeat(f64::NAN), |p| Vec3::from(*p));
        let (base, tip) = (end(root.points_mm.first()), end(root.points_mm.last()));
        let laterals = roots.iter().filter(|r| r.parent == root.id).count();
        PerRoot {
            root_id: root.id,
            parent_id: root.parent,
            order: root.order,
            length_mm,
            tortuosity: length_mm / (tip - base).norm(),
            mean_diameter_mm: steps.iter().map(|s| s.diameter() * s.length()).sum::<f64>() / length_mm,
            base_diameter_mm: root.radii_mm.first().map_or(f64::NAN, |r| 2.0 * r),
            tip_diameter_mm: root.radii_mm.last().map_or(f64::NAN, |r| 2.0 * r),
            volume_mm3: steps.iter().map(Step::volume).sum(),
            surface_area_mm2: steps.iter().map(Step::area).sum(),
            insertion_mm,
            insertion_angle_deg: degrees(first, parent.and_then(|p| direction(p, insertion_mm, params.angle_mm))),
            emergence_angle_deg: degrees(first, down),
            midpoint_angle_deg: degrees(direction(root, 0.5 * length_mm, 2.0 * half), down),
            tip_angle_deg: degrees(direction(root, length_mm - half, 2.0 * half), down),
            laterals,
            lateral_density_per_mm: laterals as f64 / length_mm,
            tip_depth_mm: tip.z - water_level_mm,
        }
    };
    roots.iter().map(row).collect()
}
