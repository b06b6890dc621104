//! Bad input gets one clear error naming file, place, cause and remedy, the right exit code, and leaves
//! nothing half written.

use super::capture::Capture;
use std::fs;
use std::time::Duration;

/// Runs the study, expects the exit code and all the words in the message, no panic, and no results.
fn refused(capture: &Capture, more: &[&str], code: i32, words: &[&str]) {
    // What is refused is refused at once.
    let output = capture.run(more).timeout(Duration::from_secs(120)).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{text}");
    // Long messages are wrapped: compare without the breaks.
    let flat: String = text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
    for word in words {
        assert!(flat.contains(word), "no `{word}` in:\n{text}");
    }
    assert!(!text.contains("panicked"), "{text}");
    assert!(!capture.path("results").join("tiny").exists(), "results were written");
}

#[test]
fn a_truncated_photograph_is_named() {
    let capture = Capture::new();
    let photo = capture.path("images/002.jpg");
    let bytes = fs::read(&photo).expect("can read");
    fs::write(&photo, &bytes[..bytes.len() / 3]).expect("can write");
    refused(&capture, &[], 1, &["002.jpg", "help:"]);
    fs::write(&photo, b"").expect("can write");
    refused(&capture, &[], 1, &["002.jpg", "empty"]);
}

#[test]
fn a_photograph_without_camera_is_named() {
    let capture = Capture::new();
    fs::copy(capture.path("images/002.jpg"), capture.path("images/099.jpg")).expect("can copy");
    refused(&capture, &[], 1, &["099.jpg", "no view"]);
}

#[test]
fn a_missing_camera_file_is_named() {
    let capture = Capture::new();
    refused(&capture, &["--set", "cameras.path=nowhere.json"], 1, &["nowhere.json"]);
}

#[test]
fn a_photograph_of_another_size_is_named() {
    let capture = Capture::new();
    image::RgbImage::new(80, 60).save(capture.path("images/003.jpg")).expect("can save");
    refused(&capture, &[], 1, &["003.jpg", "80 x 60", "160 x 120"]);
}

#[test]
fn a_picture_of_text_is_refused() {
    let capture = Capture::new();
    fs::write(capture.path("images/001.jpg"), "not a picture").expect("can write");
    refused(&capture, &[], 1, &["001.jpg"]);
}

#[test]
fn faults_of_the_study_file_are_shown_together() {
    let capture = Capture::new();
    capture.edit("study.toml", "spacing = 1.0", "spacing = \"fine\"\nspaceing = 2.0");
    refused(&capture, &[], 2, &["study.toml", "line 11", "invalid type", "line 12", "spaceing", "expected"]);
}

#[test]
fn an_unknown_override_is_named() {
    let capture = Capture::new();
    refused(&capture, &["--set", "merge.tolerence=0.1"], 2, &["--set", "tolerence", "tolerance"]);
    refused(&capture, &["--set", "extract.high"], 2, &["no `=`"]);
}

#[test]
fn a_study_file_that_is_not_there_or_no_toml() {
    let capture = Capture::new();
    fs::remove_file(capture.path("study.toml")).expect("can remove");
    refused(&capture, &[], 2, &["study.toml", "pipelines/"]);
    fs::write(capture.path("study.toml"), "[tank\nradius = ").expect("can write");
    refused(&capture, &[], 2, &["study.toml", "line 1"]);
}

#[test]
fn a_wall_thicker_than_the_tank_is_refused() {
    let capture = Capture::new();
    refused(&capture, &["--set", "tank.wall=40"], 2, &["tank.wall", "40 mm", "30 mm"]);
    refused(&capture, &["--set", "tank.radius=nan"], 2, &["tank.radius", "`nan` is not a finite number"]);
    refused(&capture, &["--set", "tank.index.water=0.2"], 2, &["tank.index.water"]);
}

#[test]
fn a_camera_inside_the_tank_is_refused() {
    let capture = Capture::new();
    refused(&capture, &["--set", "tank.radius=4000"], 1, &["cameras.json", "inside the tank", "4000"]);
}

#[test]
fn nan_in_the_cameras_is_shown_at_its_place() {
    let capture = Capture::new();
    capture.edit("cameras.json", "\"cx\": ", "\"cx\": NaN, \"was\": ");
    refused(&capture, &[], 1, &["cameras.json", "line", "NaN"]);
}

#[test]
fn cameras_cut_off_are_said_to_be() {
    let capture = Capture::new();
    let text = fs::read_to_string(capture.path("cameras.json")).expect("can read");
    fs::write(capture.path("cameras.json"), &text[..text.len() / 2]).expect("can write");
    refused(&capture, &[], 1, &["cameras.json", "ends too early"]);
}

#[test]
fn an_empty_folder_is_named() {
    let capture = Capture::new();
    for entry in fs::read_dir(capture.path("images")).expect("images") {
        fs::remove_file(entry.expect("entry").path()).expect("can remove");
    }
    refused(&capture, &[], 2, &["no photograph matches", "images"]);
    refused(&capture, &["--set", "photos.dir=nowhere"], 2, &["there is no folder", "nowhere"]);
}

#[test]
fn a_store_that_cannot_be_written_is_named() {
    let capture = Capture::new();
    // A file where the folder should be: refused to every user, root included.
    fs::write(capture.path("blocked"), "").expect("can write");
    refused(&capture, &["--cache", "blocked/store"], 1, &["blocked/store", "--cache"]);
}

