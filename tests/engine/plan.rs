//! What a run would do, and why.

use rootvox::flow::{Change, Engine, NodeState};
use rootvox::store::Store;

use crate::toy::{Study, run_logged, write_files};

fn states(store: &Store, study: &Study, folder: &std::path::Path) -> Vec<String> {
    let (graph, target) = study.graph(folder);
    let plan = Engine::new(store).status(&graph, &[target]).unwrap();
    let tell = |state: &NodeState| match state {
        NodeState::File { .. } => "file".to_owned(),
        NodeState::Unreadable { .. } => "unreadable".to_owned(),
        NodeState::Cached { .. } => "cached".to_owned(),
        NodeState::WouldRun { changes, .. } => format!("run: {}", join(changes)),
        NodeState::Unknown { changes } => format!("may run: {}", join(changes)),
    };
    plan.nodes().filter(|(_, p)| p.stage.is_some()).map(|(_, p)| format!("{} {}", p.label, tell(&p.state))).collect()
}

fn join(changes: &[Change]) -> String {
    changes.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ")
}

fn why(store: &Store, study: &Study, folder: &std::path::Path, label: &str) -> Vec<String> {
    let (graph, _) = study.graph(folder);
    let steps = Engine::new(store).why(&graph, graph.find(label).unwrap()).unwrap();
    steps.iter().map(|step| format!("{}: {}", step.label, join(&step.changes))).collect()
}

#[test]
fn status_names_what_changed_and_what_waits_for_it() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    write_files(folder, 2);
    let store = Store::open(&folder.join("cache")).unwrap();
    let base = || Study { views: 2, ..Study::default() };
    let fresh = states(&store, &base(), folder);
    assert_eq!(fresh[0], "spread/0 run: never computed before");
    assert_eq!(fresh[2], "sum may run: never computed before");
    let (graph, target) = base().graph(folder);
    run_logged(&store, &graph, target, 2).0.unwrap();
    assert_eq!(states(&store, &base(), folder), ["spread/0 cached", "spread/1 cached", "sum cached", "count cached"]);
    assert_eq!(
        states(&store, &Study { step: 0.25, level: 7.0, ..base() }, folder),
        [
            "spread/0 cached",
            "spread/1 cached",
            "sum run: `step`: 0.5 -> 0.25",
            "count may run: `level`: 100 -> 7, input `sum` has to be computed again"
        ]
    );
    std::fs::write(folder.join("1"), "other").unwrap();
    assert_eq!(
        states(&store, &base(), folder),
        [
            "spread/0 cached",
            "spread/1 run: input `file/1` has other values",
            "sum may run: input `spread/1` has to be computed again",
            "count may run: input `sum` has to be computed again"
        ]
    );
    std::fs::remove_file(folder.join("1")).unwrap();
    assert_eq!(states(&store, &base(), folder)[1], "spread/1 may run: input `file/1` has to be computed again");
    let (graph, target) = base().graph(folder);
    let plan = Engine::new(&store).status(&graph, &[target]).unwrap();
    let (_, pending) = plan.pending().next().unwrap();
    assert!(pending.seconds.is_some() && pending.bytes.is_some_and(|bytes| bytes > 0));
}

#[test]
fn why_begins_with_the_root_cause() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    write_files(folder, 3);
    let store = Store::open(&folder.join("cache")).unwrap();
    let run = |study: &Study| {
        let (graph, target) = study.graph(folder);
        run_logged(&store, &graph, target, 2).0.unwrap();
    };
    let base = || Study { views: 2, ..Study::default() };
    run(&base());
    let path = folder.join("1").display().to_string();
    std::fs::write(folder.join("1"), "quite other bytes").unwrap();
    let pending = why(&store, &base(), folder, "count");
    let root = format!("file/1: content of `{path}` changed");
    assert_eq!(
        pending,
        [
            root.as_str(),
            "spread/1: input `file/1` has other values",
            "sum: input `spread/1` has to be computed again",
            "count: input `sum` has to be computed again"
        ]
    );
    // It can still be asked when it has been done.
    run(&base());
    let done = why(&store, &base(), folder, "count");
    assert_eq!(
        done,
        [
            root.as_str(),
            "spread/1: input `file/1` has other values",
            "sum: input `spread/1` has other values",
            "count: input `sum` has other values"
        ]
    );
    run(&Study { gain: 3.0, ..base() });
    let gain = why(&store, &Study { gain: 3.0, ..base() }, folder, "spread/0");
    assert_eq!(gain, ["spread/0: `gain`: 1 -> 3"]);
    // What is still to run is held against the nearest of its own runs, not against the latest that anybody made.
    run(&Study { step: 9.0, ..base() });
    let step = why(&store, &Study { gain: 3.0, step: 0.75, ..base() }, folder, "count");
    assert_eq!(step, ["sum: `step`: 0.5 -> 0.75", "count: input `sum` has to be computed again"]);
    let more = why(&store, &Study { views: 3, ..base() }, folder, "sum");
    assert_eq!(more, ["sum: input `spread/2` added"]);
}
