//! `rootvox cluster`: workers on a cluster, started by its own scheduler.

use super::cluster_status::Status;
use super::options::{StoreOptions, StudiesOptions, bytes, human_bytes};
use super::slurm_script::Jobs;
use super::terminal::{data, dataln, talkln};
use super::work::duration;
use crate::error::{Error, Result};
use crate::study::{command, folder};
use clap::builder::RangedU64ValueParser;
use clap::{Args, Subcommand};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Run studies on a cluster: workers started by its scheduler, on a store that all machines see.
#[derive(Args)]
pub struct Cluster {
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    Slurm(Slurm),
    Status(Status),
}

impl Cluster {
    /// Does what the action says.
    ///
    /// # Errors
    /// As the action.
    pub fn run(&self) -> Result<()> {
        match &self.action {
            Action::Slurm(c) => c.run(),
            Action::Status(c) => c.run(),
        }
    }
}

/// Write, and with --submit hand in, the jobs of a study for Slurm: an array of workers, and a job after them that
/// writes the results.
///
/// The scripts are plain sbatch in cluster/<study>/: read and change them as you like. Example:
///   rootvox cluster slurm plants.toml --workers 32 --time 1h --partition short --submit
#[derive(Args)]
#[command(verbatim_doc_comment)]
struct Slurm {
    #[command(flatten)]
    studies: StudiesOptions,
    #[command(flatten)]
    store: StoreOptions,
    /// Folder that the results folders are written into.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// How many workers.
    #[arg(long, value_name = "N", value_parser = RangedU64ValueParser::<usize>::new().range(1..=100_000))]
    workers: usize,
    /// Time limit of each job, such as 1h; workers end by themselves before it.
    #[arg(long, value_name = "TIME", value_parser = duration)]
    time: Duration,
    /// Cores of each worker.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = RangedU64ValueParser::<usize>::new().range(1..=1024))]
    cores: usize,
    /// Memory of each worker.
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = bytes)]
    memory: u64,
    /// Partition of the cluster; its default when absent.
    #[arg(long)]
    partition: Option<String>,
    /// Account to charge; yours when absent.
    #[arg(long)]
    account: Option<String>,
    /// Hand the jobs in.
    #[arg(long)]
    submit: bool,
}

impl Slurm {
    fn run(&self) -> Result<()> {
        // A fault of the study is told here, not in 32 logs.
        let batch = self.studies.load()?;
        for study in &batch.studies {
            folder::check_place(&batch.results_in(&self.results), &study.name)?;
        }
        let here =
            std::env::current_dir().map_err(|e| Error::failed(format!("cannot tell the current folder: {e}")))?;
        let first = self.studies.study.first().and_then(|path| path.file_stem()).unwrap_or_default().to_string_lossy();
        let place = here.join("cluster").join(&*first);
        let jobs = Jobs {
            name: format!("rootvox-{first}"),
            written_by: std::env::args().map(|word| command::quoted(&word)).collect::<Vec<_>>().join(" "),
            program: std::env::current_exe().map_err(|e| Error::failed(format!("cannot tell where I am: {e}")))?,
            studies: self.studies.study.iter().map(|study| here.join(study)).collect(),
            set: self.studies.set.clone(),
            cache: here.join(&self.store.cache),
            cache_upstream: self.store.upstream_from(&here),
            results: here.join(&self.results),
            logs: place.join("logs"),
            directory: here,
            workers: self.workers,
            time: self.time,
            cores: self.cores,
            memory_bytes: self.memory,
            partition: self.partition.clone(),
            account: self.account.clone(),
        };
        self.store.open()?;
        std::fs::create_dir_all(&jobs.logs).map_err(|e| Error::io("create", &jobs.logs, e))?;
        write(&place.join("workers.sbatch"), &jobs.workers())?;
        write(&place.join("results.sbatch"), &jobs.closing())?;
        let each = format!("{} cores, {}", self.cores, human_bytes(self.memory));
        talkln!("written: {} workers of {each} in {}", self.workers, place.display());
        if !self.submit {
            data!("{}", jobs.submission(&place));
            return Ok(());
        }
        let workers = sbatch(&[], &place.join("workers.sbatch"))?;
        let closing = sbatch(&[&format!("--dependency=afterany:{workers}")], &place.join("results.sbatch"))?;
        dataln!("workers {workers}, results {closing}");
        let words: Vec<String> = self.studies.study.iter().map(|s| command::quoted(&s.display().to_string())).collect();
        talkln!("look at: rootvox cluster status {}", words.join(" "));
        Ok(())
    }
}

fn write(path: &Path, text: &str) -> Result<()> {
    std::fs::write(path, text).map_err(|e| Error::io("write", path, e))
}

/// Submits a script and gives the number of the job.
fn sbatch(options: &[&str], script: &Path) -> Result<String> {
    let output = Command::new("sbatch").arg("--parsable").args(options).arg(script).output().map_err(|e| {
        Error::failed(format!("cannot run sbatch: {e}"))
            .help("use --submit where Slurm is installed, or leave it out and hand the scripts in there")
    })?;
    let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    match said.split(';').next() {
        Some(id) if output.status.success() && !id.is_empty() => Ok(id.to_owned()),
        _ => Err(Error::failed(format!("sbatch refused `{}`: {}", script.display(), {
            String::from_utf8_lossy(&output.stderr).trim().to_owned()
        }))
        .help("mend the script, or what was asked for, and hand it in again")),
    }
}
