//! `tank.json`: outer radius `r`, height `h`, wall thickness `tau`, depth `z_w` of the water surface
//! (all mm), refractive indices `n_air`, `n_wall`, `n_water`, and optionally the opaque `belts`.

use super::json;
use crate::error::{Error, Result};
use crate::optics::{Index, Tank};
use serde::{Deserialize, Serialize};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    r: f64,
    h: f64,
    tau: f64,
    n_air: f64,
    n_wall: f64,
    n_water: f64,
    z_w: f64,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    belts: Vec<[f64; 2]>,
}

/// Reads the content of a `tank.json`.
///
/// # Errors
/// Where the text has another form; whether the numbers make a tank is [`Tank::check`]'s to say.
pub fn parse(name: &str, text: &str) -> Result<Tank> {
    let f: File = json::parse(name, text)?;
    Ok(Tank {
        radius_mm: f.r,
        height_mm: f.h,
        wall_mm: f.tau,
        water_level_mm: f.z_w,
        index: Index { air: f.n_air, wall: f.n_wall, water: f.n_water },
        belts_mm: f.belts,
    })
}

/// The content of a `tank.json`.
///
/// # Errors
/// Where a number is not finite.
pub fn write(tank: &Tank) -> Result<String> {
    serde_json::to_string_pretty(&File {
        r: tank.radius_mm,
        h: tank.height_mm,
        tau: tank.wall_mm,
        n_air: tank.index.air,
        n_wall: tank.index.wall,
        n_water: tank.index.water,
        z_w: tank.water_level_mm,
        belts: tank.belts_mm.clone(),
    })
    .map_err(|e| Error::failed(format!("tank.json: {e}")))
}
