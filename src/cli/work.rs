//! `rootvox work`: one of several workers on a shared store.

use super::options::{StoreOptions, StudiesOptions, all_cores, bytes, half_the_memory};
use super::tally::Tally;
use super::terminal::dataln;
use super::watch::Watch;
use crate::error::{Error, Result};
use crate::flow::Engine;
use crate::study::batch::Study;
use clap::Args;
use clap::builder::RangedU64ValueParser;
use std::time::{Duration, Instant};

/// Compute nodes of studies together with other workers on one store; write no results.
///
/// Start as many as you like, on as many machines as see the store and the photographs, at any time. Each takes the node
/// that has the longest path before it and that no other worker is at. It ends when nothing is left, when --for is over
/// (running nodes are finished), or on SIGTERM or Ctrl-C (running nodes are given back at once, finished ones kept; exit
/// code 0 all the same). `rootvox run` then writes the results. See docs/cluster.md.
///
/// Examples:
///   rootvox work plants.toml --cache /lab/cache --for 50m
///   rootvox work plant-7.toml plant-8.toml --cores 4 --memory 8GiB
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Work {
    #[command(flatten)]
    studies: StudiesOptions,
    #[command(flatten)]
    store: StoreOptions,
    /// Begin no node after this time, such as 50m or 1h30m.
    #[arg(long = "for", value_name = "TIME", value_parser = duration)]
    time: Option<Duration>,
    /// Cores to use; all that the process may use when absent. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    cores: Option<usize>,
    /// Memory that running nodes may take together, such as 4GiB; half of the machine's when absent.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    memory: Option<u64>,
    /// The log of this worker, to be named where a node fails; `rootvox cluster` sets it.
    #[arg(long, value_name = "FILE", env = "ROOTVOX_LOG", hide = true)]
    log: Option<String>,
}

impl Work {
    /// Works.
    ///
    /// # Errors
    /// Faults of the study files, and the nodes that failed here.
    pub fn run(&self) -> Result<()> {
        let begun = Instant::now();
        let end = self.time.map(|time| begun + time);
        let cores = self.cores.unwrap_or_else(all_cores);
        // Reading studies and photographs keeps to the cores too.
        rayon::ThreadPoolBuilder::new()
            .num_threads(cores)
            .build_global()
            .map_err(|e| Error::failed(format!("cannot start threads: {e}")))?;
        let cancel = super::cancel::flag()?;
        let batch = self.studies.load()?;
        let store = self.store.open()?;
        let targets = batch.targets();
        let (watch, tally) = (Watch::new(&batch, &store, &targets, cores, None)?, Tally::default());
        let outcome = Engine::new(&store)
            .threads(cores)
            .memory_bytes(self.memory.unwrap_or_else(half_the_memory))
            .cancel(cancel.clone())
            .until(end)
            .log(self.log.clone())
            .on_event(|event| {
                watch.see(event);
                tally.take(event);
            })
            .attempt(&batch.graph, &targets);
        watch.finish()?;
        dataln!("{}", tally.words(begun.elapsed()));
        let mut faults: Vec<Error> = batch.studies.iter().flat_map(Study::faults).collect();
        match outcome {
            Ok((_, failures)) => faults.extend(failures.into_iter().map(|(_, error)| error)),
            // Stopped, as asked to.
            Err(error) if error.exit_code() == 130 => {}
            Err(error) => return Err(error),
        }
        Error::many(faults)
    }
}

/// Parses `50m`, `1h30m`, `90s`.
pub fn duration(text: &str) -> std::result::Result<Duration, String> {
    let unreadable = || format!("`{text}` is no time; write 50m, 1h30m or 90s");
    let parsed: jiff::SignedDuration = text.parse().map_err(|_| unreadable())?;
    Duration::try_from(parsed).map_err(|_| unreadable())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read() {
        assert_eq!(duration("50m"), Ok(Duration::from_secs(3000)));
        assert_eq!(duration("1h30m"), Ok(Duration::from_secs(5400)));
        assert!(duration("-5m").is_err() && duration("soon").is_err() && duration("").is_err());
    }
}
