//! `rootvox rerun`: a result made again from its lock, and held against it.

use super::options::{MachineOptions, StoreOptions, TraceOptions};
use super::watch::Watch;
use crate::error::{Error, Result};
use crate::flow::Engine;
use crate::study::lock::Lock;
use crate::study::rerun::{batch, compare};
use clap::Args;
use std::path::PathBuf;

/// Make a result again from its study.lock, and compare every node bit by bit.
///
/// The lock holds every parameter, so that neither the study file nor the defaults of this version matter. What the
/// store has is taken from there: name an empty folder with --cache to compute everything anew.
///
/// Example:
///   rootvox rerun results/plant-7/study.lock --cache fresh --photos-dir captures/plant-7
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Rerun {
    /// The study.lock of a results folder.
    lock: PathBuf,
    /// Folder of the capture, where it is not where the lock says.
    #[arg(long, value_name = "DIR")]
    photos_dir: Option<String>,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
    #[command(flatten)]
    trace: TraceOptions,
}

impl Rerun {
    /// Runs and compares.
    ///
    /// # Errors
    /// Where the lock or its inputs cannot be read, or a node differs.
    #[expect(clippy::print_stdout, reason = "the verdict is the data")]
    pub fn run(&self) -> Result<()> {
        let lock = Lock::read(&self.lock)?;
        let batch = batch(&lock, &self.lock, self.photos_dir.as_deref())?;
        let store = self.store.open()?;
        let (targets, threads) = (batch.targets(), self.machine.threads());
        let watch = Watch::new(&batch, &store, &targets, threads, self.trace.trace.clone())?;
        let outcome = Engine::new(&store)
            .threads(threads)
            .memory_bytes(self.machine.memory_bytes())
            .cancel(super::cancel::flag()?)
            .on_event(|event| watch.see(event))
            .attempt(&batch.graph, &targets);
        watch.finish()?;
        let (report, failures) = outcome?;
        let verdict = compare(&lock, &batch, &report, &failures)?;
        println!("{} of {} nodes bit-identical", verdict.identical, verdict.nodes);
        match verdict.first {
            None => Ok(()),
            Some((node, why)) => {
                println!("first to differ: {node}: {why}");
                Err(Error::failed(format!("the rerun differs from `{}` from `{node}` on", self.lock.display()))
                    .help("the line above says why; rootvox of another version is named in the lock"))
            }
        }
    }
}
