//! Pins what every stage computes on a tiny input: numbers that change without a raised VERSION fail here.
//!
//! `tests/stage_digests.txt` holds a line per stage: its name, the key of its first node (which stands for
//! version, parameters and inputs) and the digest of what it gave. Where the key is the same and the digest is
//! not, the stage's numbers changed: raise its VERSION. Where the key is another (a raised VERSION, other
//! defaults, another input), `ROOTVOX_PIN=1 cargo test --release --test stage_digests` writes the file anew.

use rootvox::flow::{Engine, Graph};
use rootvox::store::Store;
use rootvox::study::batch::Batch;
use rootvox::study::trial::Trial;
use rootvox::study::{graph, settings::Settings};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

#[test]
fn numbers_change_only_with_the_version() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let store = Store::open(folder.path()).expect("the store opens");
    let corrected = format!("corrections.file={}", here.join("data/corrections.toml").display());
    let mut now = BTreeMap::new();
    // As it is first: of a stage that both have, the node of the first counts.
    for set in [vec![], vec![corrected]] {
        let settings = Settings::load(&here.join("data/tiny.toml"), &set).expect("the study is sound");
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings).expect("the graph is sound");
        let report = Engine::new(&store).run(&graph, &nodes.targets()).expect("the study runs");
        for node in graph.nodes() {
            if let (Some(stage), Some(key), Some(digest)) = (graph.stage(node), report.key(node), report.digest(node)) {
                now.entry(stage.to_owned()).or_insert((key.to_string(), digest.to_string()));
            }
        }
    }
    let days = Batch::load(&here.join("data/days.toml"), &[]).expect("the trial is sound");
    let targets: Vec<_> = days.trial.iter().flat_map(Trial::targets).collect();
    let report = Engine::new(&store).run(&days.graph, &targets).expect("the days run");
    for node in days.graph.nodes() {
        let stage =
            days.graph.stage(node).filter(|stage| ["print", "align", "follow", "recall", "recalled"].contains(stage));
        if let (Some(stage), Some(key), Some(digest)) = (stage, report.key(node), report.digest(node)) {
            now.entry(stage.to_owned()).or_insert((key.to_string(), digest.to_string()));
        }
    }
    let path = here.join("stage_digests.txt");
    let pinned: BTreeMap<String, (String, String)> = std::fs::read_to_string(&path)
        .unwrap_or_default()
        .lines()
        .filter_map(|l| {
            let mut words = l.split_whitespace().map(str::to_owned);
            Some((words.next()?, (words.next()?, words.next()?)))
        })
        .collect();

    let mut stale = Vec::new();
    for (stage, (key, digest)) in &now {
        match pinned.get(stage) {
            Some((k, d)) if k == key => {
                assert_eq!(d, digest, "the numbers of stage `{stage}` changed: raise its VERSION");
            }
            _ => stale.push(stage.as_str()),
        }
    }
    stale.extend(pinned.keys().filter(|s| !now.contains_key(*s)).map(String::as_str));
    if std::env::var_os("ROOTVOX_PIN").is_some() {
        let text = now.iter().fold(String::new(), |mut text, (stage, (key, digest))| {
            let _ = writeln!(text, "{stage} {key} {digest}");
            text
        });
        std::fs::write(&path, text).expect("can write");
        return;
    }
    assert!(stale.is_empty(), "not pinned with these versions, parameters and inputs: {stale:?}; see this file's top");
}
