//! `rootvox rerun`: a result made again from its lock, and held against it.

use super::options::{MachineOptions, StoreOptions, TraceOptions};
use super::terminal::dataln;
use super::watch::Watch;
use crate::error::{Error, Result};
use crate::flow::Engine;
use crate::store::Store;
use crate::study::folder::LOCK;
use crate::study::lock::Lock;
use crate::study::pack::{NODES, RESULTS};
use crate::study::rerun::{batch, compare};
use crate::study::unpack::unpack;
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Make a result again from its study.lock, and compare every node bit by bit.
///
/// The lock holds every parameter, so that neither the study file nor the defaults of this version matter. What the
/// store has is taken from there: name an empty folder with --cache to compute everything anew.
///
/// Of a file that `rootvox pack` wrote, every lock in it is repeated; nodes that it holds are taken from it.
///
/// Examples:
///   rootvox rerun results/plant-7/study.lock --cache fresh --photos-dir captures/plant-7
///   rootvox rerun plant-7.rootvox.zip --cache fresh
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Rerun {
    /// The study.lock of a results folder, or a file that `rootvox pack` wrote.
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
    pub fn run(&self) -> Result<()> {
        let cancel = super::cancel::flag()?;
        if self.lock.extension().is_none_or(|extension| extension != "zip") {
            return self.repeat(&self.lock, self.store.open()?, cancel);
        }
        let folder = tempfile::tempdir().map_err(|e| Error::io("write", &std::env::temp_dir(), e))?;
        unpack(&self.lock, folder.path())?;
        let results = folder.path().join(RESULTS);
        let mut locks: Vec<PathBuf> = std::fs::read_dir(&results)
            .map_err(|e| Error::io("list", &results, e))?
            .flatten()
            .map(|entry| entry.path().join(LOCK))
            .filter(|path| path.is_file())
            .collect();
        locks.sort();
        let nodes = folder.path().join(NODES);
        for lock in locks {
            let store = if nodes.is_dir() && self.store.cache_upstream.is_none() {
                Store::open(&self.store.cache)?.over(&nodes.to_string_lossy())?
            } else {
                self.store.open()?
            };
            self.repeat(&lock, store, cancel.clone())?;
        }
        Ok(())
    }

    /// Runs the study of the lock at `path` and compares.
    fn repeat(&self, path: &Path, store: Store, cancel: Arc<AtomicBool>) -> Result<()> {
        let lock = Lock::read(path)?;
        let batch = batch(&lock, path, self.photos_dir.as_deref())?;
        let (targets, threads) = (batch.targets(), self.machine.threads());
        let watch = Watch::new(&batch, &store, &targets, threads, self.trace.trace.clone())?;
        let outcome = Engine::new(&store)
            .threads(threads)
            .memory_bytes(self.machine.memory_bytes())
            .cancel(cancel)
            .on_event(|event| watch.see(event))
            .attempt(&batch.graph, &targets);
        watch.finish()?;
        let (report, failures) = outcome?;
        let verdict = compare(&lock, &batch, &report, &failures)?;
        dataln!("{} of {} nodes bit-identical", verdict.identical, verdict.nodes);
        match verdict.first {
            None => Ok(()),
            Some((node, why)) => {
                dataln!("first to differ: {node}: {why}");
                Err(Error::failed(format!("the rerun differs from `{}` from `{node}` on", path.display()))
                    .help("the line above says why; rootvox of another version is named in the lock"))
            }
        }
    }
}
