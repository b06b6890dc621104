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
}
