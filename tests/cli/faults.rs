//! Faults that `benches/faults.py` found once, each where it struck.

use super::capture::{Capture, rootvox};
use std::fs;
use std::path::{Path, PathBuf};

/// The folders of the nodes of a stage, by key.
fn nodes(capture: &Capture, stage: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(capture.path("cache/v1/nodes").join(stage)).expect("nodes");
    let mut nodes: Vec<PathBuf> = entries.map(|entry| entry.expect("a node").path()).collect();
    nodes.sort();
    nodes
}

fn output(capture: &Capture, arguments: &[&str]) -> (Option<i32>, String) {
    let output = rootvox().current_dir(capture.path("")).args(arguments).output().expect("runs");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The command fails and names the remedy; after that it gives `table` again.
fn is_told_and_mended(capture: &Capture, damaged: &Path, table: &str, right: &[u8]) {
    fs::remove_dir_all(capture.path("results")).expect("can remove");
    let (code, text) = output(capture, &["run", "study.toml"]);
    let name = damaged.file_name().expect("a name").to_string_lossy();
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("the store is damaged") && text.contains("cache verify") && text.contains(&*name), "{text}");
    assert!(!capture.path("results/tiny").exists(), "results from a damaged store");
    assert_eq!(output(capture, &["cache", "verify", "--repair"]).0, Some(0));
    assert_eq!(output(capture, &["run", "study.toml"]).0, Some(0));
    assert_eq!(fs::read(capture.path("results/tiny").join(table)).expect("is there"), right);
}

#[test]
fn a_table_that_rotted_is_not_copied_out() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let right = fs::read(capture.path("results/tiny/roots.csv")).expect("is there");
    let table = nodes(&capture, "traits")[0].join("roots.csv");
    let mut rotten = right.clone();
    let at = rotten.iter().rposition(u8::is_ascii_digit).expect("a digit");
    rotten[at] ^= 1;
    fs::write(&table, rotten).expect("can write");
    is_told_and_mended(&capture, &table, "roots.csv", &right);
}

#[test]
fn a_number_that_rotted_in_a_json_value_is_not_used() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let right = fs::read(capture.path("results/tiny/cameras.json")).expect("is there");
    let cameras = nodes(&capture, "cameras")[0].join("cameras.json");
    let mut rotten = fs::read(&cameras).expect("is there");
    let at = rotten.iter().rposition(u8::is_ascii_digit).expect("a digit");
    rotten[at] ^= 1;
    fs::write(&cameras, rotten).expect("can write");
    is_told_and_mended(&capture, &cameras, "cameras.json", &right);
}

#[test]
fn records_that_changed_places_are_computed_again() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let lock = || fs::read(capture.path("results/tiny/study.lock")).expect("is there");
    let right = lock();
    let overlays = nodes(&capture, "overlay");
    let (one, two) = (overlays[0].join("manifest.json"), overlays[1].join("manifest.json"));
    let (first, second) = (fs::read(&one).expect("a record"), fs::read(&two).expect("a record"));
    fs::write(&one, second).expect("can write");
    fs::write(&two, first).expect("can write");
    fs::remove_dir_all(capture.path("results")).expect("can remove");
    let (code, text) = output(&capture, &["run", "study.toml"]);
    assert_eq!((code, super::runs::computed(&text)), (Some(0), 2), "{text}");
    assert_eq!(lock(), right);
    assert_eq!(output(&capture, &["cache", "verify"]).0, Some(0));
}

/// A log on a full disk stops nothing; data that cannot be written is an error, not a panic.
#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_an_error_and_talk_is_not() {
    use std::process::{Command, Stdio};
    let capture = Capture::new();
    let full = || Stdio::from(fs::File::options().write(true).open("/dev/full").expect("opens"));
    let start = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rootvox"));
        command.current_dir(capture.path("")).args(arguments).env_remove("ROOTVOX_CACHE");
        command
    };
    let status = start(&["run", "study.toml"]).stderr(full()).status().expect("runs");
    assert!(status.success() && capture.path("results/tiny/study.lock").exists());
    for arguments in [&["status", "study.toml"][..], &["completions", "bash"]] {
        let output = start(arguments).stdout(full()).stderr(Stdio::piped()).output().expect("runs");
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{text}");
        assert!(text.contains("cannot write to the standard output"), "{text}");
    }
}
