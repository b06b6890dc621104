//! Virtual nodes: nothing stored, same keys, same digests.

use rootvox::flow::{Graph, NodeId};
use rootvox::store::Store;

use crate::toy::{Double, Gather, Wave, ran, run_logged, write_files};

struct Nodes {
    graph: Graph,
    waves: Vec<NodeId>,
    doubles: Vec<NodeId>,
    gather: NodeId,
}

fn study(folder: &std::path::Path, is_virtual: bool, leave_out: usize) -> Nodes {
    let mut graph = Graph::new();
    let (mut waves, mut doubles) = (Vec::new(), Vec::new());
    for view in 0..3 {
        let file = graph.file(&format!("file/{view}"), folder.join(view.to_string()));
        let wave = Wave { side: 24, gain: 0.1 };
        let (label, double) = (format!("wave/{view}"), format!("double/{view}"));
        if is_virtual {
            waves.push(graph.add_virtual(&label, wave, &[("file", &[file])]));
            doubles.push(graph.add_virtual(&double, Double, &[("volume", &waves[view..])]));
        } else {
            waves.push(graph.add(&label, wave, &[("file", &[file])]));
            doubles.push(graph.add(&double, Double, &[("volume", &waves[view..])]));
        }
    }
    let gather = graph.add("gather", Gather { leave_out }, &[("volumes", &doubles)]);
    Nodes { graph, waves, doubles, gather }
}

#[test]
fn keys_and_digests_are_those_of_the_stored_values() {
    for leave_out in [0, 5] {
        let dir = tempfile::tempdir().unwrap();
        write_files(dir.path(), 3);
        let (kept, streamed) = (study(dir.path(), false, leave_out), study(dir.path(), true, leave_out));
        let kept_store = Store::open(&dir.path().join("kept")).unwrap();
        let store = Store::open(&dir.path().join("streamed")).unwrap();
        let one = run_logged(&kept_store, &kept.graph, kept.gather, 2).0.unwrap();
        let (two, log) = run_logged(&store, &streamed.graph, streamed.gather, 2);
        let two = two.unwrap();
        assert_eq!(log, ["+gather"]);
        for (a, b) in [(&kept.waves, &streamed.waves), (&kept.doubles, &streamed.doubles)] {
            for (a, b) in a.iter().zip(b) {
                assert_eq!((one.key(*a), one.digest(*a)), (two.key(*b), two.digest(*b)));
                assert!(one.digest(*a).is_some());
            }
        }
        assert_eq!(one.key(kept.gather), two.key(streamed.gather));
        assert_eq!(one.digest(kept.gather), two.digest(streamed.gather));
        assert_eq!(store.usage().unwrap()["wave"].bytes, 0);
        assert!(kept_store.usage().unwrap()["wave"].bytes > 0);
        assert!(store.verify(false, &|_, _| Ok(())).unwrap().bad.is_empty());

        // Known digests decide the consumer without streaming.
        let (_, log) = run_logged(&store, &streamed.graph, streamed.gather, 2);
        assert!(ran(&log).is_empty() && log.contains(&"=gather".to_owned()), "{log:?}");
    }
}

#[test]
fn a_consumer_that_changed_streams_again_and_hits_under_its_known_key() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 3);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let nodes = study(dir.path(), true, 0);
    run_logged(&store, &nodes.graph, nodes.gather, 2).0.unwrap();
    let nodes = study(dir.path(), true, 1);
    assert_eq!(ran(&run_logged(&store, &nodes.graph, nodes.gather, 2).1), ["gather"]);
    // One file changed: its stream has unknown digests, the others are known.
    std::fs::write(dir.path().join("1"), "other bytes").unwrap();
    let (report, log) = run_logged(&store, &nodes.graph, nodes.gather, 2);
    assert_eq!(ran(&log), ["gather"]);
    let fresh = Store::open(&dir.path().join("fresh")).unwrap();
    let other = run_logged(&fresh, &nodes.graph, nodes.gather, 1).0.unwrap();
    assert_eq!(report.unwrap().digest(nodes.gather), other.digest(nodes.gather));
}

#[test]
fn a_virtual_node_that_is_asked_for_is_stored() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 3);
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let nodes = study(dir.path(), true, 0);
    let before = run_logged(&store, &nodes.graph, nodes.gather, 2).0.unwrap().digest(nodes.doubles[0]);
    let (report, log) = run_logged(&store, &nodes.graph, nodes.doubles[0], 2);
    let report = report.unwrap();
    assert_eq!(ran(&log), ["double/0"]);
    assert_eq!(report.digest(nodes.doubles[0]), before);
    let volume = report.artefact(nodes.doubles[0]).unwrap().array::<f32>("volume").unwrap().read().unwrap();
    assert_eq!(volume.shape(), [24, 24, 24]);
    assert!(run_logged(&store, &nodes.graph, nodes.doubles[0], 2).1.contains(&"=double/0".to_owned()));
}
