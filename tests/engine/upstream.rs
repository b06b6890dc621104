//! A store over another one: what the other holds is taken, and it is never written to.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::SystemTime;

use rootvox::store::Store;
use rootvox::store::care::Collect;

use crate::toy::{Study, ran, run_logged, write_files};

/// Every file and folder with its size and time of change.
fn snapshot(folder: &Path) -> BTreeMap<String, (u64, SystemTime)> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let meta = entry.metadata().unwrap();
        found.insert(entry.path().display().to_string(), (meta.len(), meta.modified().unwrap()));
        if meta.is_dir() {
            found.extend(snapshot(&entry.path()));
        }
    }
    found
}

#[test]
fn what_the_lab_has_is_not_computed_and_the_lab_stays_as_it_was() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let lab = dir.path().join("lab");
    let (graph, target) = Study::default().graph(dir.path());
    let of_lab = run_logged(&Store::open(&lab).unwrap(), &graph, target, 2).0.unwrap();
    let before = snapshot(&lab);

    let own = Store::open(&dir.path().join("own")).unwrap().over(lab.to_str().unwrap()).unwrap();
    let (report, log) = run_logged(&own, &graph, target, 2);
    assert!(ran(&log).is_empty(), "{log:?}");
    let count: u64 = report.unwrap().artefact(target).unwrap().json("count").unwrap();
    assert_eq!(count, of_lab.artefact(target).unwrap().json::<u64>("count").unwrap());

    // A change runs on the lab's values and is kept at home.
    let (other, other_target) = Study { level: 3.0, ..Study::default() }.graph(dir.path());
    assert_eq!(ran(&run_logged(&own, &other, other_target, 2).1), ["count"]);
    assert!(ran(&run_logged(&own, &other, other_target, 2).1).is_empty());
    assert_eq!(own.list().unwrap().len(), 1);
    assert_eq!(snapshot(&lab), before, "the lab's store was written to");

    // Home may lose its values: the lab's stand in.
    own.collect(&Collect { max_bytes: Some(0), ..Collect::default() }).unwrap();
    assert!(ran(&run_logged(&own, &graph, target, 2).1).is_empty());
    assert!(own.over(dir.path().join("nowhere").to_str().unwrap()).is_err());
}
