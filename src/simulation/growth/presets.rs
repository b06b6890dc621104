//! Kinds of root systems to start from.

use super::{GrowthParams, LateralParams, MainParams};
use serde::{Deserialize, Serialize};

/// Kinds of root systems to start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// A taproot with laterals of two orders, as of licorice or rape; at home in a tank of 90 mm radius.
    #[default]
    Taproot,
    /// Many thin main roots from the crown with short laterals, as of grasses.
    Fibrous,
    /// No taproot: some thirty thin crown roots with short fine laterals, a bush of 7 m, as of rice or wheat after two
    /// weeks.
    Rice,
    /// No taproot: fourteen thick crown roots with many laterals of two orders, as of maize.
    Maize,
    /// A thin taproot with many fine laterals close together: the hard case.
    Fine,
}

impl GrowthParams {
    /// The parameters of a preset.
    pub fn preset(preset: Preset) -> Self {
        let taproot = Self {
            preset,
            crown_mm: 3.0,
            crown_offset_mm: 5.0,
            main: MainParams {
                count: 1,
                length_mm: 180.0,
                length_spread: 0.1,
                base_diameter_mm: 3.0,
                diameter_spread: 0.0,
                tip_diameter_mm: 0.6,
                depth_spread_mm: 0.0,
                start_angle_deg: 4.0,
                wander_deg_per_mm: 1.2,
                gravitropism_deg_per_mm: 1.0,
            },
            first_order: LateralParams {
                count: 24,
                zone: [0.04, 0.85],
                length_mm: 100.0,
                length_spread: 0.5,
                base_diameter_mm: [0.9, 1.6],
                tip_diameter_mm: 0.5,
                insertion_angle_deg: 75.0,
                insertion_spread_deg: 15.0,
                wander_deg_per_mm: 2.0,
                gravitropism_deg_per_mm: 0.5,
            },
            second_order: LateralParams {
                count: 46,
                zone: [0.1, 0.8],
                length_mm: 38.0,
                length_spread: 0.6,
                base_diameter_mm: [0.6, 0.9],
                tip_diameter_mm: 0.4,
                insertion_angle_deg: 60.0,
                insertion_spread_deg: 20.0,
                wander_deg_per_mm: 3.0,
                gravitropism_deg_per_mm: 0.2,
            },
        };
        match preset {
            Preset::Taproot => taproot,
            Preset::Fibrous => Self {
                crown_offset_mm: 2.0,
                main: MainParams {
                    count: 18,
                    length_mm: 140.0,
                    length_spread: 0.35,
                    base_diameter_mm: 1.1,
                    tip_diameter_mm: 0.5,
                    start_angle_deg: 70.0,
                    wander_deg_per_mm: 1.5,
                    gravitropism_deg_per_mm: 0.8,
                    ..taproot.main
                },
                first_order: LateralParams {
                    count: 90,
                    zone: [0.1, 0.8],
                    length_mm: 20.0,
                    length_spread: 0.6,
                    base_diameter_mm: [0.4, 0.6],
                    tip_diameter_mm: 0.3,
                    ..taproot.second_order.clone()
                },
                second_order: LateralParams { count: 0, ..taproot.second_order },
                ..taproot
            },
            Preset::Rice => Self {
                crown_mm: 8.0,
                crown_offset_mm: 3.0,
                main: MainParams {
                    count: 32,
                    length_mm: 125.0,
                    length_spread: 0.4,
                    base_diameter_mm: 0.85,
                    diameter_spread: 0.25,
                    tip_diameter_mm: 0.4,
                    depth_spread_mm: 5.0,
                    start_angle_deg: 70.0,
                    wander_deg_per_mm: 1.5,
                    gravitropism_deg_per_mm: 1.0,
                },
                first_order: LateralParams {
                    count: 130,
                    zone: [0.1, 0.8],
                    length_mm: 22.0,
                    length_spread: 0.6,
                    base_diameter_mm: [0.35, 0.5],
                    tip_diameter_mm: 0.3,
                    ..taproot.second_order.clone()
                },
                second_order: LateralParams { count: 0, ..taproot.second_order },
                ..taproot
            },
            Preset::Maize => Self {
                crown_mm: 8.0,
                crown_offset_mm: 3.0,
                main: MainParams {
                    count: 14,
                    length_mm: 150.0,
                    length_spread: 0.3,
                    base_diameter_mm: 1.9,
                    diameter_spread: 0.25,
                    tip_diameter_mm: 0.8,
                    depth_spread_mm: 6.0,
                    start_angle_deg: 60.0,
                    wander_deg_per_mm: 1.2,
                    gravitropism_deg_per_mm: 0.8,
                },
                first_order: LateralParams {
                    count: 110,
                    zone: [0.05, 0.8],
                    length_mm: 32.0,
                    length_spread: 0.6,
                    base_diameter_mm: [0.5, 0.8],
                    tip_diameter_mm: 0.4,
                    ..taproot.first_order
                },
                second_order: LateralParams {
                    count: 30,
                    length_mm: 12.0,
                    base_diameter_mm: [0.4, 0.5],
                    tip_diameter_mm: 0.35,
                    ..taproot.second_order
                },
                ..taproot
            },
            Preset::Fine => Self {
                main: MainParams { base_diameter_mm: 1.4, tip_diameter_mm: 0.5, ..taproot.main },
                first_order: LateralParams {
                    count: 60,
                    length_mm: 75.0,
                    base_diameter_mm: [0.5, 0.8],
                    tip_diameter_mm: 0.35,
                    ..taproot.first_order
                },
                second_order: LateralParams {
                    count: 140,
                    length_mm: 25.0,
                    base_diameter_mm: [0.35, 0.5],
                    tip_diameter_mm: 0.3,
                    ..taproot.second_order
                },
                ..taproot
            },
        }
    }
}
