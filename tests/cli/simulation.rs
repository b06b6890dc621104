//! `rootvox simulate`, `belt` and `evaluate`: a laboratory from the command line.

use super::capture::{Capture, rootvox};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Every file below a folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).expect("can list").map(|e| e.expect("entry").path()) {
        let name = entry.file_name().expect("name").to_string_lossy().into_owned();
        if entry.is_dir() {
            found.extend(files(&entry).into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            found.insert(name, fs::read(&entry).expect("can read"));
        }
    }
    found
}

/// Sways, noise, drifts, dirt, bubbles, bits, rooms, bumps: everything that draws lots.
const RESTLESS: &str = "capture = { views = 3, width = 120, height = 90, sway_mm = 1.0, sway_views = [1], noise_sigma = 4.0, \
                        exposure_drift = 0.1, dirt = 40, bubbles = 40, blur_px = 3.0, format = \"png\", \
                        room = { clutter = 0.5, windows = 1, lamps = 1 }, bubble_glint = 0.5, drifting = 20, \
                        exposure_walk = 0.1, white_balance_walk = 0.1, bump_view = 1, bump_mm = 1.0, bump_deg = 0.3, \
                        other_light = [{ views = [2], gain = [1.2, 1.0, 0.9] }] }";

#[test]
fn a_capture_is_the_same_to_the_byte_at_any_thread_count() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = include_str!("../data/tiny.toml");
    let old = text.lines().find(|l| l.starts_with("capture = ")).expect("a capture");
    fs::write(folder.path().join("study.toml"), text.replace(old, RESTLESS)).expect("can write");
    let simulate = |out: &str, threads: &str, seed: &str| {
        let mut command = rootvox();
        command.current_dir(folder.path()).args(["simulate", "study.toml", "--out", out, "--threads", threads]);
        command.args(["--cache", &format!("cache-{out}"), "--set", &format!("simulate.seed={seed}")]);
        command.assert().success();
        files(&folder.path().join(out))
    };
    let (one, three) = (simulate("one", "1", "3"), simulate("three", "3", "3"));
    let names: Vec<&str> = one.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        [
            "cameras.json",
            "images/000.png",
            "images/001.png",
            "images/002.png",
            "roots.json",
            "roots.rsml",
            "tank.json",
            "traits.csv"
        ]
    );
    assert!(one == three, "threads changed a file");
    assert!(one["images/001.png"] != simulate("other", "2", "4")["images/001.png"], "the seed changes nothing");
}

#[test]
fn a_wrong_tank_and_wrong_cameras_are_measured() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("study.toml"), include_str!("../data/tiny.toml")).expect("can write");
    let errors = |set: &[&str]| -> f64 {
        let mut command = rootvox();
        command.current_dir(folder.path()).args(["run", "study.toml"]);
        for value in set {
            command.args(["--set", value]);
        }
        command.assert().success();
        let text = fs::read_to_string(folder.path().join("results/tiny/camera_errors.json")).expect("is there");
        let errors: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        errors["water_rms_px"].as_f64().expect("a number")
    };
    assert!(errors(&[]) < 1e-6);
    assert!(errors(&["simulate.tank.index.water=1.333", "tank.index.water=1.36"]) > 0.1);
    assert!(errors(&["simulate.misjudge.turn_deg=0.5"]) > 0.3);
    let mut refused = rootvox();
    refused.current_dir(folder.path()).args(["run", "study.toml", "--set", "simulate.misjudge.turn_deg=-1"]);
    let refused = refused.output().expect("runs");
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("misjudge.turn_deg"));
}

#[test]
fn a_sweep_over_a_number_has_curves() {
    let folder = tempfile::tempdir().expect("a folder");
    let sweep = "[sweep]\ntraits = true\n\"tank.index.water\" = [1.30, 1.333]\n[simulate.tank]\nindex.water = 1.333\n";
    fs::write(folder.path().join("study.toml"), format!("{}{sweep}", include_str!("../data/tiny.toml")))
        .expect("can write");
    rootvox().current_dir(folder.path()).args(["run", "study.toml"]).assert().success();
    let read = |name: &str| fs::read_to_string(folder.path().join("results/tiny").join(name)).expect("is there");
    let svg = read("curves.svg");
    for text in ["F1", "length error", "camera error", "tank.index.water"] {
        assert!(svg.contains(text), "{text}");
    }
    assert_eq!(read("curves.csv").lines().count(), 3);
    let header = read("sweep.csv").lines().next().expect("a header").to_owned();
    for column in ["length_bias", "camera_rms_px", "tips_recall"] {
        assert!(header.contains(column), "{header}");
    }
}

#[test]
fn evaluate_says_where_a_result_is_right() {
    let capture = Capture::new();
    capture.edit("study.toml", "[grid]", "[truth]\nroots = \"roots.json\"\n[grid]");
    capture.run(&[]).assert().success();
    let evaluate = |more: &[&str]| {
        let mut command = rootvox();
        command.current_dir(capture.path("")).args(["evaluate", "results/tiny", ".", "--z-max", "58"]).args(more);
        let output = command.assert().success();
        String::from_utf8_lossy(&output.get_output().stdout).into_owned()
    };
    let table = evaluate(&["--picture", "hits.png"]);
    for text in [
        "root voxels",
        "traced roots",
        "by depth",
        "by distance to the wall",
        "tips:",
        "total_root_length_mm",
        "cameras: 6",
    ] {
        assert!(table.contains(text), "{text} in\n{table}");
    }
    assert!(image::open(capture.path("hits.png")).expect("a picture").width() > 100);
    let json: serde_json::Value = serde_json::from_str(&evaluate(&["--json"])).expect("JSON");
    let stored = fs::read_to_string(capture.path("results/tiny/roots_score.json")).expect("is there");
    let stored: serde_json::Value = serde_json::from_str(&stored).expect("JSON");
    let f1 = |v: &serde_json::Value| v["score"]["at"][1]["f1"].as_f64().expect("a number");
    assert!((f1(&json["traced_roots"]) - f1(&stored)).abs() < 1e-3, "tables hold a tenth of a micrometre");
    assert!(json["root_voxels"]["detail"]["hausdorff95_mm"].is_number() && json["cameras"]["views"] == 6);
}

#[test]
fn a_belt_is_written_and_impossible_ones_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let belt = |radius: &str| {
        let mut command = rootvox();
        command.current_dir(folder.path()).args(["belt", "--height", "28", "-o", "belt.svg"]);
        command.arg(format!("--radius={radius}"));
        command
    };
    belt("90").assert().success();
    assert!(fs::read_to_string(folder.path().join("belt.svg")).expect("is there").contains("mm"));
    belt("-90").assert().code(2);
    belt("NaN").assert().code(2);
}
