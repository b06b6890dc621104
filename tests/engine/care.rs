//! Looking after a store: damage is found and mended, room is made without losing what can still be used.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use rootvox::flow::Engine;
use rootvox::store::Store;
use rootvox::store::care::Collect;
use tempfile::TempDir;

use crate::toy::{Study, ran, run_logged, write_files};

fn filled() -> (TempDir, Store) {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let (graph, target) = Study::default().graph(dir.path());
    run_logged(&store, &graph, target, 2).0.unwrap();
    (dir, store)
}

fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        match entry.path() {
            path if path.is_dir() => found.extend(files_below(&path)),
            path => found.push(path),
        }
    }
    found.sort();
    found
}

#[test]
fn any_flipped_byte_is_found_and_mended() {
    let (dir, store) = filled();
    let (graph, target) = Study::default().graph(dir.path());
    let digest = run_logged(&store, &graph, target, 1).0.unwrap().digest(target);
    let sum = graph.find("sum").unwrap();
    let folder = store.folder("sum", run_logged(&store, &graph, target, 1).0.unwrap().key(sum).unwrap());
    for path in files_below(&folder).into_iter().filter(|path| !path.ends_with("manifest.json")) {
        let sound = std::fs::read(&path).unwrap();
        if path.ends_with("zarr.json") {
            continue; // Spaces there mean nothing; the values are what counts.
        }
        for at in [0, sound.len() / 2, sound.len() - 1] {
            let mut bytes = sound.clone();
            bytes[at] ^= 1;
            std::fs::write(&path, bytes).unwrap();
            let verdict = store.verify(false, &|_, _| Ok(())).unwrap();
            assert_eq!(verdict.bad.len(), 1, "byte {at} of {}", path.display());
            assert_eq!(verdict.bad[0].folder, folder);
        }
        std::fs::write(&path, sound).unwrap();
    }
    let shard = files_below(&folder).into_iter().find(|path| path.ends_with("0/0/0")).unwrap();
    std::fs::remove_file(&shard).unwrap();
    let (graph, other) = Study { level: 3.0, ..Study::default() }.graph(dir.path());
    let error = run_logged(&store, &graph, other, 1).0.err().unwrap().to_string();
    assert!(error.contains("damaged") && error.contains("cache verify"), "{error}");
    let verdict = store.verify(true, &|_, _| Ok(())).unwrap();
    assert_eq!((verdict.bad.len(), verdict.removed), (1, 1));
    let (graph, target) = Study::default().graph(dir.path());
    let (report, log) = run_logged(&store, &graph, target, 2);
    assert_eq!((report.unwrap().digest(target), ran(&log)), (digest, vec!["sum"]));
}

#[test]
fn usage_counts_what_lies_there() {
    let (_dir, store) = filled();
    let usage = store.usage().unwrap();
    assert_eq!(
        usage.iter().map(|(stage, u)| (stage.as_str(), u.nodes)).collect::<Vec<_>>(),
        [("count", 1), ("spread", 4), ("sum", 1)]
    );
    let counted: u64 = usage.values().map(|u| u.bytes).sum();
    let found: u64 = files_below(&store.home().join("v1/nodes"))
        .iter()
        .filter(|path| !path.ends_with("manifest.json"))
        .map(|path| std::fs::metadata(path).unwrap().len())
        .sum();
    // The group pages of nodes with arrays are not counted.
    assert!(counted > 0 && found - counted < 5 * 100, "{counted} of {found}");
}

