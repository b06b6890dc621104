//! What runs again after a change, and what does not.

use rootvox::store::Store;

use crate::toy::{Study, ran, run_logged, write_files};

#[test]
fn nothing_changed_means_all_hits() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    let (first, log) = run_logged(&store, &graph, target, 2);
    assert_eq!(log, ["+count", "+spread/0", "+spread/1", "+spread/2", "+spread/3", "+sum"]);
    let (second, log) = run_logged(&store, &graph, target, 2);
    assert_eq!(log, ["=count", "=spread/0", "=spread/1", "=spread/2", "=spread/3", "=sum"]);
    let (first, second) = (first.unwrap(), second.unwrap());
    assert_eq!(first.digest(target), second.digest(target));
    let count: u64 = second.artefact(target).unwrap().json("count").unwrap();
    assert!(count > 0);
}

#[test]
fn a_parameter_changes_its_node_and_what_follows() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    run_logged(&store, &graph, target, 2).0.unwrap();
    let (graph, target) = Study { level: 50.0, ..Study::default() }.graph(dir.path());
    let (report, log) = run_logged(&store, &graph, target, 2);
    report.unwrap();
    assert_eq!(ran(&log), ["count"]);
}
