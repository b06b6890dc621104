//! `rootvox cache`: what the store holds, whether it is sound, and how to make it smaller.

use super::options::{StoreOptions, bytes, human_bytes};
use crate::error::{Error, Result};
use crate::store::Store;
use crate::store::care::Collect;
use clap::{Args, Subcommand};
use std::time::Duration;

/// Look after the store of finished nodes.
#[derive(Args)]
pub struct Cache {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    /// List the nodes: stage, label, size, seconds it took, key.
    Ls {
        #[command(flatten)]
        store: StoreOptions,
        /// Only nodes of this stage.
        #[arg(long)]
        stage: Option<String>,
    },
    /// Sizes by stage.
    Du {
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Read every array again and compare all digests.
    Verify {
        #[command(flatten)]
        store: StoreOptions,
        /// Remove what is damaged, so that it is computed again when asked for.
        #[arg(long)]
        repair: bool,
    },
    /// Make the store smaller. Whatever goes is computed again when asked for.
    Gc {
        #[command(flatten)]
        store: StoreOptions,
        /// Keep at most this much, least recently used first out: 20GiB.
        #[arg(long, value_name = "SIZE", value_parser = bytes)]
        keep: Option<u64>,
        /// Remove what was not used for so many days.
        #[arg(long, value_name = "DAYS")]
        older_than: Option<f64>,
        /// Say what would go and remove nothing.
        #[arg(long)]
        dry_run: bool,
    },
}

impl Cache {
    /// Does what the action says.
    ///
    /// # Errors
    /// Where the store cannot be read or written, or holds damaged nodes.
    #[expect(clippy::print_stdout, reason = "the figures are the data")]
    pub fn run(&self) -> Result<()> {
        match &self.action {
            Action::Ls { store, stage } => {
                for listed in open(store)?.list()? {
                    let m = &listed.manifest;
                    if stage.as_ref().is_none_or(|s| *s == m.stage) {
                        let size = if m.is_virtual { "no values".into() } else { human_bytes(m.bytes()) };
                        println!("{:12} {:24} {size:>10} {:8.2} s  {}", m.stage, m.label, m.seconds, m.key);
                    }
                }
            }
            Action::Du { store } => {
                let (mut nodes, mut total) = (0, 0);
                for (stage, usage) in open(store)?.usage()? {
                    println!(
                        "{stage:12} {:6} nodes {:>10} {:10.1} s",
                        usage.nodes,
                        human_bytes(usage.bytes),
                        usage.seconds
                    );
                    nodes += usage.nodes;
                    total += usage.bytes;
                }
                println!("{:12} {nodes:6} nodes {:>10}", "all", human_bytes(total));
            }
            Action::Verify { store, repair } => {
                let cancel = super::cancel::flag()?;
                let stopped = || cancel.load(std::sync::atomic::Ordering::Relaxed);
                let verdict =
                    open(store)?.verify(*repair, &|_, _| if stopped() { Err(Error::interrupted()) } else { Ok(()) })?;
                for bad in &verdict.bad {
                    println!("bad: {}: {}", bad.folder.display(), bad.cause);
                }
                println!(
                    "{} nodes, {} read: {} bad, {} removed",
                    verdict.nodes,
                    human_bytes(verdict.bytes),
                    verdict.bad.len(),
                    verdict.removed
                );
                if verdict.bad.len() > verdict.removed {
                    return Err(Error::failed(format!("{} nodes are damaged", verdict.bad.len()))
                        .help("`rootvox cache verify --repair` removes them; the next run computes them again"));
                }
            }
            Action::Gc { store, keep, older_than, dry_run } => {
                if keep.is_none() && older_than.is_none() {
                    return Err(Error::usage("cache gc: nothing says what may go")
                        .help("give --keep SIZE, --older-than DAYS or both; add --dry-run to look first"));
                }
                let age = older_than.map(|days| Duration::try_from_secs_f64(days * 86_400.0));
                let max_age = age.transpose().map_err(|e| Error::usage(format!("--older-than: {e}")))?;
                let rules = Collect { max_bytes: *keep, max_age, dry_run: *dry_run, ..Collect::default() };
                let gone = open(store)?.collect(&rules)?;
                let verb = if *dry_run { "would remove" } else { "removed" };
                println!(
                    "{verb} {} nodes and the values of {}: {}; {} nodes with {} stay",
                    gone.nodes,
                    gone.emptied,
                    human_bytes(gone.bytes),
                    gone.kept_nodes,
                    human_bytes(gone.kept_bytes)
                );
            }
        }
        Ok(())
    }
}

/// Opens a store that is there already.
fn open(store: &StoreOptions) -> Result<Store> {
    if !store.cache.is_dir() {
        return Err(Error::usage(format!("there is no store `{}`", store.cache.display()))
            .help("name it with --cache or ROOTVOX_CACHE; `rootvox run` makes one"));
    }
    Store::open(&store.cache)
}
