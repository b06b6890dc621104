//! `rootvox compare`, and the page over the points of a sweep.

use super::capture::{Capture, rootvox, stderr};
use super::runs::computed;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// Runs the quickstart on coarse voxels under a name.
fn quickstart(folder: &Path, name: &str, set: &[&str]) {
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/quickstart.toml");
    let mut run = rootvox();
    run.current_dir(folder).arg("run").arg(study).args([
        "--set",
        &format!("study.name={name}"),
        "--set",
        "grid.spacing=1.5",
    ]);
    run.args(["--set", "simulate.capture.supersampling=1"]).args(set.iter().flat_map(|set| ["--set", set]));
    run.assert().success();
}

fn compare(folder: &Path, arguments: &[&str]) -> (Option<i32>, String) {
    let output = rootvox().current_dir(folder).arg("compare").args(arguments).output().expect("runs");
    // Long messages are broken into lines.
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" "))
}

#[test]
fn two_results_of_a_plant_are_held_against_each_other() {
    let folder: TempDir = tempfile::tempdir().expect("a temporary folder");
    let at = folder.path();
    quickstart(at, "loose", &[]);
    quickstart(at, "strict", &["trace.high=2.5", "trace.low=1.5"]);
    let (code, text) = compare(at, &["results/loose", "results/strict"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("B against A: ") && text.contains("look at: compare.html"), "{text}");
    let html = fs::read_to_string(at.join("compare.html")).expect("is there");
    let body = &html[..html.find("id=\"data\"").expect("has data")];
    assert!(body.contains("<h1>loose, strict</h1>") && body.contains("results/strict"), "{}", &body[..3000]);
    let settings = &body[body.find("id=\"settings\"").expect("has settings")..];
    assert!(settings.contains("<th scope=\"row\">trace.high</th><td><code>0.5</code></td><td><code>2.5</code></td>"));
    assert_eq!(settings.matches("<tr><th scope=\"row\">").count(), 2, "{settings}");
    // Fewer roots come of a stricter threshold, and those that are gone are told.
    let rows = body.matches("data-entry=").count();
    assert!(rows > 0 && body.contains("data-fate=\"only\""), "{rows} rows");
    for (n, name) in ["loose", "strict"].iter().enumerate() {
        let csv = fs::read_to_string(at.join(format!("results/{name}/traits.csv"))).expect("is there");
        let count = csv.lines().find_map(|l| l.strip_prefix("root_count,")).expect("is counted");
        let cell = format!("data-trait=\"root_count\" data-result=\"{n}\">{}<", count.trim_end_matches(".0"));
        assert!(body.contains(&cell), "{cell}");
    }

    // A result is like itself, and the page is the same again.
    let (code, text) = compare(at, &["results/loose", "results/loose", "-o", "same.html"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(
        text.contains("0 with another length, 0 with another order, parent or direction") && text.contains("100 %"),
        "{text}"
    );
    compare(at, &["results/loose", "results/strict", "-o", "again.html"]);
    assert_eq!(fs::read_to_string(at.join("again.html")).expect("is there"), html);

    // Another tank is refused by name.
    let lock = at.join("results/strict/study.lock");
    let other =
        fs::read_to_string(&lock).expect("is there").replace("\"tank.radius\": \"45.0\"", "\"tank.radius\": \"60.0\"");
    fs::write(&lock, other).expect("can write");
    let (code, text) = compare(at, &["results/loose", "results/strict"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("different tanks: outer radius 45 and 60 mm"), "{text}");
}

#[test]
fn what_is_no_result_is_refused_by_name() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let at = capture.path("");
    for (arguments, code, words) in [
        (&["results/tiny"][..], 2, &["1 results are given, 2 to 8"][..]),
        (&["results/tiny", "nowhere"], 2, &["`nowhere` is no results folder", "no such folder"]),
        (&["results/tiny", "images", "nowhere"], 2, &["`images` is no results folder", "study.lock", "nowhere"]),
        (&["results/tiny", "results/tiny", "-o", "no/where.html"], 1, &["no/where.html"]),
    ] {
        let (found, text) = compare(&at, arguments);
        assert_eq!(found, Some(code), "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
    }
    assert!(!capture.path("compare.html").exists());
    fs::write(capture.path("results/tiny/roots.csv"), "x_mm,y_mm,z_mm\n1,2,3\n").expect("can write");
    let (code, text) = compare(&at, &["results/tiny", "results/tiny"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("results/tiny/roots.csv"), "{text}");
    fs::remove_file(capture.path("results/tiny/traits.csv")).expect("can remove");
    fs::remove_file(capture.path("results/tiny/roots.csv")).expect("can remove");
    let (code, text) = compare(&at, &["results/tiny", "results/tiny"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("run the study again"), "{text}");
}

#[test]
fn a_sweep_of_traced_points_has_the_page() {
    let capture = Capture::new();
    let traits = ["--set", "sweep.extract.high=[0.8, 1.0, 2.0]", "--set", "sweep.traits=true"];
    let text = stderr(&mut capture.run(&traits));
    let page = capture.path("results/tiny/compare.html");
    assert!(text.contains("points compared: results/tiny/compare.html"), "{text}");
    let html = fs::read_to_string(&page).expect("is there");
    assert!(html.contains("<th scope=\"row\">C</th><td>point 3</td><td>extract.high = 2.0</td>"));
    let sheet = fs::read_to_string(capture.path("results/tiny/contact.svg")).expect("is there");
    assert!(sheet.contains("<a href=\"compare.html\">"));
    let again = stderr(&mut capture.run(&traits));
    assert_eq!(computed(&again), 0, "{again}");
    assert!(again.contains("results unchanged") && again.contains("points compared"), "{again}");
    let (code, text) = compare(&capture.path(""), &["results/tiny", "results/tiny"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("`results/tiny` is a sweep"), "{text}");

    // Nothing is compared where points were not traced, or one alone went through; an old page goes.
    for sweep in [
        &["--set", "sweep.extract.high=[0.8, 1.0]"][..],
        &["--set", "sweep.tank.wall=[2.0, 40.0]", "--set", "sweep.traits=true"],
    ] {
        let text = stderr(&mut capture.run(sweep));
        assert!(text.contains("results written") && !text.contains("points compared"), "{text}");
        assert!(!page.exists(), "{text}");
    }
}
