//! What a run computes, keeps and leaves.

use super::capture::{Capture, rootvox, stderr};
use std::fs;

pub fn computed(text: &str) -> usize {
    let line = text.lines().find(|l| l.contains(" computed")).unwrap_or_else(|| panic!("no summary in:\n{text}"));
    let word = line.split(" cached, ").nth(1).and_then(|r| r.split(' ').next());
    word.and_then(|w| w.parse().ok()).unwrap_or_else(|| panic!("no count in `{line}`"))
}

/// The nodes that ran, from the lines of a run without a terminal.
pub fn ran(text: &str) -> Vec<&str> {
    text.lines().filter_map(|l| l.split_once(": ")).filter(|(_, t)| t.contains(" s")).map(|(n, _)| n).collect()
}

#[test]
fn what_a_change_does_not_touch_is_not_computed_again() {
    let capture = Capture::new();
    let first = stderr(&mut capture.run(&[]));
    assert_eq!(ran(&first).iter().filter(|n| n.starts_with("render/")).count(), 6, "{first}");
    assert_eq!(computed(&stderr(&mut capture.run(&[]))), 0, "nothing changed");

    let threshold = stderr(&mut capture.run(&["--set", "extract.high=1.5"]));
    assert!(ran(&threshold).contains(&"extract"), "{threshold}");
    assert!(
        !ran(&threshold).iter().any(|n| n.starts_with("render") || *n == "suppress" || *n == "volume"),
        "{threshold}"
    );

    // Touched but equal: nothing.
    let photo = capture.path("images/002.jpg");
    let bytes = fs::read(&photo).expect("can read");
    fs::write(&photo, &bytes).expect("can write");
    assert_eq!(computed(&stderr(&mut capture.run(&[]))), 0, "touched but equal");

    // The colour axis is learned from all photographs together, so a photograph that moves it re-runs every view's
    // feature; without it views are independent.
    let plain = ["--set", "contrast.enabled=false"];
    capture.run(&plain).assert().success();

    // Other pixels in one photograph: that view's nodes, then the merge and what follows.
    let mut picture = image::load_from_memory(&bytes).expect("a picture").to_rgb8();
    for (_, _, pixel) in picture.enumerate_pixels_mut() {
        pixel.0 = pixel.0.map(|c| c.saturating_add(9));
    }
    picture.save(&photo).expect("can save");
    let changed = stderr(&mut capture.run(&plain));
    let ran = ran(&changed);
    assert!(
        ran.contains(&"undistort/002.jpg") && ran.contains(&"render/002.jpg") && ran.contains(&"merge"),
        "{changed}"
    );
    assert!(!ran.contains(&"undistort/001.jpg") && !ran.contains(&"render/001.jpg"), "{changed}");
}

#[test]
fn results_do_not_depend_on_threads_or_place() {
    let (one, two) = (Capture::new(), Capture::new());
    one.run(&["--threads", "1"]).assert().success();
    two.run(&["--threads", "2"]).assert().success();
    for name in ["study.lock", "root_voxels.csv", "overlays/003.jpg", "report.html"] {
        let read = |c: &Capture| fs::read(c.path("results/tiny").join(name)).expect("is there");
        assert_eq!(read(&one), read(&two), "{name}");
    }
}

#[test]
fn a_moved_store_still_knows() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    fs::rename(capture.path("cache"), capture.path("elsewhere")).expect("can move");
    assert_eq!(computed(&stderr(&mut capture.run(&["--cache", "elsewhere"]))), 0);
}

#[test]
fn the_result_holds_what_the_readme_says() {
    let capture = Capture::new();
    capture.edit("study.toml", "[grid]", "[truth]\nroots = \"roots.json\"\n[grid]");
    capture.run(&[]).assert().success();
    for name in [
        "root_voxels.csv",
        "volume.ome.zarr/zarr.json",
        "volume.ome.zarr/labels/roots/0/zarr.json",
        "score.json",
        "study.lock",
        "overlays/000.jpg",
    ] {
        assert!(capture.path("results/tiny").join(name).exists(), "{name}");
    }
    let table = rootvox()
        .args(["evaluate".as_ref(), capture.path("results/tiny").as_os_str(), capture.path("").as_os_str()])
        .args(["--z-max", "58"])
        .output()
        .expect("runs");
    assert!(String::from_utf8_lossy(&table.stdout).contains("F1"), "{table:?}");
}

#[test]
fn help_teaches() {
    for command in ["run", "simulate", "evaluate", "doctor"] {
        let output = rootvox().args([command, "--help"]).output().expect("runs");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.len() > 200, "{command}: {text}");
    }
    assert_eq!(rootvox().arg("wander").output().expect("runs").status.code(), Some(2));
}

#[test]
fn views_that_are_not_stored_give_the_same_numbers() {
    let (stored, streamed) = (Capture::new(), Capture::new());
    stored.run(&["--set", "render.store=always"]).assert().success();
    streamed.run(&["--set", "render.store=never"]).assert().success();
    let nodes = |c: &Capture| {
        let text = fs::read(c.path("results/tiny/study.lock")).expect("is there");
        serde_json::from_slice::<serde_json::Value>(&text).expect("JSON")["nodes"].clone()
    };
    assert_eq!(nodes(&stored), nodes(&streamed));
    let views = |c: &Capture| {
        let nodes = fs::read_dir(c.path("cache/v1/nodes/render")).expect("nodes");
        nodes.filter(|n| n.as_ref().expect("node").path().join("view").exists()).count()
    };
    assert_eq!((views(&stored), views(&streamed)), (6, 0));
}

#[test]
fn a_slice_of_a_view_can_be_taken_out() {
    let capture = Capture::new();
    let export = |z: &str| {
        let mut command = rootvox();
        command.current_dir(capture.path("")).args(["export", "slice", "study.toml", "--view", "002.jpg"]);
        command.args(["--z", z, "-o", "slice.png"]).output().expect("runs").status.code()
    };
    assert_eq!(export("30"), Some(0));
    let picture = image::open(capture.path("slice.png")).expect("a picture").to_rgb8();
    assert_eq!(picture.dimensions(), (57, 57));
    assert!(picture.pixels().any(|p| p.0 != [0; 3]), "the view sees something of the slice");
    assert_eq!(export("300"), Some(2));
}

#[test]
fn what_a_view_tells_can_be_looked_at() {
    let capture = Capture::new();
    let export = |more: &[&str]| {
        let mut command = rootvox();
        command.current_dir(capture.path("")).args(["export", "evidence", "study.toml", "-o", "shown.png"]);
        command.args(more).output().expect("runs").status.code()
    };
    for show in ["share", "confidence", "background"] {
        assert_eq!(export(&["--view", "002.jpg", "--show", show]), Some(0), "{show}");
        let picture = image::open(capture.path("shown.png")).expect("a picture").to_rgb8();
        assert_eq!(picture.dimensions(), (160, 120));
        let bright = picture.pixels().filter(|p| p.0[0] > 30).count();
        assert!(bright > 50 && picture.get_pixel(0, 0).0 == [0; 3], "{show}: {bright}");
    }
    assert_eq!(export(&["--view", "none.jpg"]), Some(2));
    assert_eq!(export(&["--view", "002.jpg", "--set", "contrast.enabled=false"]), Some(2));
    capture.run(&["--set", "report.evidence=true"]).assert().success();
    let shown = fs::read_dir(capture.path("results/tiny/evidence")).expect("a folder").count();
    assert_eq!(shown, 18);
}
