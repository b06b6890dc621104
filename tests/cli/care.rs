//! Looking after a store from the command line: figures, pins, repair, a lab's store that cannot be written.

use super::capture::{Capture, rootvox, stderr};
use super::runs::computed;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Exit code and both outputs of `rootvox cache` with these arguments.
fn cache(capture: &Capture, arguments: &[&str]) -> (Option<i32>, String) {
    let output = rootvox().current_dir(capture.path("")).arg("cache").args(arguments).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), text)
}

/// The folder of the one node of a stage.
fn node_of(capture: &Capture, stage: &str) -> PathBuf {
    let mut nodes = fs::read_dir(capture.path("cache/v1/nodes").join(stage)).expect("nodes");
    nodes.next().expect("a node").expect("a node").path()
}

fn some_file_below(folder: &Path) -> PathBuf {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder).expect("a folder").map(|e| e.expect("entry").path()).collect();
    entries.sort();
    let inner = entries.iter().find(|path| path.is_dir()).map(|path| some_file_below(path));
    inner.unwrap_or_else(|| entries[0].clone())
}

#[test]
fn room_is_made_as_announced_and_pins_stay() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    capture.run(&["--set", "extract.high=1.5"]).assert().success();
    let (code, text) = cache(&capture, &["gc"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(text.contains("nothing says what may go"), "{text}");

    let (_, tried) = cache(&capture, &["gc", "--reachable", "study.toml", "--dry-run"]);
    let (code, done) = cache(&capture, &["gc", "--reachable", "study.toml"]);
    assert_eq!((code, tried.replace("would remove", "removed")), (Some(0), done.clone()));
    assert!(!done.starts_with("removed 0 nodes"), "{done}");
    assert_eq!(computed(&stderr(&mut capture.run(&[]))), 0, "what the study reaches has stayed");

    assert!(cache(&capture, &["pin", "results/tiny/study.lock"]).1.contains("pinned `tiny`"));
    let (_, none) = cache(&capture, &["gc", "--keep", "0", "--older-than", "0"]);
    assert!(none.starts_with("removed 0 nodes and the values of 0: 0 B"), "{none}");
    let (_, pins) = cache(&capture, &["pins"]);
    assert!(pins.starts_with("tiny "), "{pins}");
    cache(&capture, &["unpin", "tiny"]);
    let (_, all) = cache(&capture, &["gc", "--keep", "0"]);
    assert!(all.contains(" with 0 B stay"), "{all}");
    // Its values are gone: what a run computes for the results' sake is what the plan announces.
    let mut status = rootvox();
    let plan = status.current_dir(capture.path("")).args(["status", "study.toml"]).output().expect("runs");
    let plan = String::from_utf8_lossy(&plan.stdout).into_owned();
    assert!(plan.contains("computed before, but no longer in the store"), "{plan}");
    let announced = computed(&stderr(&mut capture.run(&[])));
    assert!(announced > 0 && plan.contains(&format!(" cached, {announced} would run or may")), "{announced}: {plan}");
}

#[test]
fn damage_is_found_and_computed_again() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let shard = some_file_below(&node_of(&capture, "merge"));
    let mut bytes = fs::read(&shard).expect("can read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&shard, bytes).expect("can write");
    let (code, text) = cache(&capture, &["verify"]);
    assert_eq!(code, Some(1), "{text}");
    assert!(text.contains("1 bad, 0 removed") && text.contains("--repair"), "{text}");
    let (code, text) = cache(&capture, &["verify", "--repair", "--study", "study.toml"]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("1 bad, 1 removed") && text.contains("computed again: merge\n"), "{text}");
    assert_eq!(cache(&capture, &["verify"]).0, Some(0));
    assert_eq!(computed(&stderr(&mut capture.run(&[]))), 0);

    // A record that cannot be read costs its node and nothing else.
    fs::write(node_of(&capture, "rootness").join("manifest.json"), "{ half").expect("can write");
    let text = stderr(&mut capture.run(&[]));
    assert!(text.contains("rootness: ") && computed(&text) == 1, "{text}");
    assert_eq!(cache(&capture, &["verify"]).0, Some(0));
}

#[test]
fn a_store_that_is_not_there_is_neither_made_nor_guessed() {
    let capture = Capture::new();
    let mut status = rootvox();
    let plan = status.current_dir(capture.path("")).args(["status", "study.toml"]).output().expect("runs");
    assert!(plan.status.success() && String::from_utf8_lossy(&plan.stdout).contains("never computed before"));
    assert!(!capture.path("cache").exists(), "asking made a store");
    for action in [&["du"][..], &["ls"], &["verify"], &["gc", "--keep", "1GiB"]] {
        let (code, text) = cache(&capture, &[action, &["--cache", "images"]].concat());
        assert_eq!(code, Some(2), "{text}");
        assert!(text.contains("there is no store in `images`"), "{text}");
    }
    assert!(!capture.path("images/v1").exists());
}

#[test]
fn a_stage_that_the_store_does_not_hold_is_told_with_those_it_does() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let (code, text) = cache(&capture, &["ls", "--stage", "merge"]);
    assert_eq!((code, text.lines().count()), (Some(0), 1), "{text}");
    let (code, text) = cache(&capture, &["ls", "--stage", "nope"]);
    assert_eq!(code, Some(2), "{text}");
    assert!(
        text.contains("no node of a stage `nope`") && text.contains("merge, ") && text.contains("undistort"),
        "{text}"
    );
}

