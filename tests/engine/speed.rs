//! Figures, not limits: `cargo test --release --test engine speed -- --ignored --nocapture`.

use std::time::Instant;

use ndarray::ArrayD;
use rootvox::Result;
use rootvox::flow::{Engine, Graph, Inputs, Progress, Stage};
use rootvox::store::{Output, Store};
use serde::Serialize;

use crate::toy::{Count, Spread, Sum, write_files};

/// A volume as large as one rendered view at 1 mm: 180 x 171 x 171 x 3 bytes.
#[derive(Serialize)]
struct View {
    n: usize,
}

impl Stage for View {
    const NAME: &'static str = "view";
    const VERSION: u32 = 1;

    fn run(&self, _: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        // Smooth with a little noise, as photographs are.
        let mut state = 1_u32;
        let values = ArrayD::from_shape_fn(vec![180, 171, 171, 3], |i| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (i[0] / 2 + i[1] / 3 + self.n) as u8 ^ (state >> 30) as u8
        });
        let begun = Instant::now();
        output.array("view", values.view(), &["z", "y", "x", "c"])?;
        println!("write {:.0} MB/s", values.len() as f64 / 1e6 / begun.elapsed().as_secs_f64());
        Ok(())
    }
}

#[test]
#[ignore = "prints figures"]
fn writing_and_reading() {
    let dir = tempfile::tempdir().unwrap();
    let store = Store::open(&dir.path().join("cache")).unwrap();
    let mut graph = Graph::new();
    let views: Vec<_> = (0..6).map(|n| graph.add(&format!("view/{n}"), View { n }, &[])).collect();
    let report = Engine::new(&store).threads(2).run(&graph, &views).unwrap();
    for (how, step) in [("whole", 180), ("slabs of 8", 8), ("slabs of 16", 16)] {
        let begun = Instant::now();
        let mut bytes = 0;
        for &view in &views {
            let reader = report.artefact(view).unwrap().array::<u8>("view").unwrap();
            for z in (0..180).step_by(step) {
                bytes += reader.slab(z..(z + step).min(180)).unwrap().len();
            }
        }
        println!("read {how}: {:.0} MB/s", bytes as f64 / 1e6 / begun.elapsed().as_secs_f64());
    }
    let usage = &store.usage().unwrap()["view"];
    println!("{:.2} of the size in memory", usage.bytes as f64 / (6.0 * 180.0 * 171.0 * 171.0 * 3.0));
}

#[test]
#[ignore = "prints figures"]
fn deciding_an_unchanged_graph() {
    let dir = tempfile::tempdir().unwrap();
    write_files(dir.path(), 66);
    let study = || {
        let mut graph = Graph::new();
        let mut all = Vec::new();
        for n in 0..66 {
            let file = graph.file(&format!("file/{n}"), dir.path().join(n.to_string()));
            let spread = graph.add(&format!("spread/{n}"), Spread { side: 4, gain: 1.0 }, &[("file", &[file])]);
            let sum = graph.add(&format!("sum/{n}"), Sum { step: 1.0 }, &[("volumes", &[spread])]);
            all.push(graph.add(&format!("count/{n}"), Count { level: n as f32 }, &[("total", &[sum])]));
        }
        (graph, all)
    };
    let home = dir.path().join("cache");
    let (graph, targets) = study();
    let begun = Instant::now();
    Engine::new(&Store::open(&home).unwrap()).run(&graph, &targets).unwrap();
    println!("198 nodes and 66 files cold: {:.0} ms", begun.elapsed().as_secs_f64() * 1e3);
    std::thread::sleep(std::time::Duration::from_millis(2100));
    for round in 0..5 {
        let begun = Instant::now();
        let store = Store::open(&home).unwrap();
        let (graph, targets) = study();
        let built = begun.elapsed();
        let report = Engine::new(&store).run(&graph, &targets).unwrap();
        assert!(targets.iter().all(|&t| !report.ran(t)));
        println!(
            "unchanged, round {round}: {:.2} ms (graph and store {:.2} ms)",
            begun.elapsed().as_secs_f64() * 1e3,
            built.as_secs_f64() * 1e3
        );
    }
    let store = Store::open(&home).unwrap();
    let (graph, targets) = study();
    let begun = Instant::now();
    let plan = Engine::new(&store).status(&graph, &targets).unwrap();
    assert_eq!(plan.pending().count(), 0);
    println!("status: {:.2} ms", begun.elapsed().as_secs_f64() * 1e3);
}
