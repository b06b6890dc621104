//! Stages small enough to see through, and a log of what a run did.

use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;

use ndarray::{Array3, ArrayD, Axis};
use rootvox::flow::{Engine, Event, Graph, Inputs, NodeId, Progress, Report, Stage, Streamed, store_streamed};
use rootvox::store::{ArraySpec, Artefact, Output, Slab, SlabSource, Store};
use rootvox::{Error, Result};
use serde::Serialize;

/// Spreads the bytes of a file over a small volume.
#[derive(Serialize)]
pub struct Spread {
    pub side: usize,
    pub gain: f32,
}

impl Stage for Spread {
    const NAME: &'static str = "spread";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let bytes = inputs.one("file")?.bytes("file")?;
        let n = self.side;
        progress.total(n as u64);
        let mut writer = output.slabs::<f32>("volume", &[n, n, n], &["z", "y", "x"])?;
        for z in 0..n {
            progress.check()?;
            let slab = Array3::from_shape_fn((1, n, n), |(_, y, x)| {
                f32::from(bytes[(z * 7 + y * 3 + x) % bytes.len()]) * self.gain
            });
            writer.push(slab.into_dyn().view())?;
            progress.advance(1);
        }
        writer.finish()
    }
}

/// Adds volumes up and rounds to a step, so that small changes vanish.
#[derive(Serialize)]
pub struct Sum {
    pub step: f32,
}

impl Stage for Sum {
    const NAME: &'static str = "sum";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let mut total: Option<ArrayD<f32>> = None;
        for volume in inputs.many("volumes") {
            let volume = volume.array::<f32>("volume")?.read()?;
            total = Some(match total {
                None => volume,
                Some(total) => total + volume,
            });
        }
        let total = total.unwrap_or_else(|| ArrayD::zeros(vec![0, 0, 0])).mapv(|v| (v / self.step).round() * self.step);
        output.array("total", total.view(), &["z", "y", "x"])
    }
}

/// Counts the cells above a level.
#[derive(Serialize)]
pub struct Count {
    pub level: f32,
}

impl Stage for Count {
    const NAME: &'static str = "count";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let reader = inputs.one("total")?.array::<f32>("total")?;
        let mut count = 0_u64;
        for z in 0..reader.shape()[0] {
            let slab = reader.slab(z..z + 1)?;
            count += slab.index_axis(Axis(0), 0).iter().filter(|&&v| v > self.level).count() as u64;
        }
        output.json("count", &count)?;
        output.bytes("count.txt", count.to_string().as_bytes())
    }
}

/// Spreads the bytes of a file over a volume that need not be stored.
#[derive(Serialize)]
pub struct Wave {
    pub side: usize,
    pub gain: f32,
}

struct WaveSource {
    bytes: Vec<u8>,
    side: usize,
    gain: f32,
}

impl SlabSource for WaveSource {
    fn arrays(&self) -> Vec<ArraySpec> {
        vec![ArraySpec::new::<f32>("volume", &[self.side; 3], &["z", "y", "x"])]
    }

    fn slab(&self, _: &str, rows: Range<usize>) -> Result<Slab> {
        let n = self.side;
        let slab = Array3::from_shape_fn((rows.len(), n, n), |(z, y, x)| {
            f32::from(self.bytes[((rows.start + z) * 5 + y * 3 + x) % self.bytes.len()]) * self.gain
        });
        Ok(Slab::from(slab.into_dyn()))
    }
}

impl Stage for Wave {
    const NAME: &'static str = "wave";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        store_streamed(self, inputs, output, progress)
    }
}

impl Streamed for Wave {
    fn open(&self, inputs: &Inputs) -> Result<Box<dyn SlabSource>> {
        let bytes = inputs.one("file")?.bytes("file")?;
        Ok(Box::new(WaveSource { bytes, side: self.side, gain: self.gain }))
    }
}

/// Doubles a volume slab by slab; streams what it reads.
#[derive(Serialize)]
pub struct Double;

struct DoubleSource(Artefact);

impl SlabSource for DoubleSource {
    fn arrays(&self) -> Vec<ArraySpec> {
        let shape = &self.0.members()[0].shape;
        vec![ArraySpec::new::<f32>("volume", shape, &["z", "y", "x"])]
    }

    fn slab(&self, _: &str, rows: Range<usize>) -> Result<Slab> {
        Ok(Slab::from(self.0.array::<f32>("volume")?.slab(rows)? * 2.0))
    }
}

