//! What runs again after a change, and what does not.

use std::path::Path;

use rootvox::store::Store;
use tempfile::TempDir;

use crate::toy::{Study, ran, run_logged, write_files};

/// A folder with files, and a store that holds the default study.
fn filled() -> (TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 5);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let log = run(&store, dir.path(), &Study::default());
    assert_eq!(log, ["+count", "+spread/0", "+spread/1", "+spread/2", "+spread/3", "+sum"]);
    (dir, store)
}

fn run(store: &Store, folder: &Path, study: &Study) -> Vec<String> {
    let (graph, target) = study.graph(folder);
    let (report, log) = run_logged(store, &graph, target, 2);
    report.unwrap();
    log
}

#[test]
fn nothing_changed_means_all_hits() {
    let (dir, store) = filled();
    let log = run(&store, dir.path(), &Study::default());
    assert_eq!(log, ["=count", "=spread/0", "=spread/1", "=spread/2", "=spread/3", "=sum"]);
}

#[test]
fn a_parameter_changes_its_node_and_what_follows() {
    let (dir, store) = filled();
    assert_eq!(ran(&run(&store, dir.path(), &Study { level: 50.0, ..Study::default() })), ["count"]);
    assert_eq!(ran(&run(&store, dir.path(), &Study { step: 0.25, level: 50.0, ..Study::default() })), ["sum"]);
    let all = ["count", "spread/0", "spread/1", "spread/2", "spread/3", "sum"];
    assert_eq!(ran(&run(&store, dir.path(), &Study { gain: 0.7, ..Study::default() })), all);
}

#[test]
fn a_file_touched_but_equal_changes_nothing() {
    let (dir, store) = filled();
    let path = dir.path().join("2");
    let bytes = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    std::fs::write(&path, bytes).unwrap();
    let store = Store::open(store.home()).unwrap();
    assert!(ran(&run(&store, dir.path(), &Study::default())).is_empty());
}

#[test]
fn other_content_runs_its_view_and_what_follows() {
    let (dir, store) = filled();
    std::fs::write(dir.path().join("2"), "zzz quite other content").unwrap();
    assert_eq!(ran(&run(&store, dir.path(), &Study::default())), ["count", "spread/2", "sum"]);
    write_files(dir.path(), 5);
    assert!(ran(&run(&store, dir.path(), &Study::default())).is_empty());
}

#[test]
fn content_of_the_same_length_and_time_is_noticed() {
    let (dir, store) = filled();
    let path = dir.path().join("1");
    let before = std::fs::metadata(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[0] ^= 0x40;
    std::fs::write(&path, bytes).unwrap();
    std::fs::File::options().write(true).open(&path).unwrap().set_modified(before.modified().unwrap()).unwrap();
    assert!(ran(&run(&store, dir.path(), &Study::default())).contains(&"spread/1"));
}

#[test]
fn a_view_more_runs_that_view_and_what_follows() {
    let (dir, store) = filled();
    let log = run(&store, dir.path(), &Study { views: 5, ..Study::default() });
    assert_eq!(ran(&log), ["count", "spread/4", "sum"]);
    let log = run(&store, dir.path(), &Study { views: 4, ..Study::default() });
    assert!(ran(&log).is_empty());
}

#[test]
fn an_equal_output_cuts_off_what_follows() {
    let (dir, store) = filled();
    // The sum is rounded to steps of 0.5: bytes are whole numbers, so a finer step gives the same values.
    let log = run(&store, dir.path(), &Study { step: 0.125, ..Study::default() });
    assert_eq!(log, ["+sum", "=count", "=spread/0", "=spread/1", "=spread/2", "=spread/3"]);
}

#[test]
fn a_store_and_its_files_can_be_moved() {
    let (dir, store) = filled();
    drop(store);
    let moved = tempfile::tempdir().unwrap();
    std::fs::rename(dir.path().join("cache"), moved.path().join("elsewhere")).unwrap();
    write_files(moved.path(), 4);
    let store = Store::open(&moved.path().join("elsewhere")).unwrap();
    assert!(ran(&run(&store, moved.path(), &Study::default())).is_empty());
}

#[test]
fn one_thread_and_two_give_equal_digests() {
    let (dir, store) = filled();
    let other = Store::open(&dir.path().join("other")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    let two = run_logged(&store, &graph, target, 2).0.unwrap();
    let one = run_logged(&other, &graph, target, 1).0.unwrap();
    for node in graph.nodes() {
        assert!(one.digest(node).is_some());
        assert_eq!(one.digest(node), two.digest(node), "{}", graph.label(node));
        assert_eq!(one.key(node), two.key(node), "{}", graph.label(node));
    }
}

#[test]
fn equal_work_runs_once() {
    let (dir, store) = filled();
    std::fs::write(dir.path().join("0"), "twins").unwrap();
    std::fs::write(dir.path().join("1"), "twins").unwrap();
    let log = run(&store, dir.path(), &Study::default());
    assert_eq!(log.iter().filter(|entry| entry.starts_with("+spread")).count(), 1, "{log:?}");
}

#[test]
fn the_same_work_is_one_node_of_the_graph() {
    let dir = tempfile::tempdir().unwrap();
    let mut graph = rootvox::flow::Graph::new();
    let file = graph.file("a", dir.path().join("0"));
    let spread = |gain| crate::toy::Spread { side: 4, gain };
    let one = graph.add("one", spread(1.0), &[("file", &[file])]);
    assert_eq!(graph.add("two", spread(1.0), &[("file", &[file])]), one);
    assert_ne!(graph.add("three", spread(2.0), &[("file", &[file])]), one);
}
