//! What a plant scientist says of a root system: numbers, lengths, diameters, angles, by branching order.

use super::Preset;
use crate::error::{Error, Result};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

/// Longest root, mm: no cylinder that is photographed holds more.
const MAX_LENGTH_MM: f64 = 10_000.0;

/// The main roots, which start at the crown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MainParams {
    /// Number of main roots: 1 for a taproot, more for a fibrous system.
    pub count: usize,
    /// Mean length, mm.
    pub length_mm: f64,
    /// Relative spread of the lengths: uniform within ± this share, 0..1.
    pub length_spread: f64,
    /// Mean diameter at the base, mm.
    pub base_diameter_mm: f64,
    /// Relative spread of the base diameters: uniform within ± this share, 0..0.9.
    pub diameter_spread: f64,
    /// Diameter at the tip, mm; never over the base's.
    pub tip_diameter_mm: f64,
    /// Main roots start up to this far below the crown, mm: those of a stem's nodes.
    pub depth_spread_mm: f64,
    /// Largest angle to the vertical at which a main root starts, degrees 0..90.
    pub start_angle_deg: f64,
    /// Standard deviation of the curvature, degrees per mm.
    pub wander_deg_per_mm: f64,
    /// Rate at which a horizontal root turns down, degrees per mm.
    pub gravitropism_deg_per_mm: f64,
}

/// The laterals of one order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LateralParams {
    /// Number of laterals over all parents, shared out by the parents' lengths.
    pub count: usize,
    /// Part of the parent that bears laterals: [from, to] as shares of its length, 0 base, 1 tip.
    pub zone: [f64; 2],
    /// Mean length, mm.
    pub length_mm: f64,
    /// Relative spread of the lengths: uniform within ± this share, 0..1.
    pub length_spread: f64,
    /// Diameter at the base, mm: uniform within [from, to]; never over the parent's there.
    pub base_diameter_mm: [f64; 2],
    /// Diameter at the tip, mm.
    pub tip_diameter_mm: f64,
    /// Angle to the parent at the insertion, degrees 0..180.
    pub insertion_angle_deg: f64,
    /// Spread of that angle: uniform within ± this, degrees.
    pub insertion_spread_deg: f64,
    /// Standard deviation of the curvature, degrees per mm.
    pub wander_deg_per_mm: f64,
    /// Rate at which a horizontal root turns down, degrees per mm.
    pub gravitropism_deg_per_mm: f64,
}

/// How a root system grows. In a file, what is not given is that of the `preset`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GrowthParams {
    /// The root system to start from.
    pub preset: Preset,
    /// Depth of the crown below the rim, mm: where the main roots start, near the axis.
    pub crown_mm: f64,
    /// Greatest distance of the crown from the tank's axis, mm.
    pub crown_offset_mm: f64,
    /// Order 0.
    pub main: MainParams,
    /// Order 1: laterals of the main roots.
    pub first_order: LateralParams,
    /// Order 2: laterals of the first-order laterals.
    pub second_order: LateralParams,
}

impl Default for GrowthParams {
    /// The taproot.
    fn default() -> Self {
        Self::preset(Preset::Taproot)
    }
}

impl GrowthParams {
    /// Fails where a number is out of its range.
    ///
    /// # Errors
    /// Every fault at once, each naming its key.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        let mut need = |ok: bool, key: &str, value: String, remedy: &str| {
            if !ok {
                faults.push(Error::usage(format!("simulate.growth.{key} is {value}")).help(remedy));
            }
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let m = &self.main;
        need((1..=1000).contains(&m.count), "main.count", m.count.to_string(), "give 1 to 1000 main roots");
        let length = |x: f64| positive(x) && x <= MAX_LENGTH_MM;
        let lengths = "give a length in mm, above 0 and at most 10000";
        need(length(m.length_mm), "main.length_mm", m.length_mm.to_string(), lengths);
        need(share(m.length_spread), "main.length_spread", m.length_spread.to_string(), "give a share, 0 to 1");
        let ok = (0.0..=0.9).contains(&m.diameter_spread);
        need(ok, "main.diameter_spread", m.diameter_spread.to_string(), "give a share, 0 to 0.9");
        for (key, d) in [
            ("main.base_diameter_mm", m.base_diameter_mm),
            ("main.tip_diameter_mm", m.tip_diameter_mm),
            ("first_order.tip_diameter_mm", self.first_order.tip_diameter_mm),
            ("second_order.tip_diameter_mm", self.second_order.tip_diameter_mm),
        ] {
            need(positive(d) && d <= 20.0, key, d.to_string(), "give a diameter of at most 20 mm");
        }
        for (order, l) in [("first_order", &self.first_order), ("second_order", &self.second_order)] {
            let key = |name: &str| format!("{order}.{name}");
            need(l.count <= 100_000, &key("count"), l.count.to_string(), "give at most 100000 laterals");
            need(length(l.length_mm), &key("length_mm"), l.length_mm.to_string(), lengths);
            need(share(l.length_spread), &key("length_spread"), l.length_spread.to_string(), "give a share, 0 to 1");
            let [a, b] = l.zone;
            need(share(a) && share(b) && a <= b, &key("zone"), format!("[{a}, {b}]"), "give shares 0 to 1, from <= to");
            let [a, b] = l.base_diameter_mm;
            need(
                positive(a) && positive(b) && a <= b && b <= 20.0,
                &key("base_diameter_mm"),
                format!("[{a}, {b}]"),
                "give diameters of at most 20 mm, from <= to",
            );
        }
        for (key, x) in [
            ("crown_mm", self.crown_mm),
            ("crown_offset_mm", self.crown_offset_mm),
            ("main.depth_spread_mm", m.depth_spread_mm),
            ("main.start_angle_deg", m.start_angle_deg),
            ("main.wander_deg_per_mm", m.wander_deg_per_mm),
            ("main.gravitropism_deg_per_mm", m.gravitropism_deg_per_mm),
            ("first_order.insertion_angle_deg", self.first_order.insertion_angle_deg),
            ("first_order.wander_deg_per_mm", self.first_order.wander_deg_per_mm),
            ("second_order.insertion_angle_deg", self.second_order.insertion_angle_deg),
            ("second_order.wander_deg_per_mm", self.second_order.wander_deg_per_mm),
        ] {
            need(x.is_finite() && x >= 0.0, key, x.to_string(), "give a number of at least 0");
        }
        for (key, x) in [
            ("first_order.gravitropism_deg_per_mm", self.first_order.gravitropism_deg_per_mm),
            ("second_order.gravitropism_deg_per_mm", self.second_order.gravitropism_deg_per_mm),
            ("first_order.insertion_spread_deg", self.first_order.insertion_spread_deg),
            ("second_order.insertion_spread_deg", self.second_order.insertion_spread_deg),
        ] {
            need(x.is_finite(), key, x.to_string(), "give a number");
        }
        Error::many(faults)
    }
}

