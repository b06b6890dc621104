//! Roots, tanks, points and corrections: the first byte chooses the format.

use rootvox::formats::{corrections_toml, points_csv, roots_json, rsml, tank_json};

/// Reads it, whatever it is, and tells whether it could be.
pub fn run(data: &[u8]) -> bool {
    let Some((choice, data)) = data.split_first() else { return false };
    if choice % 5 == 0 {
        return points_csv::parse("roots.csv", data).is_ok();
    }
    let Ok(text) = std::str::from_utf8(data) else { return false };
    match choice % 5 {
        1 => roots_json::parse("roots.json", text).is_ok(),
        2 => tank_json::parse("tank.json", text).is_ok(),
        3 => corrections_toml::read("corrections.toml", text).is_ok(),
        _ => rsml::read("roots.rsml", text).is_ok(),
    }
}
