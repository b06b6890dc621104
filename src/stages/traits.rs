//! Measures the traits and writes the root system in the formats that others read.
//! In: system. Out: roots.csv, traits.csv, per_root.csv, depth_profile.csv, roots.rsml, roots.ply,
//! centrelines.ply, roots.glb, roots.swc, repairs.csv, spread_px (of the photographs, where diameters were measured).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{gltf, ply, rsml, swc, tables};
use crate::roots::traits::{TraitParams, depth, per_root, traits};
use crate::roots::{RootSystem, ink};
use serde::Serialize;

/// The traits with their parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Traits {
    /// Depth of the water surface below the rim, mm.
    pub water_level_mm: f64,
    /// Name of the study: the file key of the RSML.
    pub study: String,
    /// Classes, layers, baselines.
    #[serde(flatten)]
    pub params: TraitParams,
}

/// Vertices around a tube.
const SIDES: usize = 8;

impl Stage for Traits {
    const NAME: &'static str = "traits";
    const VERSION: u32 = 4;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let system: RootSystem = inputs.one("system")?.json("system.json")?;
        let roots = system.plain();
        output.bytes("roots.csv", &tables::roots(&system.roots)?)?;
        output.json("spread_px", &system.spread_px)?;
        output.bytes("repairs.csv", &tables::repairs(&system.repairs)?)?;
        let all = traits(&roots, self.water_level_mm, &self.params);
        output.bytes("traits.csv", &tables::traits(&all)?)?;
        let rows = per_root::per_root(&roots, self.water_level_mm, &self.params);
        output.bytes("per_root.csv", &tables::per_root(&rows)?)?;
        let layers = depth::profile(&roots, self.water_level_mm, &self.params);
        output.bytes("depth_profile.csv", &tables::depth_profile(&layers)?)?;
        output.bytes("roots.swc", swc::write(&roots)?.as_bytes())?;
        output.bytes("roots.ply", &ply::tubes(&roots, SIDES, ink::by_root))?;
        output.bytes("centrelines.ply", &ply::centrelines(&roots, ink::by_order))?;
        output.bytes("roots.glb", &gltf::write(&roots, SIDES, ink::by_order)?)?;
        if roots.is_empty() {
            output.warn("no root was traced: RSML needs one, so roots.rsml is left out");
            return Ok(());
        }
        let about = rsml::About {
            last_modified: rsml::PROFILE_DATE.to_owned(),
            software: concat!("rootvox ", env!("CARGO_PKG_VERSION")).to_owned(),
            user: "rootvox".to_owned(),
            file_key: self.study.clone(),
            image: None,
            sequence: None,
        };
        output.bytes("roots.rsml", rsml::write(&system.roots, &about)?.as_bytes())
    }
}