/// The program as a user who may read but not write the lab's store, whoever runs the tests.
#[cfg(unix)]
#[test]
fn a_store_that_cannot_be_written_serves_as_upstream() {
    use std::os::unix::fs::PermissionsExt;
    let capture = Capture::new();
    capture.run(&["--cache", "lab"]).assert().success();
    let below = |folder: &Path| {
        let (mut open, mut all) = (vec![folder.to_owned()], Vec::new());
        while let Some(path) = open.pop() {
            if path.is_dir() {
                open.extend(fs::read_dir(&path).expect("a folder").map(|e| e.expect("entry").path()));
            }
            all.push(path);
        }
        all
    };
    let set = |write: u32| {
        for path in below(&capture.path("lab")) {
            let mode = if path.is_dir() { 0o555 } else { 0o444 } | write;
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).expect("can change");
        }
    };
    set(0);
    let read = fs::Permissions::from_mode;
    fs::set_permissions(capture.path(""), read(0o777)).expect("can change");
    let program = env!("CARGO_BIN_EXE_rootvox");
    // Permissions do not bind root: then the program runs as nobody, where that user can start it.
    let as_nobody = || {
        let mut command = Command::new("setpriv");
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", program]);
        command
    };
    let is_root = fs::write(capture.path("lab/probe"), "").is_ok();
    let _ = fs::remove_file(capture.path("lab/probe"));
    let drops = is_root && as_nobody().arg("--version").output().is_ok_and(|output| output.status.success());
    let run = |more: &[&str]| {
        let mut command = if drops { as_nobody() } else { Command::new(program) };
        command.current_dir(capture.path("")).args(["run", "study.toml", "--results", "own-results"]).args(more);
        let output = command.output().expect("runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let over = ["--cache", "own", "--cache-upstream", "lab"];
    let (code, text) = run(&over);
    assert_eq!((code, computed(&text)), (Some(0), 0), "{text}");
    let (code, text) = run(&[&over[..], &["--set", "extract.high=1.5"]].concat());
    assert!(code == Some(0) && computed(&text) > 0, "{text}");
    // Read on its own it still serves; what is missing cannot be kept, and the message says what to do.
    let (code, text) = run(&["--cache", "lab"]);
    assert_eq!((code, computed(&text)), (Some(0), 0), "{text}");
    if drops || !is_root {
        let (code, text) = run(&["--cache", "lab", "--set", "extract.high=1.7"]);
        assert_eq!(code, Some(1), "{text}");
        assert!(text.contains("make it writable, or name another folder"), "{text}");
    }
    set(0o200);
}
