//! The tank: a vertical cylinder of known wall, filled with water to a known level.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Refractive indices.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Index {
    /// n₁, outside; 1.0 for air.
    pub air: f64,
    /// n₂, the wall; 1.49 for PMMA.
    pub wall: f64,
    /// n₃, the liquid; 1.333 for water.
    pub water: f64,
}

impl Default for Index {
    /// Air, PMMA, water (paper 3).
    fn default() -> Self {
        Self { air: 1.0, wall: 1.49, water: 1.333 }
    }
}

/// Geometry and material of the tank.  Paper 2.2.2, 2.3.1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Tank {
    /// Outer radius r, mm.
    pub radius_mm: f64,
    /// Outer height h, mm: the floor's underside is at z = h.
    pub height_mm: f64,
    /// Thickness τ of wall and floor, mm.
    pub wall_mm: f64,
    /// Depth of the water surface below the rim, mm.
    pub water_level_mm: f64,
    /// Refractive indices.
    pub index: Index,
    /// Opaque bands around the outer wall, [from, to] in z, mm.
    pub belts_mm: Vec<[f64; 2]>,
}

impl Tank {
    /// Inner radius r - τ, mm.
    pub fn inner_radius_mm(&self) -> f64 {
        self.radius_mm - self.wall_mm
    }

    /// z of the inner floor, h - τ, mm.
    pub fn floor_mm(&self) -> f64 {
        self.height_mm - self.wall_mm
    }

    /// Whether the outer wall at height z lets light through: below the rim, above the floor's
    /// underside and outside every belt.
    pub fn is_clear(&self, z_mm: f64) -> bool {
        z_mm >= 0.0 && z_mm <= self.height_mm && !self.belts_mm.iter().any(|b| z_mm >= b[0] && z_mm <= b[1])
    }

    /// Every fault of the description, each naming the number and its remedy.
    ///
    /// # Errors
    /// All faults at once, as [`Error::many`].
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        for (name, value, positive) in [
            ("radius", self.radius_mm, true),
            ("height", self.height_mm, true),
            ("wall", self.wall_mm, true),
            ("water_level", self.water_level_mm, false),
        ] {
            if !value.is_finite() || value < 0.0 || (positive && value == 0.0) {
                faults.push(Error::usage(format!("tank.{name} is {value} mm")).help("give a positive length in mm"));
            }
        }
        if self.wall_mm >= self.radius_mm {
            faults.push(
                Error::usage(format!(
                    "tank.wall ({} mm) is not thinner than tank.radius ({} mm)",
                    self.wall_mm, self.radius_mm
                ))
                .help("`radius` is the outer radius of the tank, `wall` the thickness of its wall"),
            );
        }
        if self.water_level_mm >= self.floor_mm() && self.height_mm > self.wall_mm {
            faults.push(
                Error::usage(format!(
                    "tank.water_level ({} mm) lies below the inner floor ({} mm)",
                    self.water_level_mm,
                    self.floor_mm()
                ))
                .help("`water_level` is the depth of the water surface below the rim"),
            );
        }
        for (name, n) in [("air", self.index.air), ("wall", self.index.wall), ("water", self.index.water)] {
            if !(1.0..=3.0).contains(&n) {
                faults.push(
                    Error::usage(format!("tank.index.{name} is {n}")).help("refractive indices lie between 1 and 3"),
                );
            }
        }
        for b in &self.belts_mm {
            if !(b[0].is_finite() && b[1].is_finite() && b[0] < b[1]) {
                faults.push(
                    Error::usage(format!("tank.belts holds [{}, {}]", b[0], b[1]))
                        .help("give each belt as [z_from, z_to] in mm, z_from < z_to"),
                );
            }
        }
        Error::many(faults)
    }
}
