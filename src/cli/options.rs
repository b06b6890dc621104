//! Options that several subcommands share.

use crate::error::{Error, Result};
use crate::store::Store;
use crate::study::batch::Batch;
use clap::Args;
use clap::builder::RangedU64ValueParser;
use std::path::PathBuf;

/// Which study, and what is changed in it.
#[derive(Args)]
pub struct StudyOptions {
    /// The study file (TOML).
    pub study: PathBuf,
    /// Override a value of the study: SECTION.KEY=VALUE, as often as needed.
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}

/// Where finished nodes are kept.
#[derive(Args)]
pub struct StoreOptions {
    /// Folder of the store.
    #[arg(long, value_name = "DIR", env = "ROOTVOX_CACHE", default_value = "cache")]
    pub cache: PathBuf,
    /// Another store to take finished nodes from, such as the lab's; nothing is written there: its folder, or what
    /// `rootvox cache push` filled: a folder, https://HOST/PATH, s3://BUCKET/PREFIX (credentials: the AWS_ variables).
    #[arg(long, value_name = "PLACE", env = "ROOTVOX_CACHE_UPSTREAM")]
    pub cache_upstream: Option<String>,
}

impl StoreOptions {
    /// Opens the store, making it where it is missing.
    ///
    /// # Errors
    /// Where it cannot be made, or there is none upstream.
    pub fn open(&self) -> Result<Store> {
        self.over_upstream(Store::open(&self.cache)?)
    }

    /// The store as it is; nothing is made where it is missing.
    ///
    /// # Errors
    /// Where there is none upstream.
    pub fn look(&self) -> Result<Store> {
        self.over_upstream(Store::look(&self.cache))
    }

    /// The store, which has to be there.
    ///
    /// # Errors
    /// Where it is not.
    pub fn existing(&self) -> Result<Store> {
        let store = self.look()?;
        if store.exists() {
            return Ok(store);
        }
        Err(Error::usage(format!("there is no store in `{}`", self.cache.display()))
            .help("name it with --cache or ROOTVOX_CACHE; `rootvox run` makes one"))
    }

    /// The store upstream as a job names it that starts in the folder `here`.
    pub fn upstream_from(&self, here: &std::path::Path) -> Option<String> {
        let absolute = |place: &String| here.join(place).display().to_string();
        self.cache_upstream.as_ref().map(|place| if place.contains("://") { place.clone() } else { absolute(place) })
    }

    fn over_upstream(&self, store: Store) -> Result<Store> {
        match &self.cache_upstream {
            Some(upstream) => store.over(upstream),
            None => Ok(store),
        }
    }
}

/// Several studies at once.
#[derive(Args)]
pub struct StudiesOptions {
    /// Study files (TOML).
    #[arg(required = true)]
    pub study: Vec<PathBuf>,
    /// Override a value of every study: SECTION.KEY=VALUE, as often as needed.
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}

impl StudiesOptions {
    /// Reads all of them into one graph.
    ///
    /// # Errors
    /// Faults of the study files.
    pub fn load(&self) -> Result<Batch> {
        Batch::load_all(&self.study, &self.set)
    }
}

/// How much of the machine a run may take.
#[derive(Args)]
pub struct MachineOptions {
    /// Threads; all cores that the process may use when absent. Results do not depend on it.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    pub threads: Option<usize>,
    /// Memory that running nodes may take together, such as 4GiB; half of the machine's when absent.
    #[arg(long, value_name = "SIZE", value_parser = bytes)]
    pub memory: Option<u64>,
}

/// How a run can be looked at afterwards.
#[derive(Args)]
pub struct TraceOptions {
    /// Write a Chrome trace of the run, for chrome://tracing or ui.perfetto.dev.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
}

impl MachineOptions {
    /// Threads to use.
    pub fn threads(&self) -> usize {
        self.threads.unwrap_or_else(all_cores)
    }

    /// Bytes that running nodes may take together.
    pub fn memory_bytes(&self) -> u64 {
        self.memory.unwrap_or_else(half_the_memory)
    }
}

/// Cores that the process may use.
pub fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Half of the machine's memory, bytes.
pub fn half_the_memory() -> u64 {
    machine_memory().map_or(4 << 30, |(total, _)| (total / 2).max(1 << 30))
}

/// Memory that the process may use at all and what is free of it, bytes; `None` where the machine does not tell.
pub fn machine_memory() -> Option<(u64, u64)> {
    let mut system = sysinfo::System::new().ok()?;
    system.refresh_memory();
    let limit = system.cgroup_limits().map_or(u64::MAX, |c| c.total_memory);
    Some((system.total_memory().min(limit), system.available_memory().min(limit)))
}

/// Parses `4GiB`, `500 MB`, `1073741824`.
pub fn bytes(text: &str) -> std::result::Result<u64, String> {
    let text = text.trim();
    let split = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "" | "b" => 1_u64,
        "k" | "kib" => 1 << 10,
        "kb" => 1_000,
        "m" | "mib" => 1 << 20,
        "mb" => 1_000_000,
        "g" | "gib" => 1 << 30,
        "gb" => 1_000_000_000,
        "t" | "tib" => 1 << 40,
        "tb" => 1_000_000_000_000,
        other => return Err(format!("`{other}` is no unit of size; write 4GiB, 500MB or a number of bytes")),
    };
    let number: f64 =
        number.parse().map_err(|_| format!("`{text}` is no size; write 4GiB, 500MB or a number of bytes"))?;
    Ok((number * factor as f64) as u64)
}

/// A size for people: `1.4 GiB`.
pub fn human_bytes(bytes: u64) -> String {
    let mut value = bytes as f64;
    for unit in ["B", "KiB", "MiB", "GiB"] {
        if value < 1024.0 {
            return if unit == "B" { format!("{bytes} B") } else { format!("{value:.1} {unit}") };
        }
        value /= 1024.0;
    }
    format!("{value:.1} TiB")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_written() {
        assert_eq!(bytes("4GiB"), Ok(4 << 30));
        assert_eq!(bytes("1.5 kB"), Ok(1500));
        assert!(bytes("many").is_err() && bytes("4 stones").is_err());
        assert_eq!(human_bytes(1536), "1.5 KiB");
    }
}
