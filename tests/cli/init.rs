//! `rootvox init`: a study file from a folder, and what shells and `man` are told.

use super::capture::{Capture, rootvox, stderr};
use assert_cmd::Command;
use std::fs;

fn init(capture: &Capture, more: &[&str]) -> Command {
    let mut command = rootvox();
    command.current_dir(capture.path("")).args(["init", "."]).args(more);
    command
}

#[test]
fn a_folder_with_all_beside_its_photographs_runs_without_a_question() {
    let capture = Capture::new();
    let said = stderr(&mut init(&capture, &["-o", "new.toml"]));
    assert!(said.contains("photographs of") && said.contains("rootvox run new.toml"), "{said}");
    let text = fs::read_to_string(capture.path("new.toml")).unwrap();
    for line in ["cameras.json", "tank.json", "roots.json", "images/*.jpg"] {
        assert!(text.contains(line), "no `{line}` in:\n{text}");
    }
    let run = ["run", "new.toml", "--set", "grid.spacing=1.0", "--set", "grid.depth=60.0"];
    rootvox().current_dir(capture.path("")).args(run).assert().success();
    assert!(capture.path("results/new/roots_score.json").is_file());
    assert!(stderr(&mut init(&capture, &["-o", "new.toml"])).contains("not overwritten"));
    assert_eq!(fs::read_to_string(capture.path("new.toml")).unwrap(), text);
}

#[test]
fn what_must_be_measured_is_asked_for_or_given() {
    let capture = Capture::new();
    fs::remove_file(capture.path("tank.json")).unwrap();
    fs::remove_file(capture.path("cameras.json")).unwrap();
    let said = stderr(init(&capture, &["-o", "new.toml", "--radius", "45"]).write_stdin(""));
    assert!(said.contains("--height, --wall, --water-level not given"), "{said}");
    assert!(!capture.path("new.toml").exists());
    let tank = |wall| ["--radius", "45", "--height", "130", "--wall", wall, "--water-level", "8", "-o", "new.toml"];
    init(&capture, &tank("50")).assert().code(2);
    assert!(!capture.path("new.toml").exists(), "what does not load stays");
    init(&capture, &tank("3")).args(["--belt", "0,16", "--belt", "114, 130"]).assert().success();
    let text = fs::read_to_string(capture.path("new.toml")).unwrap();
    assert!(text.contains("source = \"sfm\"") && text.contains("belts = [[0.0, 16.0], [114.0, 130.0]]"), "{text}");
}

#[test]
fn a_folder_without_photographs_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let mut command = rootvox();
    command.current_dir(folder.path()).args(["init", "."]).assert().code(2);
    assert!(stderr(&mut command).contains("no photograph"));
}

#[test]
fn shells_and_man_know_every_command() {
    let bash = rootvox().args(["completions", "bash"]).output().unwrap();
    assert!(bash.status.success() && String::from_utf8_lossy(&bash.stdout).contains("--water-level"));
    let folder = tempfile::tempdir().unwrap();
    rootvox().args(["man", "pages"]).current_dir(folder.path()).assert().success();
    for page in ["rootvox.1", "rootvox-run.1", "rootvox-init.1"] {
        assert!(fs::read_to_string(folder.path().join("pages").join(page)).unwrap().contains("rootvox"), "{page}");
    }
}
