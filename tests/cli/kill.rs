//! A run killed at any instant leaves a sound store, and running again gives what an undisturbed run gives.

use super::capture::{Capture, rootvox};
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

fn spawn(capture: &Capture) -> std::process::Child {
    Command::new(env!("CARGO_BIN_EXE_rootvox"))
        .current_dir(capture.path(""))
        .args(["run", "study.toml"])
        .env_remove("ROOTVOX_CACHE")
        .stderr(Stdio::null())
        .spawn()
        .expect("starts")
}

#[test]
fn killed_twenty_times_then_run_again() {
    let undisturbed = Capture::new();
    let begin = Instant::now();
    undisturbed.run(&[]).assert().success();
    let whole = begin.elapsed();

    let killed = Capture::new();
    // Instants spread over the whole run by the golden ratio, in a scrambled order.
    for n in 1..=20 {
        let share = (f64::from(n) * 0.618_033_988_749_895).fract();
        let mut child = spawn(&killed);
        std::thread::sleep(whole.mul_f64(share * 0.8) + Duration::from_millis(1));
        let _ = child.kill();
        child.wait().expect("is gone");
        let results = killed.path("results/tiny");
        assert!(!results.exists() || results.join("study.lock").exists(), "half written results after kill {n}");
    }
    killed.run(&[]).assert().success();
    let lock = |c: &Capture| fs::read_to_string(c.path("results/tiny/study.lock")).expect("is there");
    assert_eq!(lock(&undisturbed), lock(&killed), "keys and digests of an undisturbed run");

    let verdict = rootvox().current_dir(killed.path("")).args(["cache", "verify"]).output().expect("runs");
    let text = String::from_utf8_lossy(&verdict.stdout).into_owned();
    assert!(verdict.status.success() && text.contains("0 bad"), "{text}");
}

#[test]
fn two_runs_at_once_share_one_store() {
    let capture = Capture::new();
    let (mut one, mut two) = (spawn(&capture), spawn(&capture));
    assert!(one.wait().expect("ends").success() && two.wait().expect("ends").success());
    let alone = Capture::new();
    alone.run(&[]).assert().success();
    let lock = |c: &Capture| fs::read_to_string(c.path("results/tiny/study.lock")).expect("is there");
    assert_eq!(lock(&capture), lock(&alone));
}

/// Nodes that a run computed, from its last words.
fn computed(child: std::process::Child) -> usize {
    let output = child.wait_with_output().expect("ends");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{text}");
    super::runs::computed(&text)
}

#[test]
fn overlapping_sweeps_of_two_processes_compute_every_node_once() {
    let capture = Capture::new();
    for (name, values) in [("one", "[0.8, 1.0, 1.2]"), ("two", "[1.0, 1.2, 1.5]")] {
        let text = fs::read_to_string(capture.path("study.toml"))
            .expect("can read")
            .replace("\"tiny\"", &format!("\"{name}\""));
        fs::write(capture.path(&format!("{name}.toml")), text + &format!("[sweep]\nextract.high = {values}\n"))
            .expect("can write");
    }
    let start = |name: &str, turn: u32| {
        Command::new(env!("CARGO_BIN_EXE_rootvox"))
            .current_dir(capture.path(""))
            .args(["run", &format!("{name}.toml"), "--cache", &format!("cache-{turn}")])
            .stderr(Stdio::piped())
            .spawn()
            .expect("starts")
    };
    let mut first = None;
    for turn in 0..10 {
        let (one, two) = (start("one", turn), start("two", turn));
        let ran = computed(one) + computed(two);
        let mut digests = std::collections::BTreeMap::new();
        for name in ["one", "two"] {
            let text = fs::read_to_string(capture.path(&format!("results/{name}/study.lock"))).expect("is there");
            let lock: serde_json::Value = serde_json::from_str(&text).expect("JSON");
            for node in lock["nodes"].as_array().expect("nodes").iter().filter(|node| node.get("key").is_some()) {
                let (key, digest) = (node["key"].to_string(), node["digest"].to_string());
                assert_eq!(*digests.entry(key).or_insert_with(|| digest.clone()), digest, "turn {turn}");
            }
        }
        assert_eq!(ran, digests.len(), "turn {turn}: a node was computed twice");
        assert_eq!(*first.get_or_insert_with(|| digests.clone()), digests, "turn {turn}");
        let verdict = rootvox()
            .current_dir(capture.path(""))
            .args(["cache", "verify", "--cache", &format!("cache-{turn}")])
            .output();
        assert!(verdict.expect("runs").status.success(), "turn {turn}");
        fs::remove_dir_all(capture.path(&format!("cache-{turn}"))).expect("can remove");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_keeps_what_is_finished_and_says_so() {
    let capture = Capture::new();
    let child = Command::new(env!("CARGO_BIN_EXE_rootvox"))
        .current_dir(capture.path(""))
        .args(["run", "study.toml", "--threads", "1", "--set", "grid.spacing=0.25"])
        .env_remove("ROOTVOX_CACHE")
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    std::thread::sleep(Duration::from_millis(400));
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(sent.success());
    let output = child.wait_with_output().expect("ends");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{text}");
    assert!(text.contains("goes on from there"), "{text}");
    // Nothing that was finished is computed again, and nothing is left half.
    let before = super::runs::computed(&text);
    let again = capture.run(&["--set", "grid.spacing=0.25", "--results", "again"]).output().expect("runs");
    let again = String::from_utf8_lossy(&again.stderr).into_owned();
    let line = again.lines().find(|line| line.contains(" computed")).expect("a summary");
    assert!(line.contains(&format!(" {before} cached")), "{before} were finished: {line}");
}
