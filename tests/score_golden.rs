//! The score against figures of an independent script of the same definitions (numpy, scipy's k-d tree), stored in
//! `data/score/expected.json`: polylines, the same turned by 123.4° with the turn left free, and bare voxels.

use rootvox::evaluation::{ScoreParams, score};
use rootvox::formats::{points_csv, roots_json, tank_json};

fn check(table: &str, params: &ScoreParams) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/score");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let tank = tank_json::parse("tank.json", &text("tank.json")).unwrap();
    let truth = roots_json::parse("roots.json", &text("roots.json")).unwrap();
    let points = points_csv::parse(table, text(&format!("{table}.csv")).as_bytes()).unwrap();
    let ours = score(&truth, &tank, points.found(), params).unwrap();
    let expected: serde_json::Value = serde_json::from_str(&text("expected.json")).unwrap();
    let same = |key: &str, value: f64| {
        let wanted = expected[table][key].as_f64().unwrap();
        assert!((value - wanted).abs() < 1e-6, "{table}, {key}: {value} instead of {wanted}");
    };
    same("true_length_mm", ours.true_length_mm);
    same("points", ours.points as f64);
    same("rms_mm", ours.rms_mm.unwrap());
    for at in &ours.at {
        same(&format!("precision@{}", at.tolerance_mm), at.precision);
        same(&format!("recall@{}", at.tolerance_mm), at.recall);
        same(&format!("F1@{}", at.tolerance_mm), at.f1);
    }
    if let Some(bias) = ours.length_bias {
        same("length_bias", bias);
    }
    if let Some(turned) = ours.turned_deg {
        same("turned_deg", turned);
    }
}

#[test]
fn polylines() {
    check("lines", &ScoreParams { z_max_mm: 120.0, ..Default::default() });
}

#[test]
fn polylines_with_a_free_turn() {
    check("turned", &ScoreParams { free_azimuth: true, ..Default::default() });
}

#[test]
fn voxels() {
    let params = ScoreParams { z_min_mm: Some(30.0), tolerances_mm: vec![0.4, 1.5], ..Default::default() };
    check("voxels", &params);
}
