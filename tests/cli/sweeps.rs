//! Sweeps and studies on a common base: what they share is computed once, and a point that fails fails alone.

use super::capture::{Capture, rootvox, stderr};
use super::runs::{computed, ran};
use rootvox::study::batch::Batch;
use rootvox::study::graph;
use std::fs;

const SWEEP: &str = "[sweep]\n\"rootness.gamma23, rootness.gamma12\" = [[0.5, 0.5], [1.0, 1.0]]\n\
    \"extract.high\" = [0.8, 1.0, 1.5]\n";

fn table(capture: &Capture) -> Vec<Vec<String>> {
    let text = fs::read_to_string(capture.path("results/tiny/sweep.csv")).expect("is there");
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn points_share_what_they_have_in_common() {
    let capture = Capture::new();
    capture.edit("study.toml", "[grid]", &format!("[truth]\nroots = \"roots.json\"\n{SWEEP}[grid]"));
    let text = stderr(&mut capture.run(&[]));
    let ran = ran(&text);
    let count = |stage: &str| ran.iter().filter(|n| n.split(['/', ' ']).next() == Some(stage)).count();
    assert_eq!((count("render"), count("merge"), count("rootness"), count("suppress")), (6, 1, 2, 2), "{text}");
    assert_eq!((count("extract"), count("evaluate"), count("overlay"), count("volume")), (6, 6, 0, 0), "{text}");
    assert!(ran.contains(&"rootness [1-3]") && ran.contains(&"extract [5]"), "{text}");

    let rows = table(&capture);
    assert_eq!(rows.len(), 7);
    assert_eq!(
        rows[0][..6],
        ["point", "rootness.gamma23", "rootness.gamma12", "extract.high", "f1_0.5mm", "precision_0.5mm"]
    );
    assert_eq!(rows[5][..4], ["5", "1.0", "1.0", "1.0"]);
    let voxels = |n: usize| fs::read_to_string(capture.path(&format!("results/tiny/points/{n}/root_voxels.csv")));
    assert!(voxels(1).expect("is there").len() > voxels(6).expect("is there").len());
    let sheet = fs::read_to_string(capture.path("results/tiny/contact.svg")).expect("is there");
    assert_eq!(sheet.matches("<image").count(), 6);

    let again = capture.run(&["--best", "f1_1mm"]).output().expect("runs");
    let text = String::from_utf8_lossy(&again.stderr).into_owned();
    assert_eq!(computed(&text), 0, "{text}");
    assert!(text.contains("results unchanged"), "{text}");
    let best = String::from_utf8_lossy(&again.stdout).into_owned();
    assert!(best.starts_with("point ") && best.contains("--set extract.high="), "{best}");

    // The best point as a study of its own has nothing left to compute but its pictures.
    capture.edit("study.toml", SWEEP, "");
    let one = stderr(&mut capture.run(&["--set", "extract.high=1.5"]));
    assert!(one.contains("volume: ") && !one.contains("extract: "), "{one}");
}

#[test]
fn points_are_the_studies_of_their_settings_and_add_only_what_differs() {
    let capture = Capture::new();
    let swept =
        |sweep: String| Batch::load(&capture.path("study.toml"), &[format!("sweep.{sweep}")]).expect("is sound");
    for sweep in [
        "tank.water_level=[4.0, 6.0]",
        "grid.spacing=[1.0, 1.5]",
        "render.sampling=[\"point\", \"footprint\"]",
        "contrast.window_mm=[10.0, 15.0]",
        "merge.quantile=[0.1, 0.3]",
        "rootness.alpha=[0.25, 0.5]",
        "extract.high=[1.0, 1.5]",
        "trace.high=[1.0, 1.5]",
        "explain.enabled=[true, false]",
        "explain.share=[0.06, 0.1]",
        "\"traits.layer_mm\"=[5.0, 10.0]",
        "report.slice=[20.0, 30.0]",
        "diameters.enabled=[true, false]",
    ] {
        let Batch { mut graph, studies, .. } = swept(sweep.to_owned());
        let labels = graph.labels();
        assert!(!labels.iter().any(|l| l.contains("overlay") || l == "volume"), "{sweep}: {labels:?}");
        for point in &studies[0].points {
            let (settings, nodes) = point.planned.as_ref().expect("is sound");
            let alone = graph::add(&mut graph, settings).expect("is sound");
            // The same work in one graph is the same node.
            assert_eq!((nodes.numbers(), nodes.system), (alone.numbers(), alone.system), "{sweep}");
            assert_eq!(nodes.measures().collect::<Vec<_>>(), alone.measures().collect::<Vec<_>>(), "{sweep}");
        }
    }
    let nodes = |points: usize| swept(format!("extract.high={{ from = 1, to = {points} }}")).graph.nodes().count();
    assert_eq!(nodes(40) - nodes(10), 30);
}

#[test]
fn a_point_that_fails_fails_alone() {
    let capture = Capture::new();
    // A tank wall as thick as the tank is refused before anything runs, a camera inside the tank while it runs.
    let output = capture
        .run(&["--set", "sweep.tank.wall=[2.0, 40.0]", "--set", "sweep.tank.radius=[30.0, 4000.0]"])
        .output()
        .expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    let flat = text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
    assert!(!output.status.success(), "{text}");
    assert!(flat.contains("4 points, 3 failed"), "{text}");
    assert!(flat.contains("point 2 (tank.wall = 2.0, tank.radius = 4000.0)"), "{text}");
    assert!(flat.contains("point 3 (tank.wall = 40.0, tank.radius = 30.0)"), "{text}");
    let rows = table(&capture);
    assert_eq!(rows[0].last().map(String::as_str), Some("error"));
    assert!(capture.path("results/tiny/points/1/root_voxels.csv").exists());
    assert!(!capture.path("results/tiny/points/2").exists());
}

#[test]
fn the_plan_tells_which_points_must_fail() {
    let capture = Capture::new();
    for json in [&[][..], &["--json"]] {
        let mut status = rootvox();
        status.current_dir(capture.path("")).args(["status", "study.toml", "--set", "sweep.tank.wall=[2.0, 40.0]"]);
        let output = status.args(json).output().expect("runs");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains("point 2 (tank.wall = 40.0)") && !text.contains("point 1"), "{text}");
        assert!(String::from_utf8_lossy(&output.stdout).contains("render/"), "the sound point is planned: {output:?}");
    }
}

