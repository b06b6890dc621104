//! `rootvox cache`: what the store holds, whether it is sound, and how to make it smaller.

use super::options::{StoreOptions, bytes, human_bytes};
use super::reach::{Reach, reach};
use super::terminal::{dataln, talkln};
use crate::error::{Error, Result};
use crate::store::care::Collect;
use crate::store::{Key, Store};
use clap::{Args, Subcommand};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
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
    /// Sizes by stage, and by study.
    Du {
        #[command(flatten)]
        store: StoreOptions,
        /// Also what each of these takes, and takes alone: study files or locks.
        #[arg(long, value_name = "STUDY", num_args = 1..)]
        study: Vec<PathBuf>,
    },
    /// Keep a study's nodes whatever cleaning says.
    Pin {
        #[command(flatten)]
        store: StoreOptions,
        /// Study files, or the study.lock of results.
        #[arg(required = true)]
        study: Vec<PathBuf>,
    },
    /// Let cleaning have a study's nodes again.
    Unpin {
        #[command(flatten)]
        store: StoreOptions,
        /// Name of the pin.
        name: String,
    },
    /// List the pins: name, nodes, size.
    Pins {
        #[command(flatten)]
        store: StoreOptions,
    },
    /// Read every array again and compare all digests.
    Verify {
        #[command(flatten)]
        store: StoreOptions,
        /// Remove what is damaged: it is computed again when asked for.
        #[arg(long)]
        repair: bool,
        /// With --repair, compute what was removed again at once, where these studies need it.
        #[arg(long, value_name = "STUDY", num_args = 1.., requires = "repair")]
        study: Vec<PathBuf>,
    },
    /// Send a study's nodes to a store that others can read from; what is there already is not sent again.
    Push {
        #[command(flatten)]
        store: StoreOptions,
        /// The study file, or the study.lock of its results.
        study: PathBuf,
        /// s3://BUCKET/PREFIX (credentials: the AWS_ variables), or a folder, such as one that a web server shows.
        dest: String,
    },
    /// Fetch a study's nodes, and verify them; what is here already is not fetched again.
    Pull {
        /// Folder of the store.
        #[arg(long, value_name = "DIR", env = "ROOTVOX_CACHE", default_value = "cache")]
        cache: PathBuf,
        /// The study file, or the study.lock of its results.
        study: PathBuf,
        /// https://HOST/PATH, s3://BUCKET/PREFIX, or a folder that was pushed to.
        from: String,
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
        /// Keep only what these reach, and pins: study files or locks.
        #[arg(long, value_name = "STUDY", num_args = 1..)]
        reachable: Vec<PathBuf>,
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
    pub fn run(&self) -> Result<()> {
        match &self.action {
            Action::Ls { store, stage } => {
                let listed = store.existing()?.list()?;
                if let Some(stage) = stage {
                    check_stage(stage, listed.iter().map(|listed| listed.manifest.stage.as_str()).collect())?;
                }
                for listed in listed {
                    let m = &listed.manifest;
                    if stage.as_ref().is_none_or(|s| *s == m.stage) {
                        let size = if m.is_virtual { "no values".into() } else { human_bytes(m.bytes()) };
                        dataln!("{:12} {:24} {size:>10} {:8.2} s  {}", m.stage, m.label, m.seconds, m.key);
                    }
                }
            }
            Action::Du { store, study } => {
                let store = store.existing()?;
                let (mut nodes, mut total) = (0, 0);
                for (stage, usage) in store.usage()? {
                    dataln!(
                        "{stage:12} {:6} nodes {:>10} {:10.1} s",
                        usage.nodes,
                        human_bytes(usage.bytes),
                        usage.seconds
                    );
                    nodes += usage.nodes;
                    total += usage.bytes;
                }
                dataln!("{:12} {nodes:6} nodes {:>10}", "all", human_bytes(total));
                let reached = reaches(&store, study)?;
                by_study(&store, &reached.iter().map(|r| (r.name.clone(), r.keys())).collect::<Vec<_>>())?;
            }
            Action::Pin { store, study } => {
                let store = store.existing()?;
                for reach in reaches(&store, study)? {
                    let keys = reach.keys();
                    store.pin(&reach.name, &keys)?;
                    dataln!("pinned `{}`: {} nodes", reach.name, keys.len());
                }
            }
            Action::Unpin { store, name } => store.existing()?.unpin(name)?,
            Action::Pins { store } => {
                let store = store.existing()?;
                let pins = store.pins()?;
                by_study(&store, &pins.into_iter().collect::<Vec<_>>())?;
            }
            Action::Verify { store, repair, study } => super::verify::verify(&store.existing()?, *repair, study)?,
            Action::Push { store, study, dest } => super::cache_share::push(&store.existing()?, study, dest)?,
            Action::Pull { cache, study, from } => super::cache_share::pull(cache, study, from)?,
            Action::Gc { store, keep, older_than, reachable, dry_run } => {
                if keep.is_none() && older_than.is_none() && reachable.is_empty() {
                    return Err(Error::usage("cache gc: nothing says what may go").help(
                        "give --keep SIZE, --older-than DAYS or --reachable STUDY; add --dry-run to look first",
                    ));
                }
                let age = older_than.map(|days| Duration::try_from_secs_f64(days * 86_400.0));
                let max_age = age.transpose().map_err(|e| Error::usage(format!("--older-than: {e}")))?;
                let store = store.existing()?;
                let wanted = reaches(&store, reachable)?.into_iter().flat_map(|reach| reach.keys()).collect();
                let keep_only = (!reachable.is_empty()).then_some(wanted);
                let rules = Collect { max_bytes: *keep, max_age, keep_only, dry_run: *dry_run };
                let gone = store.collect(&rules)?;
                let verb = if *dry_run { "would remove" } else { "removed" };
                dataln!(
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

/// Fails where the store holds no node of that stage.
fn check_stage(stage: &str, held: BTreeSet<&str>) -> Result<()> {
    if held.contains(stage) {
        return Ok(());
    }
    let held: Vec<&str> = held.into_iter().collect();
    let held = if held.is_empty() { "no nodes at all".into() } else { format!("nodes of {}", held.join(", ")) };
    Err(Error::usage(format!("the store holds no node of a stage `{stage}`")).help(format!("it holds {held}")))
}

/// What the studies reach; says so where that is not known to the end.
fn reaches(store: &Store, studies: &[PathBuf]) -> Result<Vec<Reach>> {
    let reaches: Vec<Reach> = studies.iter().map(|path| reach(store, path)).collect::<Result<_>>()?;
    for reach in reaches.iter().filter(|reach| reach.pending > 0) {
        talkln!("{}: {} nodes are not in the store; what hangs on them is not known", reach.name, reach.pending);
    }
    Ok(reaches)
}

/// Per study its nodes, their size, and the size of those that no other one of the list reaches.
fn by_study(store: &Store, studies: &[(String, BTreeSet<Key>)]) -> Result<()> {
    if studies.is_empty() {
        return Ok(());
    }
    let sizes: BTreeMap<Key, u64> =
        store.list()?.into_iter().map(|listed| (listed.manifest.key, listed.manifest.bytes())).collect();
    for (n, (name, own)) in studies.iter().enumerate() {
        let others = |key: &Key| studies.iter().enumerate().any(|(m, (_, other))| m != n && other.contains(key));
        let held: Vec<(&Key, u64)> = own.iter().filter_map(|key| Some((key, *sizes.get(key)?))).collect();
        let all: u64 = held.iter().map(|(_, bytes)| bytes).sum();
        let alone: u64 = held.iter().filter(|(key, _)| !others(key)).map(|(_, bytes)| bytes).sum();
        let (all, alone) = (human_bytes(all), human_bytes(alone));
        dataln!("{:24} {:6} nodes {all:>10}  alone {alone:>10}", name, held.len());
    }
    Ok(())
}
