//! Several runs on one store: what each takes, and that streamed work too is done once.

use std::sync::Barrier;

use rootvox::flow::Graph;
use rootvox::store::Store;

use crate::toy::{Gather, Wave, run_logged, write_files};

#[test]
fn a_fan_in_of_streamed_nodes_is_claimed_before_their_digests_are_known() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 4);
    let study = || {
        let mut graph = Graph::new();
        let mut waves = Vec::new();
        for view in 0..4 {
            let file = graph.file(&format!("file/{view}"), dir.path().join(view.to_string()));
            waves.push(graph.add_virtual(&format!("wave/{view}"), Wave { side: 120, gain: 0.1 }, &[("file", &[file])]));
        }
        let gather = graph.add("gather", Gather { leave_out: 0 }, &[("volumes", &waves)]);
        (graph, gather)
    };
    for turn in 0..10 {
        let cache = dir.path().join(format!("cache-{turn}"));
        let start = Barrier::new(3);
        let one = || {
            let (store, (graph, gather)) = (Store::open(&cache).unwrap(), study());
            start.wait();
            let (report, log) = run_logged(&store, &graph, gather, 1);
            (report.unwrap().digest(gather).unwrap(), log)
        };
        let found: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..3).map(|_| scope.spawn(one)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).collect()
        });
        assert!(found.iter().all(|(digest, _)| *digest == found[0].0));
        assert_eq!(Store::open(&cache).unwrap().history("gather").len(), 1, "turn {turn}: {found:?}");
        assert_eq!(std::fs::read_dir(cache.join("v1/locks")).unwrap().count(), 0);
    }
}

#[test]
fn what_fails_is_on_record_until_it_succeeds() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let study = |leave_out| {
        let mut graph = Graph::new();
        let file = graph.file("file", dir.path().join("0"));
        let wave = graph.add("wave", Wave { side: 8, gain: 0.1 }, &[("file", &[file])]);
        let gather = graph.add("gather", Gather { leave_out }, &[("volumes", &[wave])]);
        (graph, gather)
    };
    write_files(dir.path(), 1);
    let (graph, gather) = study(9); // More rows than there are.
    assert!(run_logged(&store, &graph, gather, 1).0.is_err());
    let failures = store.failures();
    assert!(failures.len() == 1 && failures[0].1.label == "gather" && !failures[0].1.error.is_empty(), "{failures:?}");
    let (graph, gather) = study(0);
    let report = run_logged(&store, &graph, gather, 1).0.unwrap();
    assert_eq!(store.failures(), failures, "another work");
    // As if it had failed elsewhere before.
    let other = Store::open(&dir.path().join("other")).unwrap();
    other.record_failure(report.key(gather).unwrap(), "gather", "no memory", None);
    run_logged(&other, &graph, gather, 1).0.unwrap();
    assert!(other.failures().is_empty());
}