#[test]
fn where_all_points_fail_each_is_told() {
    let capture = Capture::new();
    let all = capture.run(&["--set", "sweep.tank.wall=[40.0, 50.0]"]).output().expect("runs");
    let text = String::from_utf8_lossy(&all.stderr).into_owned();
    assert_eq!(all.status.code(), Some(2), "{text}");
    assert!(text.contains("point 1 (tank.wall = 40.0)") && text.contains("point 2 (tank.wall = 50.0)"), "{text}");
    // Sound settings, but a camera inside the tank: refused while it runs, and kept in the table.
    let all = capture.run(&["--set", "sweep.tank.radius=[4000.0, 5000.0]"]).output().expect("runs");
    let text = String::from_utf8_lossy(&all.stderr).into_owned();
    assert!(text.contains("2 points, 2 failed") && text.contains("point 2 (tank.radius = 5000.0)"), "{text}");
    assert_eq!(table(&capture).len(), 3);
}

#[test]
fn a_sweep_that_cannot_be_meant_is_refused_as_a_whole() {
    let capture = Capture::new();
    for (set, word) in [
        ("sweep.extract.hihg=[0.1, 0.2]", "hihg"),
        ("sweep.extract.high=0.1", "expected a list"),
        ("sweep.extrakt.high=[0.1]", "extrakt"),
    ] {
        let output = capture.run(&["--set", set]).output().expect("runs");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(text.contains(word), "{text}");
        assert_eq!(text.matches("error:").count(), 1, "each fault is shown once:\n{text}");
    }
    assert!(!capture.path("results").exists());
}

#[test]
fn studies_of_one_file_share_its_base() {
    let capture = Capture::new();
    capture.edit(
        "study.toml",
        "[grid]",
        "[studies.strict]\nextract.high = 1.5\n[studies.loose]\nextract.high = 0.9\n[grid]",
    );
    let text = stderr(&mut capture.run(&[]));
    let ran = ran(&text);
    assert_eq!(ran.iter().filter(|n| n.starts_with("render/")).count(), 6, "{text}");
    assert!(ran.contains(&"extract [strict]") && ran.contains(&"extract [loose]"), "{text}");
    for study in ["strict", "loose"] {
        assert!(capture.path("results").join(study).join("report.html").exists(), "{text}");
    }
    assert!(!capture.path("results/tiny").exists(), "the base is not run");
}
