//! A result made again from its lock, and what the comparison says where something changed.

use super::capture::{Capture, rootvox};
use std::fs;

/// Exit code and both outputs of `rootvox rerun` on the capture's result.
fn rerun(capture: &Capture, more: &[&str]) -> (Option<i32>, String) {
    let mut command = rootvox();
    command.current_dir(capture.path("")).args(["rerun", "results/tiny/study.lock"]).args(more);
    let output = command.output().expect("runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

#[test]
fn a_lock_is_repeated_bit_for_bit_in_an_empty_store_at_any_thread_count() {
    let capture = Capture::new();
    capture.run(&["--set", "extract.high=1.2"]).assert().success();
    // Neither the study file nor its defaults matter any more.
    fs::remove_file(capture.path("study.toml")).expect("can remove");
    for threads in ["1", "2"] {
        let (code, text) = rerun(&capture, &["--cache", &format!("empty-{threads}"), "--threads", threads]);
        assert_eq!(code, Some(0), "{text}");
        let line = text.lines().find(|l| l.ends_with("nodes bit-identical")).expect("a verdict");
        let words: Vec<&str> = line.split(' ').collect();
        assert_eq!(words[0], words[2], "{text}");
        assert!(text.contains(" 0 cached"), "{text}");
    }
    // Moved as a whole: the lock finds its photographs from where it lies.
    let elsewhere = Capture::new();
    fs::create_dir_all(elsewhere.path("results/tiny")).expect("can create");
    fs::copy(capture.path("results/tiny/study.lock"), elsewhere.path("results/tiny/study.lock")).expect("can copy");
    assert_eq!(rerun(&elsewhere, &[]).0, Some(0));
    // Or is told where they are.
    fs::rename(elsewhere.path("results/tiny"), elsewhere.path("results-tiny")).expect("can move");
    fs::create_dir_all(elsewhere.path("results/deeper/tiny")).expect("can create");
    let deeper = elsewhere.path("results/deeper/tiny/study.lock");
    fs::copy(elsewhere.path("results-tiny/study.lock"), &deeper).expect("can copy");
    let mut told = rootvox();
    told.current_dir(elsewhere.path("")).args(["rerun", "results/deeper/tiny/study.lock", "--photos-dir", "."]);
    told.assert().success();
}

#[test]
fn a_folder_that_is_not_the_captures_is_told_of_with_the_option_that_rerun_takes() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    for dir in ["nowhere", "results"] {
        let (code, text) = rerun(&capture, &["--photos-dir", dir]);
        assert_eq!(code, Some(2), "{text}");
        assert!(text.contains("--photos-dir DIR") && text.contains(dir) && !text.contains("--set"), "{text}");
    }
}

#[test]
fn what_changed_since_is_named() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let lock = "results/tiny/study.lock";

    capture.edit(lock, "\"extract.high\": \"1.1\"", "\"extract.high\": \"1.3\"");
    let (code, text) = rerun(&capture, &[]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("first to differ: extract: setting: `high`: 1.1 -> 1.3"), "{text}");
    capture.edit(lock, "\"extract.high\": \"1.3\"", "\"extract.high\": \"1.1\"");

    let photo = fs::read(capture.path("images/002.jpg")).expect("can read");
    let mut picture = image::open(capture.path("images/002.jpg")).expect("a picture").to_rgb8();
    picture.put_pixel(80, 60, image::Rgb([255, 0, 0]));
    picture.save(capture.path("images/002.jpg")).expect("can save");
    let (code, text) = rerun(&capture, &[]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("first to differ: photo/002.jpg: input"), "{text}");

    fs::write(capture.path("images/002.jpg"), &photo).expect("can write");

    // A lock of a version whose merge gave other numbers.
    let text = fs::read_to_string(capture.path(lock)).expect("is there");
    let mut page: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let works = page["work"].as_array_mut().expect("works");
    let merge = works.iter().position(|work| work["stage"] == "merge").expect("a merge");
    works[merge]["version"] = 0.into();
    for node in page["nodes"].as_array_mut().expect("nodes").iter_mut().filter(|node| node["work"] == merge) {
        node["digest"] = "0".repeat(64).into();
    }
    fs::write(capture.path(lock), page.to_string()).expect("can write");
    let (code, text) = rerun(&capture, &[]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("first to differ: merge: version: the stage `merge` was 0 and is "), "{text}");

    fs::write(capture.path(lock), "{}").expect("can write");
    assert_eq!(rerun(&capture, &[]).0, Some(2));
}

#[test]
fn a_sweep_is_repeated_from_its_lock() {
    let capture = Capture::new();
    capture
        .run(&["--set", "sweep.extract.high=[0.9, 1.5]", "--set", "sweep.grid.spacing=[1.0, 2.0]"])
        .assert()
        .success();
    let (code, text) = rerun(&capture, &["--cache", "empty"]);
    assert_eq!(code, Some(0), "{text}");
}

#[test]
fn results_say_what_they_are() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let text = fs::read_to_string(capture.path("results/tiny/ro-crate-metadata.json")).expect("is there");
    let page: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let graph = page["@graph"].as_array().expect("a graph");
    let entity = |id: &str| graph.iter().find(|e| e["@id"] == id).unwrap_or_else(|| panic!("no {id}"));
    // A result that lost a part is written again.
    fs::remove_file(capture.path("results/tiny/roots.csv")).expect("can remove");
    capture.run(&[]).assert().success();
    assert!(capture.path("results/tiny/roots.csv").exists());
    for part in entity("./")["hasPart"].as_array().expect("parts") {
        let part = entity(part["@id"].as_str().expect("an id"));
        assert!(capture.path("results/tiny").join(part["@id"].as_str().expect("an id")).exists(), "{part}");
        assert_ne!(part["description"], "", "{part}");
    }
    assert!(entity("#resident-peak")["value"].as_str().expect("measured").parse::<u64>().expect("bytes") > 1 << 20);
    assert_eq!(entity("./")["license"]["@id"], "#license");
    fs::write(capture.path("results/tiny/notes.txt"), b"mine").expect("can write");
    capture.run(&["--set", "study.license='CC-BY-4.0'"]).assert().success();
    assert!(capture.path("results/tiny/notes.txt").exists(), "what people put beside the results stays");
    fs::remove_file(capture.path("results/tiny/ro-crate-metadata.json")).expect("can remove");
    capture.run(&["--set", "study.license='CC-BY-4.0'"]).assert().success();
    assert!(capture.path("results/tiny/notes.txt").exists(), "also where the list of parts is lost");
    let text = fs::read_to_string(capture.path("results/tiny/ro-crate-metadata.json")).expect("is there");
    assert!(text.contains("https://spdx.org/licenses/CC-BY-4.0"), "{text}");
    assert_eq!(entity("#run")["object"].as_array().expect("inputs").len(), 7, "six photographs and the cameras");
}
