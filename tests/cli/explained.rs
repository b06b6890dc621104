//! What the photographs need and nothing else: few thick roots, which line up by chance, and a judgement that can be switched off.

use super::capture::rootvox;
use std::fs;
use std::path::Path;

const STUDY: &str = r#"
[study]
name = "thick"

[tank]
radius = 30.0
height = 90.0
wall = 2.5
water_level = 8.0
belts = [[0.0, 14.0], [78.0, 90.0]]

[simulate]
seed = 3

[simulate.growth]
main = { count = 5, length_mm = 60.0, length_spread = 0.2, base_diameter_mm = 2.5, tip_diameter_mm = 1.2, start_angle_deg = 45.0 }
first_order = { count = 0 }
second_order = { count = 0 }

[simulate.capture]
views = 16
width = 320
height = 260

[grid]
depth = 76.0

[truth]
z_min = 18.0
z_max = 72.0
"#;

/// (precision, recall) of the traced roots within 2 mm, the thickest root's diameter and less.
fn scored(folder: &Path, name: &str, set: &[&str]) -> (f64, f64) {
    let mut command = rootvox();
    command.current_dir(folder).args(["run", "study.toml", "--cache", "cache", "--results", name]).args(set);
    command.assert().success();
    let text = fs::read_to_string(folder.join(name).join("thick/roots_score.json")).expect("a score");
    let score: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let at = &score["score"]["at"][2];
    assert_eq!(at["tolerance_mm"], 2.0);
    (at["precision"].as_f64().expect("precision"), at["recall"].as_f64().expect("recall"))
}

#[test]
fn few_thick_roots_leave_no_ghosts() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("study.toml"), STUDY).expect("can write");
    let (precision, recall) = scored(folder.path(), "explained", &[]);
    assert!(precision >= 0.99, "false length: precision {precision}");
    assert!(recall >= 0.97, "recall {recall}");
    // The same capture without the judgement: the setting means what it says.
    let (by_votes, _) = scored(folder.path(), "votes", &["--set", "explain.enabled=false"]);
    assert!(by_votes <= precision, "{by_votes} by votes, {precision} explained");
    let roots = |name: &str| fs::read(folder.path().join(name).join("thick/roots.csv")).expect("roots");
    assert!(roots("votes") != roots("explained"), "the setting changes nothing");
}
