//! The study of the paper's figure 6 on a tiny capture: its points share what they have in common, by the engine's events;
//! and what enters which key.

use rootvox::flow::{Engine, Event};
use rootvox::store::{Key, Store};
use rootvox::study::batch::Batch;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Mutex;

fn pipeline(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines").join(name)
}

fn load(name: &str, overrides: &[&str]) -> Batch {
    let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
    Batch::load(&pipeline(name), &overrides).expect("a study")
}

#[test]
fn its_points_run_as_many_nodes_as_are_distinct() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let store = Store::open(&folder.path().join("cache")).expect("a store");
    let small = ["views=4", "width=160", "height=120", "supersampling=1"].map(|set| format!("simulate.capture.{set}"));
    let mut overrides: Vec<&str> = small.iter().map(String::as_str).collect();
    overrides.extend(["grid.spacing=4", "rootness.sigma=[2.0]"]);
    let batch = load("figure6.toml", &overrides);
    assert_eq!(batch.studies[0].points.len(), 16);
    let finished = Mutex::new(Vec::new());
    let hits = Mutex::new(0);
    let listen = |event: &Event| match event {
        Event::Finished { node, .. } => finished.lock().expect("a lock").push(*node),
        Event::Hit { .. } => *hits.lock().expect("a lock") += 1,
        _ => {}
    };
    let targets = batch.targets();
    let report = Engine::new(&store).threads(2).on_event(listen).run(&batch.graph, &targets).expect("runs");
    let finished = finished.into_inner().expect("a lock");

    let keys: BTreeSet<Key> = finished.iter().filter_map(|node| report.key(*node)).collect();
    assert_eq!(keys.len(), finished.len(), "a node ran twice");
    // Thresholds that give the same roots are scored once: the next score has that key and is found.
    let reached = batch.graph.nodes().zip(batch.graph.upstream(&targets)).filter(|(_, reached)| *reached);
    let wanted = reached.filter(|(node, _)| batch.graph.stage(*node).is_some()).count();
    assert_eq!(finished.len() + *hits.lock().expect("a lock"), wanted);
    let mut ran: BTreeMap<&str, usize> = BTreeMap::new();
    for node in &finished {
        *ran.entry(batch.graph.stage(*node).expect("a stage")).or_default() += 1;
    }
    // Distinct by construction: 2 ways to render, times 2 pairs of exponents, times 4 pairs of thresholds.
    let expected = [("photograph", 4), ("undistort", 4), ("render", 8), ("merge", 2), ("rootness", 4), ("suppress", 4)];
    for (stage, count) in expected.into_iter().chain([("extract", 16), ("capture", 1)]) {
        assert_eq!(ran.get(stage), Some(&count), "{stage} of {ran:?}");
    }
    // Distinct by count: what the points need, each on its own.
    let of_points = batch.studies[0].points.iter().flat_map(|point| {
        let reached = batch.graph.upstream(&batch.studies[0].targets_of(point));
        batch
            .graph
            .nodes()
            .zip(reached)
            .filter(|(_, reached)| *reached)
            .filter_map(|(node, _)| report.key(node))
            .collect::<Vec<_>>()
    });
    assert_eq!(of_points.collect::<BTreeSet<Key>>(), keys);
}

/// Stages whose parameters differ between two settings of one study.
fn touched(set: &str) -> BTreeSet<&'static str> {
    let (before, now) = (load("quickstart.toml", &[]), load("quickstart.toml", &[set]));
    let stages = now.graph.nodes().filter_map(|node| {
        let stage = now.graph.stage(node)?;
        let old = before.graph.find(now.graph.label(node)).expect("the same nodes");
        let same = before.graph.params(old).expect("parameters") == now.graph.params(node).expect("parameters");
        (!same).then_some(stage)
    });
    stages.collect()
}

#[test]
fn a_parameter_enters_the_keys_of_the_stages_that_read_it_alone() {
    for (set, stages) in [
        ("render.sampling=point", &["render"][..]),
        ("contrast.window_mm=3.0", &["background", "evidence"]),
        ("contrast.blur_mm=0.3", &["evidence", "explain"]),
        ("merge.tolerance=0.01", &["merge"]),
        ("rootness.gamma23=1.0", &["rootness"]),
        ("extract.high=1.5", &["extract"]),
        ("extract.low=0.5", &["extract"]),
        ("overlay.mark_radius=2.0", &["overlay", "root-overlay"]),
    ] {
        assert_eq!(touched(set), BTreeSet::from_iter(stages.iter().copied()), "{set}");
    }
}
