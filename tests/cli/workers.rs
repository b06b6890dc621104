//! Workers on one store: they share the work, are stopped and killed, and do without file locks.

use super::capture::{Capture, rootvox};
use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

fn worker(capture: &Capture, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rootvox"));
    command.current_dir(capture.path("")).args(["work", "study.toml", "--cores", "1"]).args(more);
    command.env_remove("ROOTVOX_CACHE").stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// What a worker that ended well said of itself: nodes computed, and in vain.
fn said(child: Child) -> (usize, usize) {
    let output = child.wait_with_output().expect("ends");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    let before = |word: &str| -> usize {
        let head = text.split(word).next().expect("a word");
        head.split_whitespace().last().and_then(|n| n.parse().ok()).unwrap_or_else(|| panic!("{word}: {text}"))
    };
    (before(" nodes in"), before(" of them in vain"))
}

fn lock(capture: &Capture) -> String {
    fs::read_to_string(capture.path("results/tiny/study.lock")).expect("is there")
}

fn entries(folder: &Path) -> usize {
    fs::read_dir(folder).map_or(0, Iterator::count)
}

/// A study made for longer work, and its lock when one process does it all.
fn study(capture: &Capture) -> String {
    capture.edit("study.toml", "spacing = 1.0", "spacing = 0.7");
    capture.run(&["--cache", "alone"]).assert().success();
    let alone = lock(capture);
    fs::remove_dir_all(capture.path("results")).expect("can remove");
    alone
}

/// Runs the study once more: the results are those of one process, and nothing is left behind.
fn settle(capture: &Capture, alone: &str) {
    capture.run(&[]).assert().success();
    assert_eq!(lock(capture), alone);
    for folder in ["cache/v1/locks", "cache/v1/tmp"] {
        assert_eq!(entries(&capture.path(folder)), 0, "{folder}");
    }
}

#[test]
fn three_workers_compute_every_node_once() {
    let capture = Capture::new();
    let alone = study(&capture);
    let workers: Vec<Child> = (0..3).map(|_| worker(&capture, &[]).spawn().expect("starts")).collect();
    let all: Vec<(usize, usize)> = workers.into_iter().map(said).collect();
    let history = fs::read_dir(capture.path("cache/v1/history")).expect("a history");
    let lines: usize =
        history.map(|file| fs::read_to_string(file.expect("entry").path()).expect("can read").lines().count()).sum();
    assert!(all.iter().all(|(_, vain)| *vain == 0), "{all:?}");
    assert_eq!(all.iter().map(|(nodes, _)| nodes).sum::<usize>(), lines, "{all:?}");
    let again = capture.run(&[]).output().expect("runs");
    assert_eq!(super::runs::computed(&String::from_utf8_lossy(&again.stderr)), 0);
    settle(&capture, &alone);
    let status = rootvox().current_dir(capture.path("")).args(["cluster", "status", "study.toml"]).output();
    let text = String::from_utf8_lossy(&status.expect("runs").stdout).into_owned();
    assert!(text.contains(" 0 to do: 0 running, 0 failed"), "{text}");
    assert!(text.contains("computed more than once: 0 nodes"), "{text}");
}

#[cfg(unix)]
#[test]
fn a_worker_that_is_stopped_gives_back_what_it_holds_and_one_that_is_killed_is_inherited() {
    let capture = Capture::new();
    let alone = study(&capture);
    for signal in ["-TERM", "-KILL"] {
        let mut child = worker(&capture, &[]).spawn().expect("starts");
        let begun = Instant::now();
        while entries(&capture.path("cache/v1/locks")) == 0 && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(2));
        }
        let sent = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
        assert!(sent.success());
        if signal == "-TERM" {
            said(child);
            assert_eq!(entries(&capture.path("cache/v1/locks")), 0, "claims are given back");
            assert_eq!(entries(&capture.path("cache/v1/tmp")), 0, "drafts are removed");
        } else {
            child.wait().expect("ends");
        }
    }
    said(worker(&capture, &[]).spawn().expect("starts"));
    settle(&capture, &alone);
}

#[test]
fn a_worker_ends_when_its_time_is_over() {
    let capture = Capture::new();
    assert_eq!(said(worker(&capture, &["--for", "0s"]).spawn().expect("starts")).0, 0);
    let refused = worker(&capture, &["--for", "soon"]).output().expect("runs");
    assert_eq!(refused.status.code(), Some(2));
}

/// A file system without locks: every request is refused, or granted to everybody.
const SHIM: &str = r#"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
static int answer(void) {
    if (getenv("ROOTVOX_TEST_REFUSE")) { errno = ENOLCK; return -1; }
    return 0;
}
int flock(int fd, int operation) { (void)fd; (void)operation; return answer(); }
"#;

#[cfg(target_os = "linux")]
#[test]
fn without_file_locks_results_are_right_and_work_is_shared() {
    let capture = Capture::new();
    let alone = study(&capture);
    fs::write(capture.path("shim.c"), SHIM).expect("can write");
    let built = Command::new("cc")
        .current_dir(capture.path(""))
        .args(["-shared", "-fPIC", "-o", "shim.so", "shim.c"])
        .status()
        .expect("a C compiler, which building needs too");
    assert!(built.success());
    for refuse in [false, true] {
        let start = || {
            let mut command = worker(&capture, &[]);
            command.env("LD_PRELOAD", capture.path("shim.so"));
            if refuse {
                command.env("ROOTVOX_TEST_REFUSE", "1");
            }
            command.spawn().expect("starts")
        };
        let workers: Vec<Child> = (0..3).map(|_| start()).collect();
        let all: Vec<(usize, usize)> = workers.into_iter().map(said).collect();
        assert!(all.iter().all(|(_, vain)| *vain == 0), "refused: {refuse}, {all:?}");
        settle(&capture, &alone);
        fs::remove_dir_all(capture.path("cache")).expect("can remove");
    }
}
