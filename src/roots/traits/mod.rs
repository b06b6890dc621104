//! Traits: what a root system measures, one definition each ([`glossary`] and docs/roots.md list them all).
//!
//! Lengths in mm, areas in mm², volumes in mm³, angles in degrees; depth is counted from the water surface, down.
//! A centreline is a chain of straight steps; a step's diameter is the mean of its ends', a step of diameters d₁, d₂ and
//! length ds has the surface π (d₁ + d₂) / 2 · ds and the volume π (d₁² + d₁d₂ + d₂²) / 12 · ds (truncated cone).
//! What belts hide does not count: traits are of what was traced.

pub mod depth;
pub mod glossary;
pub mod hull;
pub mod per_root;
pub mod shape;
pub mod spread;
pub mod topology;

use super::Root;
use crate::optics::Vec3;
use serde::{Deserialize, Serialize};

/// What traits are counted by.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TraitParams {
    /// Borders between diameter classes, mm, rising; the last class is open.
    pub classes_mm: Vec<f64>,
    /// Thickness of the layers of the depth profile, mm, 0.1 to 1000.
    pub layer_mm: f64,
    /// Length over which a root's direction is taken for angles, mm, 0.5 to 100.
    pub angle_mm: f64,
    /// Random halves of the photographs from which everything is reconstructed again to tell how certain the traits
    /// are; 0 for none, 2 to 1000. Each costs about as much as the reconstruction.
    pub resample: usize,
}

impl Default for TraitParams {
    fn default() -> Self {
        Self { classes_mm: vec![0.5, 1.0, 1.5, 2.0], layer_mm: 10.0, angle_mm: 5.0, resample: 0 }
    }
}

/// A named number; the name ends in its unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trait {
    /// Name with unit, such as `total_root_length_mm`.
    pub name: String,
    /// Value; NaN where it is not defined (no roots, flat hull).
    pub value: f64,
}

/// A straight step of a centreline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Its ends, mm.
    pub ends: [Vec3; 2],
    /// Diameters there, mm.
    pub diameters: [f64; 2],
    /// Order of its root.
    pub order: u32,
}

impl Step {
    /// Length, mm.
    pub fn length(&self) -> f64 {
        (self.ends[1] - self.ends[0]).norm()
    }

    /// Mean diameter, mm.
    pub fn diameter(&self) -> f64 {
        0.5 * (self.diameters[0] + self.diameters[1])
    }

    /// Surface, mm².
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.diameter() * self.length()
    }

    /// Volume, mm³.
    pub fn volume(&self) -> f64 {
        let [a, b] = self.diameters;
        std::f64::consts::PI / 12.0 * (a * a + a * b + b * b) * self.length()
    }

    /// Height of its middle, mm.
    pub fn z(&self) -> f64 {
        0.5 * (self.ends[0].z + self.ends[1].z)
    }
}

/// All steps of all roots.
pub fn steps(roots: &[Root]) -> Vec<Step> {
    let of = |root: &Root| -> Vec<Step> {
        (1..root.points_mm.len())
            .map(|k| Step {
                ends: [Vec3::from(root.points_mm[k - 1]), Vec3::from(root.points_mm[k])],
                diameters: [2.0 * root.radii_mm[k - 1], 2.0 * root.radii_mm[k]],
                order: root.order,
            })
            .collect()
    };
    roots.iter().flat_map(of).collect()
}

/// The traits of a root system whose water surface lies at `water_level_mm`, in the order of the table.
pub fn traits(roots: &[Root], water_level_mm: f64, params: &TraitParams) -> Vec<Trait> {
    let steps = steps(roots);
    let mut all = Vec::new();
    let mut put = |name: &str, value: f64| all.push(Trait { name: name.to_string(), value });
    let sum = |of: fn(&Step) -> f64| steps.iter().map(of).sum::<f64>();
    let (length, area, volume) = (sum(Step::length), sum(Step::area), sum(Step::volume));
    put("total_root_length_mm", length);
    put("root_volume_mm3", volume);
    put("surface_area_mm2", area);
    put("mean_diameter_mm", steps.iter().map(|s| s.diameter() * s.length()).sum::<f64>() / length);
    let mut diameters: Vec<(f64, f64)> = steps.iter().map(|s| (s.diameter(), s.length())).collect();
    put("median_diameter_mm", weighted_quantile(&mut diameters, 0.5));
    put("max_diameter_mm", diameters.last().map_or(f64::NAN, |d| d.0));
    put("specific_root_length_mm_per_mm3", length / volume);
    classes(&steps, &params.classes_mm, &mut put);
    topology::traits(roots, length, &mut put);
    depth::traits(&steps, roots, water_level_mm, &mut put);
    shape::traits(roots, volume, &mut put);
    all
}

/// Length, area and volume by diameter class.
fn classes(steps: &[Step], borders: &[f64], put: &mut impl FnMut(&str, f64)) {
    for (what, unit, of) in [
        ("length", "mm", Step::length as fn(&Step) -> f64),
        ("area", "mm2", Step::area),
        ("volume", "mm3", Step::volume),
    ] {
        for k in 0..=borders.len() {
            let from = if k == 0 { 0.0 } else { borders[k - 1] };
            let to = borders.get(k).copied().unwrap_or(f64::INFINITY);
            let value = steps.iter().filter(|s| s.diameter() >= from && s.diameter() < to).map(of).sum();
            let range = if to.is_finite() { format!("{from}_to_{to}") } else { format!("over_{from}") };
            put(&format!("{what}_diameter_{range}_{unit}"), value);
        }
    }
}

/// The value up to which a share of the weight lies; sorts. NaN for none.
pub fn weighted_quantile(values: &mut [(f64, f64)], share: f64) -> f64 {
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole: f64 = values.iter().map(|v| v.1).sum();
    let mut sum = 0.0;
    for &(value, weight) in values.iter() {
        sum += weight;
        if sum >= share * whole {
            return value;
        }
    }
    f64::NAN
}

#[cfg(test)]
mod tests;
