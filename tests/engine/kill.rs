//! Processes that are killed, that run out of room, and that run at the same time.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use rootvox::store::Store;

use crate::toy::{Study, count_files, run_logged, write_files};

const FOLDER: &str = "ROOTVOX_TEST_FOLDER";

fn study() -> Study {
    Study { side: 48, views: 4, ..Study::default() }
}

/// What the processes that the tests below start do; does nothing by itself.
#[test]
fn child() {
    let Some(folder) = std::env::var_os(FOLDER) else { return };
    let folder = Path::new(&folder);
    let store = Store::open(&folder.join("cache")).unwrap();
    let (graph, target) = study().graph(folder);
    run_logged(&store, &graph, target, 2).0.unwrap();
}

fn child_of(folder: &Path, program: &str, before: &[&str]) -> Command {
    let mut command = Command::new(program);
    command.args(before).args(["--exact", "kill::child", "--test-threads", "1"]);
    command.env(FOLDER, folder).stdout(Stdio::null()).stderr(Stdio::null());
    command
}

fn this_program() -> String {
    std::env::current_exe().unwrap().to_str().unwrap().to_owned()
}

/// Digests of all nodes after bringing the study up to date; nothing in the store is damaged or left over.
fn settle(folder: &Path) -> Vec<String> {
    let store = Store::open(&folder.join("cache")).unwrap();
    assert_eq!(count_files(&folder.join("cache/v1/tmp")), 0, "leftovers are swept");
    assert!(store.verify(false, &|_, _| Ok(())).unwrap().bad.is_empty());
    let (graph, target) = study().graph(folder);
    let report = run_logged(&store, &graph, target, 2).0.unwrap();
    let verdict = store.verify(false, &|_, _| Ok(())).unwrap();
    assert!(verdict.bad.is_empty() && verdict.nodes == 6);
    graph.nodes().map(|node| report.digest(node).unwrap().to_string()).collect()
}

#[test]
fn a_kill_at_any_instant_leaves_a_sound_store() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let undisturbed = settle(dir.path());
    let begun = std::time::Instant::now();
    std::fs::remove_dir_all(dir.path().join("cache")).unwrap();
    assert!(child_of(dir.path(), &this_program(), &[]).status().unwrap().success());
    let whole = begun.elapsed();
    let mut partly = 0;
    for n in 0..20 {
        std::fs::remove_dir_all(dir.path().join("cache")).unwrap();
        let mut child = child_of(dir.path(), &this_program(), &[]).spawn().unwrap();
        std::thread::sleep(whole.mul_f64(f64::from(n) / 20.0).max(Duration::from_millis(1)));
        child.kill().unwrap();
        child.wait().unwrap();
        let nodes = Store::open(&dir.path().join("cache")).unwrap().list().unwrap().len();
        partly += usize::from(nodes > 0 && nodes < 6);
        assert_eq!(settle(dir.path()), undisturbed);
    }
    println!("{partly} of 20 kills came between the first node and the last");
}

#[test]
fn two_processes_share_the_work() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    for _ in 0..3 {
        let mut children: Vec<_> =
            (0..2).map(|_| child_of(dir.path(), &this_program(), &[]).spawn().unwrap()).collect();
        assert!(children.iter_mut().all(|child| child.wait().unwrap().success()));
        let store = Store::open(&dir.path().join("cache")).unwrap();
        let runs: usize = ["spread", "sum", "count"].iter().map(|stage| store.history(stage).len()).sum();
        assert_eq!(runs, 6, "no node is computed twice");
        settle(dir.path());
        std::fs::remove_dir_all(dir.path().join("cache")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_write_that_fails_leaves_nothing_half() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let undisturbed = settle(dir.path());
    std::fs::remove_dir_all(dir.path().join("cache")).unwrap();
    // No file may exceed 8 blocks: writing a shard fails as on a full disk.
    let limit = ["-c", "trap '' XFSZ; ulimit -f 8; exec \"$0\" \"$@\"", &this_program()];
    assert!(!child_of(dir.path(), "sh", &limit).status().unwrap().success());
    assert!(Store::open(&dir.path().join("cache")).unwrap().list().unwrap().is_empty());
    assert_eq!(settle(dir.path()), undisturbed);
}