#[test]
fn values_make_room_but_what_follows_is_still_found() {
    let (dir, store) = filled();
    let rules = Collect { max_bytes: Some(0), dry_run: true, ..Collect::default() };
    let tried = store.collect(&rules).unwrap();
    let done = store.collect(&Collect { dry_run: false, ..rules }).unwrap();
    assert_eq!(tried, done);
    assert_eq!((done.nodes, done.emptied, done.kept_bytes), (0, 6, 0));
    let (graph, target) = Study::default().graph(dir.path());
    let sum = graph.find("sum").unwrap();
    // The count has lost its values: it and what it reads run again, as announced, and have the digests they had.
    let plan = Engine::new(&store).status(&graph, &[target]).unwrap();
    let announced = plan.pending().map(|(_, p)| p.label.clone()).collect::<BTreeSet<_>>();
    assert_eq!(announced.into_iter().collect::<Vec<_>>(), ran(&run_logged(&store, &graph, target, 2).1));
    store.collect(&Collect { max_bytes: Some(0), ..Collect::default() }).unwrap();
    let (report, log) = run_logged(&store, &graph, target, 2);
    let report = report.unwrap();
    assert_eq!(ran(&log), ["count", "spread/0", "spread/1", "spread/2", "spread/3", "sum"]);
    let spread = graph.find("spread/0").unwrap();
    assert!(report.digest(sum).is_some() && report.digest(spread).is_some());
    let pinned = BTreeSet::from([report.key(target).unwrap()]);
    drop(report);
    store.pin("study", &pinned).unwrap();
    let rules = Collect { max_bytes: Some(0), ..Collect::default() };
    store.collect(&rules).unwrap();
    assert!(ran(&run_logged(&store, &graph, target, 2).1).is_empty());
    assert!(store.verify(false, &|_, _| Ok(())).unwrap().bad.is_empty());
    assert_eq!(store.pins().unwrap().keys().collect::<Vec<_>>(), ["study"]);
    store.unpin("study").unwrap();
    assert_eq!(store.collect(&rules).unwrap().emptied, 1);
    assert!(store.unpin("study").is_err());
}

#[test]
fn old_and_unwanted_nodes_go_whole() {
    let (dir, store) = filled();
    let (graph, target) = Study::default().graph(dir.path());
    let report = run_logged(&store, &graph, target, 2).0.unwrap();
    let keep_only = Some(graph.nodes().filter_map(|node| report.key(node)).collect::<BTreeSet<_>>());
    drop(report);
    let (other, other_target) = Study { level: 9.0, ..Study::default() }.graph(dir.path());
    run_logged(&store, &other, other_target, 2).0.unwrap();
    let gone = store.collect(&Collect { keep_only, ..Collect::default() }).unwrap();
    assert_eq!((gone.nodes, gone.kept_nodes), (1, 6));
    let gone = store.collect(&Collect { max_age: Some(Duration::from_secs(3600)), ..Collect::default() }).unwrap();
    assert_eq!(gone.nodes, 0);
    for path in files_below(&store.home().join("v1/nodes")).iter().filter(|path| path.ends_with("manifest.json")) {
        let long_ago = std::time::SystemTime::now() - Duration::from_secs(90 * 24 * 3600);
        std::fs::File::open(path).unwrap().set_modified(long_ago).unwrap();
    }
    run_logged(&store, &graph, target, 2).0.unwrap(); // Being found makes them young again.
    let rules = Collect { max_age: Some(Duration::from_secs(3600)), ..Collect::default() };
    assert_eq!(store.collect(&rules).unwrap().nodes, 0);
}

#[test]
fn cleaning_waits_for_runs() {
    let (_dir, store) = filled();
    let using = store.use_it();
    let error = store.collect(&Collect::default()).err().unwrap().to_string();
    assert!(error.contains("a run is using the store"), "{error}");
    drop(using);
    store.collect(&Collect::default()).unwrap();
}

#[test]
fn cleaning_waits_until_a_report_is_read() {
    let (dir, store) = filled();
    let (graph, target) = Study::default().graph(dir.path());
    let report = run_logged(&store, &graph, target, 1).0.unwrap();
    let all = Collect { max_bytes: Some(0), ..Collect::default() };
    let other = Store::open(store.home()).unwrap();
    assert!(other.collect(&all).err().unwrap().to_string().contains("a run is using the store"));
    assert!(report.artefact(target).unwrap().json::<u64>("count").unwrap() > 0);
    drop(report);
    assert!(other.collect(&all).unwrap().emptied > 0);
}
