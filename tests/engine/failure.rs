//! Failures: reported all at once with their place, and nothing half is left behind.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rootvox::error::Kind;
use rootvox::flow::{Engine, Event, Graph};
use rootvox::store::Store;

use crate::toy::{Count, Spread, Study, Sum, Whim, count_files, ran, run_logged, write_files};

#[test]
fn siblings_finish_dependants_are_skipped_and_all_errors_are_told() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 2);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let mut graph = Graph::new();
    let file = graph.file("file", dir.path().join("0"));
    let missing = graph.file("missing", dir.path().join("none"));
    let good = graph.add("good", Spread { side: 4, gain: 1.0 }, &[("file", &[file])]);
    let bad = graph.add("bad", Spread { side: 4, gain: 1.0 }, &[("file", &[missing])]);
    let told = graph.add("told", Whim { what: "fail" }, &[]);
    let panics = graph.add("panics", Whim { what: "panic" }, &[]);
    let open = graph.add("open", Whim { what: "unfinished" }, &[]);
    let sum = graph.add("sum", Sum { step: 1.0 }, &[("volumes", &[good, bad, told, panics, open])]);
    let (report, log) = run_logged(&store, &graph, sum, 2);
    let error = report.err().unwrap().to_string();
    for part in [
        "missing: cannot read",
        "told: as told (tell it otherwise)",
        "panics: the stage panicked: as told",
        "open: the stage left members unfinished: volume",
    ] {
        assert!(error.contains(part), "{part} in {error}");
    }
    assert_eq!(log, ["!missing", "!open", "!panics", "!told", "+good", "-bad", "-sum"]);
    let verdict = store.verify(false, &|_, _| Ok(())).unwrap();
    assert_eq!((verdict.nodes, verdict.bad.len()), (1, 0));

    // Nothing is poisoned: the same store goes on.
    let fine = graph.add("fine", Whim { what: "succeed" }, &[]);
    assert_eq!(run_logged(&store, &graph, fine, 1).1, ["+fine"]);
    assert_eq!(run_logged(&store, &graph, good, 1).1, ["=good"]);
    let home = store.home().to_owned();
    drop(store);
    assert_eq!(count_files(&home.join("v1/tmp")), 0);
    assert_eq!(count_files(&home.join("v1/locks")), 0);
}

#[test]
fn a_cancelled_run_keeps_what_is_finished() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    let flag = Arc::new(AtomicBool::new(false));
    let stop = flag.clone();
    let listener = move |event: &Event| {
        if matches!(event, Event::Finished { .. }) {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let report = Engine::new(&store).threads(1).cancel(flag).on_event(listener).run(&graph, &[target]);
    assert_eq!(report.err().unwrap().kind, Kind::Interrupted);
    let (report, log) = run_logged(&store, &graph, target, 2);
    report.unwrap();
    assert_eq!(ran(&log), ["count", "spread/1", "spread/2", "spread/3", "sum"]);
}

#[test]
fn a_place_that_cannot_hold_a_store_is_named_with_the_remedy() {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("file"), "").unwrap();
    let error = Store::open(&dir.path().join("file/cache")).err().unwrap().to_string();
    assert!(error.contains("cannot make a store in") && error.contains("--cache"), "{error}");
}

#[test]
fn a_store_that_cannot_be_written_is_still_read() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let home = dir.path().join("cache");
    let store = Store::open(&home).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    run_logged(&store, &graph, target, 2).0.unwrap();
    drop(store);
    // Works for the superuser too, who may write anywhere: where drafts belong there is a file.
    std::fs::remove_dir_all(home.join("v1/tmp")).unwrap();
    std::fs::write(home.join("v1/tmp"), "").unwrap();

    let store = Store::open(&home).unwrap();
    let (report, log) = run_logged(&store, &graph, target, 2);
    let count: u64 = report.unwrap().artefact(target).unwrap().json("count").unwrap();
    assert!(count > 0 && ran(&log).is_empty());
    let (graph, target) = Study { level: 1.0, ..Study::default() }.graph(dir.path());
    let error = run_logged(&store, &graph, target, 2).0.err().unwrap().to_string();
    assert!(error.contains("count: cannot write to the store") && error.contains("ROOTVOX_CACHE"), "{error}");
}

#[test]
fn wrong_types_and_names_are_explained() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 1);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let mut graph = Graph::new();
    let file = graph.file("photo/0", dir.path().join("0"));
    let count = graph.add("count", Count { level: 1.0 }, &[("total", &[file])]);
    let error = run_logged(&store, &graph, count, 1).0.err().unwrap().to_string();
    assert!(error.contains("has no array `total`, only bytes `file`"), "{error}");
    let count = graph.add("count", Count { level: 1.0 }, &[("totals", &[file])]);
    let error = run_logged(&store, &graph, count, 1).0.err().unwrap().to_string();
    assert!(error.contains("port `total` has 0 inputs where it needs one"), "{error}");
}

#[test]
fn a_node_too_large_for_the_budget_still_runs() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    Engine::new(&store).threads(2).memory_bytes(1).run(&graph, &[target]).unwrap();
}

#[test]
fn the_record_of_a_failure_goes_once_the_node_is_found() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    let report = run_logged(&store, &graph, target, 2).0.unwrap();
    // As where its record could not be read for a moment.
    store.record_failure(report.key(target).unwrap(), "count", "cannot read", None);
    assert_eq!(store.failures().len(), 1);
    assert!(ran(&run_logged(&store, &graph, target, 2).1).is_empty());
    assert!(store.failures().is_empty());
}
