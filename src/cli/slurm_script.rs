//! The batch scripts of a cluster's jobs, as a person would write them.

use crate::study::command::quoted;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The time limit's share, and at the least so long, that running nodes have to finish after no new one begins.
const LAST: (f64, Duration) = (0.1, Duration::from_secs(60));

/// Seconds between SIGTERM and the end.
const WARNING_S: u64 = 60;

/// What the jobs are to do.
pub struct Jobs {
    /// Name of the jobs.
    pub name: String,
    /// The command that wrote them.
    pub written_by: String,
    /// The program.
    pub program: PathBuf,
    /// The study files.
    pub studies: Vec<PathBuf>,
    /// Overrides of values in the studies.
    pub set: Vec<String>,
    /// Folder of the store.
    pub cache: PathBuf,
    /// The store behind it.
    pub cache_upstream: Option<String>,
    /// Folder of the results.
    pub results: PathBuf,
    /// Where the jobs start.
    pub directory: PathBuf,
    /// Folder of the logs.
    pub logs: PathBuf,
    /// How many workers.
    pub workers: usize,
    /// Of each worker, its time limit.
    pub time: Duration,
    /// Its cores.
    pub cores: usize,
    /// Its memory, bytes.
    pub memory_bytes: u64,
    /// Partition of the cluster.
    pub partition: Option<String>,
    /// Account to charge.
    pub account: Option<String>,
}

impl Jobs {
    fn head(&self, about: &str, name: &str, log: &str) -> String {
        let mut text = format!("#!/bin/bash\n# {about}\n# Written by: {}\n", self.written_by);
        let mut say = |option: &str, value: &str| text.push_str(&format!("#SBATCH --{option}={value}\n"));
        say("job-name", name);
        let s = self.time.as_secs();
        say("time", &format!("{:02}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60));
        if let Some(partition) = &self.partition {
            say("partition", partition);
        }
        if let Some(account) = &self.account {
            say("account", account);
        }
        say("nodes", "1");
        say("ntasks", "1");
        say("cpus-per-task", &self.cores.to_string());
        say("mem", &format!("{}M", self.memory_bytes.div_ceil(1 << 20)));
        say("chdir", &quoted(&self.directory.display().to_string()));
        say("output", &quoted(&self.logs.join(log).display().to_string()));
        say("signal", &format!("B:TERM@{WARNING_S}"));
        text
    }

    fn tail(&self) -> String {
        let mut text = format!(" --cache {}", path(&self.cache));
        if let Some(upstream) = &self.cache_upstream {
            text.push_str(&format!(" --cache-upstream {}", quoted(upstream)));
        }
        self.set.iter().for_each(|set| text.push_str(&format!(" --set {}", quoted(set))));
        text
    }

    /// The array of workers.
    pub fn workers(&self) -> String {
        let about = format!("{} workers of rootvox; each may be killed and sent again at any time.", self.workers);
        let mut text = self.head(&about, &self.name, "worker-%A_%a.log");
        text.push_str(&format!(
            "#SBATCH --array=1-{}\n#SBATCH --requeue\n#SBATCH --open-mode=append\n\n",
            self.workers
        ));
        let last = self.time.mul_f64(LAST.0).max(LAST.1);
        let working = self.time.saturating_sub(last).max(self.time / 2).as_secs();
        let log = self.logs.join("worker-${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}.log");
        text.push_str(&format!("export ROOTVOX_LOG=\"{}\"\n", log.display()));
        let studies: Vec<String> = self.studies.iter().map(|study| path(study)).collect();
        text.push_str(&format!(
            "exec {} work {}{} --cores \"$SLURM_CPUS_PER_TASK\" --memory {} --for {working}s\n",
            path(&self.program),
            studies.join(" "),
            self.tail(),
            self.memory_bytes
        ));
        text
    }

    /// The job that writes the results once the workers are gone; it computes what they left.
    pub fn closing(&self) -> String {
        let about = "Writes the results when the workers are done, and computes what they left.";
        let mut text = self.head(about, &format!("{}-results", self.name), "results-%j.log");
        text.push_str("\nstatus=0\n");
        for study in &self.studies {
            text.push_str(&format!(
                "{} run {}{} --results {} --yes --threads \"$SLURM_CPUS_PER_TASK\" --memory {} || status=$?\n",
                path(&self.program),
                path(study),
                self.tail(),
                path(&self.results),
                self.memory_bytes
            ));
        }
        text.push_str("exit $status\n");
        text
    }

    /// The commands that submit both.
    pub fn submission(&self, folder: &Path) -> String {
        let (workers, closing) = (path(&folder.join("workers.sbatch")), path(&folder.join("results.sbatch")));
        format!("id=$(sbatch --parsable {workers})\nsbatch --dependency=afterany:$id {closing}\n")
    }
}

fn path(path: &Path) -> String {
    quoted(&path.display().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jobs() -> Jobs {
        Jobs {
            name: "rootvox-plants".into(),
            written_by: "rootvox cluster slurm plants.toml".into(),
            program: "/opt/rootvox".into(),
            studies: vec!["/lab/my plants.toml".into()],
            set: vec!["extract.high=1.5".into()],
            cache: "/lab/cache".into(),
            cache_upstream: None,
            results: "/lab/results".into(),
            directory: "/lab".into(),
            logs: "/lab/cluster/plants/logs".into(),
            workers: 32,
            time: Duration::from_secs(3600),
            cores: 2,
            memory_bytes: 4 << 30,
            partition: Some("short".into()),
            account: None,
        }
    }

    #[test]
    fn scripts_say_what_the_jobs_need_and_end_in_time() {
        let workers = jobs().workers();
        for line in ["--array=1-32", "--time=01:00:00", "--partition=short", "--cpus-per-task=2", "--mem=4096M"] {
            assert!(workers.contains(&format!("#SBATCH {line}\n")), "{line} in\n{workers}");
        }
        assert!(!workers.contains("--account"));
        assert!(workers.contains("exec /opt/rootvox work '/lab/my plants.toml' --cache /lab/cache --set"), "{workers}");
        assert!(workers.contains("--for 3240s\n"), "{workers}");
        let closing = jobs().closing();
        assert!(closing.contains("run '/lab/my plants.toml' --cache /lab/cache") && !closing.contains("--array"));
        let short = Jobs { time: Duration::from_secs(90), ..jobs() };
        assert!(short.workers().contains("--for 45s\n"));
    }
}