#[test]
fn results_that_cannot_be_written_are_told_of_before_anything_is_computed() {
    let capture = Capture::new();
    fs::write(capture.path("results"), b"a file").expect("can write");
    refused(&capture, &[], 1, &["results", "--results"]);
    assert!(!capture.path("cache").join("v1").exists(), "something was computed");
}

#[test]
fn what_is_no_result_is_never_replaced() {
    let capture = Capture::new();
    // A folder of photographs where the results would go.
    fs::create_dir_all(capture.path("plants/tiny")).expect("can make");
    fs::write(capture.path("plants/tiny/001.jpg"), b"mine").expect("can write");
    let output = capture.run(&["--results", "plants"]).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{text}");
    assert!(text.contains("no results folder") && text.contains("--results"), "{text}");
    assert_eq!(fs::read(capture.path("plants/tiny/001.jpg")).expect("is there"), b"mine");
}

#[test]
fn numbers_that_are_none_are_shown_at_their_place() {
    let capture = Capture::new();
    for (set, words) in [
        ("extract.high=nan", ["--set extract.high", "`nan` is not a finite number"]),
        ("rootness.sigma=[1.0, -inf]", ["--set rootness.sigma", "`-inf` is not a finite number"]),
        ("extract.low=1e39", ["--set extract.low", "too large"]),
        ("tank.belts=[[1, 2, 3]]", ["--set tank.belts", "expected 2 values, found 3"]),
        ("overlay.mark_radius=-1", ["overlay.mark_radius", "0 to 100 px"]),
        ("simulate.capture.views=100000000", ["simulate.capture.views", "1 to 10000"]),
        ("simulate.growth.first_order.count=1000000000", ["simulate.growth.first_order.count", "at most"]),
    ] {
        refused(&capture, &["--set", set], 2, &words);
    }
    capture.edit("study.toml", "depth = 60.0", "depth = nan");
    refused(&capture, &[], 2, &["study.toml` line", "`nan` is not a finite number"]);
}

#[test]
fn options_that_cannot_be_meant_are_refused_before_anything_runs() {
    let capture = Capture::new();
    for threads in ["0", "1000000", "many"] {
        refused(&capture, &["--threads", threads], 2, &["--threads"]);
    }
    refused(&capture, &["--memory", "much"], 2, &["--memory"]);
    refused(&capture, &["--best", "f1_1mm"], 2, &["is no sweep", "help:"]);
    refused(&capture, &["--trace", "nowhere/trace.json"], 1, &["nowhere/trace.json", "--trace"]);
    assert!(!capture.path("cache/v1/nodes/render").exists(), "something ran");
}

#[test]
fn grids_out_of_reason_are_refused() {
    let capture = Capture::new();
    for (set, words) in [
        ("grid.spacing=0.0001", ["grid.spacing = 0.0001 mm is too fine", "raise it"]),
        ("grid.spacing=1e-300", ["grid.spacing = 1e-300 mm is too fine", "raise it"]),
        ("grid.spacing=-1", ["grid.spacing is -1 mm", "positive length"]),
        ("grid.spacing=0", ["grid.spacing is 0 mm", "positive length"]),
        ("grid.spacing=100", ["grid.spacing = 100.0 mm is too coarse", "some voxels"]),
        ("rootness.sigma=[100.0]", ["does not suit rootness.sigma = 100 mm", "0.4 and 20 voxels"]),
        ("grid.depth=inf", ["grid.depth", "`inf` is not a finite number"]),
        ("grid.depth=1e9", ["grid.depth is 1000000000 mm, the tank 70 mm high", "leave it out"]),
        ("grid.depth=0", ["grid.depth is 0 mm", "positive length"]),
    ] {
        refused(&capture, &["--set", set], 2, &words);
        let output = capture.run(&["--set", set]).output().expect("runs");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(text.matches("error:").count(), 1, "{set}: {text}");
    }
}

#[test]
fn studies_that_can_hardly_be_meant_are_refused_before_anything_runs() {
    let capture = Capture::new();
    // Days of one thread: 200 times 0.9 thousand million voxels.
    let sweep = "sweep.merge.tolerance={ from = 0.001, to = 0.2, count = 200 }";
    let endless = ["--threads", "1", "--set", "grid.spacing=0.06", "--set", sweep];
    refused(&capture, &endless, 2, &["hours on 1 threads", "grid.spacing", "--yes"]);
    assert!(!capture.path("cache/v1/nodes/undistort").exists(), "something ran");
}

#[test]
fn a_missing_colmap_a_mask_that_hides_all_and_a_folder_without_model_are_named() {
    let capture = Capture::new();
    let sfm = ["--set", "cameras.source=sfm"];
    let belts = [&sfm[..], &["--set", "mask.rectangles_px=[[0.0, 0.0, 60.0, 40.0]]"]].concat();
    let output = capture.run(&belts).env("PATH", "").output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("colmap") && text.contains("apt install"), "{text}");

    let hidden = [&sfm[..], &["--set", "mask.rectangles_px=[[90000.0, 0.0, 9.0, 9.0]]"]].concat();
    refused(&capture, &hidden, 1, &["mask", "rectangles_px"]);
    refused(&capture, &["--set", "cameras.path=images"], 2, &["no COLMAP model", "points3D"]);
}