impl Stage for Double {
    const NAME: &'static str = "double";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        store_streamed(self, inputs, output, progress)
    }
}

impl Streamed for Double {
    fn open(&self, inputs: &Inputs) -> Result<Box<dyn SlabSource>> {
        Ok(Box::new(DoubleSource(inputs.one("volume")?.clone())))
    }
}

/// Adds volumes up by slabs with a halo of one row, leaving out the last rows, or panics.
#[derive(Serialize)]
pub struct Gather {
    pub leave_out: usize,
}

impl Stage for Gather {
    const NAME: &'static str = "gather";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let mut total = 0.0_f64;
        for volume in inputs.many("volumes") {
            let reader = volume.array::<f32>("volume")?;
            let rows = reader.shape()[0] - self.leave_out;
            for z in 0..rows {
                let slab = reader.slab(z.saturating_sub(1)..(z + 2).min(rows))?;
                total += slab.iter().map(|&v| f64::from(v)).sum::<f64>();
            }
        }
        output.json("total", &total)
    }
}

/// Fails, panics or succeeds as it is told.
#[derive(Serialize)]
pub struct Whim {
    pub what: &'static str,
}

impl Stage for Whim {
    const NAME: &'static str = "whim";
    const VERSION: u32 = 1;

    fn run(&self, _: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        output.bytes("half.bin", &[1, 2, 3])?;
        let writer = output.slabs::<u8>("volume", &[2, 2], &["y", "x"])?;
        match self.what {
            "fail" => Err(Error::failed("as told").help("tell it otherwise")),
            "panic" => panic!("as told"),
            "unfinished" => Ok(()),
            _ => {
                let mut writer = writer;
                writer.push(ndarray::Array2::<u8>::ones((2, 2)).into_dyn().view())?;
                writer.finish()
            }
        }
    }
}

/// A study of toy stages over files `0..views` in a folder.
pub struct Study {
    pub gain: f32,
    pub step: f32,
    pub level: f32,
    pub views: usize,
    pub side: usize,
}

impl Default for Study {
    fn default() -> Self {
        Self { gain: 1.0, step: 0.5, level: 100.0, views: 4, side: 20 }
    }
}

impl Study {
    pub fn graph(&self, folder: &Path) -> (Graph, NodeId) {
        let mut graph = Graph::new();
        let mut volumes = Vec::new();
        for view in 0..self.views {
            let file = graph.file(&format!("file/{view}"), folder.join(view.to_string()));
            volumes.push(graph.add(
                &format!("spread/{view}"),
                Spread { side: self.side, gain: self.gain },
                &[("file", &[file])],
            ));
        }
        let total = graph.add("sum", Sum { step: self.step }, &[("volumes", &volumes)]);
        let count = graph.add("count", Count { level: self.level }, &[("total", &[total])]);
        (graph, count)
    }
}

/// Input files that differ from each other.
pub fn write_files(folder: &Path, count: usize) {
    for n in 0..count {
        std::fs::write(folder.join(n.to_string()), format!("the bytes of file {n}, repeated and repeated")).unwrap();
    }
}

/// Runs and tells, sorted, which nodes ran (`+label`), were found (`=label`), failed (`!label`), were skipped (`-label`).
pub fn run_logged(store: &Store, graph: &Graph, target: NodeId, threads: usize) -> (Result<Report>, Vec<String>) {
    let log = Mutex::new(Vec::new());
    let note = |event: &Event| {
        let entry = match event {
            Event::Hit { node, .. } => format!("={}", graph.label(*node)),
            Event::Finished { node, .. } => format!("+{}", graph.label(*node)),
            Event::Failed { node, .. } => format!("!{}", graph.label(*node)),
            Event::Skipped { node } => format!("-{}", graph.label(*node)),
            _ => return,
        };
        log.lock().unwrap().push(entry);
    };
    let report = Engine::new(store).threads(threads).on_event(note).run(graph, &[target]);
    let mut log = log.into_inner().unwrap();
    log.sort();
    (report, log)
}

/// All files below `folder`, and their number.
pub fn count_files(folder: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(folder) else { return 0 };
    entries.flatten().map(|e| if e.path().is_dir() { count_files(&e.path()) } else { 1 }).sum()
}

/// The labels in `log` that ran.
pub fn ran(log: &[String]) -> Vec<&str> {
    log.iter().filter_map(|entry| entry.strip_prefix('+')).collect()
}