impl<'de> Deserialize<'de> for GrowthParams {
    /// Lays what is given over the preset's parameters.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> std::result::Result<Self, D::Error> {
        let mut given = Map::deserialize(deserializer)?;
        let preset = given.remove("preset").map_or(Ok(Preset::default()), Preset::deserialize);
        let base = Self::preset(preset.map_err(|e| D::Error::custom(format!("preset: {e}")))?);
        Ok(Self {
            preset: base.preset,
            crown_mm: laid_over(&mut given, "crown_mm", base.crown_mm)?,
            crown_offset_mm: laid_over(&mut given, "crown_offset_mm", base.crown_offset_mm)?,
            main: laid_over(&mut given, "main", base.main)?,
            first_order: laid_over(&mut given, "first_order", base.first_order)?,
            second_order: {
                let second_order = laid_over(&mut given, "second_order", base.second_order)?;
                if let Some(key) = given.keys().next() {
                    return Err(D::Error::custom(format!(
                        "unknown field `{key}`, expected one of `preset`, `crown_mm`, `crown_offset_mm`, `main`, \
                         `first_order`, `second_order`"
                    )));
                }
                second_order
            },
        })
    }
}

/// The value under `key`, a table's missing keys filled up from `base`.
fn laid_over<T, E>(given: &mut Map<String, Value>, key: &str, base: T) -> std::result::Result<T, E>
where
    T: Serialize + DeserializeOwned,
    E: serde::de::Error,
{
    let place = |e: serde_json::Error| E::custom(format!("{key}: {e}"));
    let Some(mut value) = given.remove(key) else {
        return Ok(base);
    };
    if let (Value::Object(value), Value::Object(base)) = (&mut value, serde_json::to_value(base).map_err(place)?) {
        for (name, default) in base {
            value.entry(name).or_insert(default);
        }
    }
    serde_json::from_value(value).map_err(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_given_is_the_presets() {
        let given = "preset = 'fibrous'\ncrown_mm = 5\nmain = { count = 3 }";
        let params: GrowthParams = toml::from_str(given).unwrap();
        let mut expected = GrowthParams::preset(Preset::Fibrous);
        expected.crown_mm = 5.0;
        expected.main.count = 3;
        assert_eq!(params, expected);
        let again: GrowthParams = serde_json::from_str(&serde_json::to_string(&params).unwrap()).unwrap();
        assert_eq!(again, params);
    }

    #[test]
    fn unknown_keys_are_refused() {
        for text in ["crown = 3", "main = { size = 3 }", "preset = 'oak'"] {
            assert!(toml::from_str::<GrowthParams>(text).is_err(), "{text}");
        }
        let error = toml::from_str::<GrowthParams>("second_order = { lenght_mm = 3 }").unwrap_err().to_string();
        assert!(error.contains("second_order") && error.contains("lenght_mm"), "{error}");
    }

    #[test]
    fn lengths_that_no_tank_holds_are_refused() {
        for length_mm in [0.0, -1.0, 1e12, f64::INFINITY, f64::NAN] {
            let mut params = GrowthParams::default();
            params.second_order.length_mm = length_mm;
            let message = params.check().unwrap_err().to_string();
            assert!(message.contains("second_order.length_mm"), "{message}");
        }
    }

    #[test]
    fn presets_are_sound() {
        for preset in [Preset::Taproot, Preset::Fibrous, Preset::Fine, Preset::Rice, Preset::Maize] {
            GrowthParams::preset(preset).check().unwrap();
        }
    }
}
