//! `rootvox run`: bring a study up to date.

use super::options::{MachineOptions, StoreOptions, StudyOptions, TraceOptions, human_bytes, machine_memory};
use super::terminal::{data, talkln};
use super::trial::{self, TrialOptions};
use super::watch::Watch;
use crate::error::{Error, Result};
use crate::evaluation::Score;
use crate::flow::{Engine, Report};
use crate::store::Store;
use crate::study::batch::{Batch, Study};
use crate::study::cost::{Cost, Verdict};
use crate::study::sweep_results::{COMPARE, Swept};
use crate::study::{command, folder, results};
use clap::Args;
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Bring a study up to date: compute what is missing, take the rest from the store, write the results.
///
/// What a change does not touch is not computed again. Ctrl-C loses nothing that is finished: the same
/// command goes on from there. A [sweep] in the study runs as one: its points share what they have in common.
///
/// Examples:
///   rootvox run pipelines/quickstart.toml
///   rootvox run pipelines/licorice.toml --set photos.dir=captures/plant-7 --set extract.high=1.5
///   rootvox run pipelines/quickstart.toml --set 'sweep.extract.high=[0.8, 1.0, 1.5]' --best f1_1mm
///   rootvox run trial.toml --only plant=7
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Run {
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    captures: TrialOptions,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
    #[command(flatten)]
    trace: TraceOptions,
    /// Folder that the study's results folder is written into.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Of a sweep, print the point that is best by this column of sweep.csv, such as f1_1mm or rms_mm.
    #[arg(long, value_name = "COLUMN")]
    best: Option<String>,
    /// Run even what would take over 8 hours or more memory than the machine has.
    #[arg(long)]
    yes: bool,
}

impl Run {
    /// Runs the study.
    ///
    /// # Errors
    /// Faults of the study file, of the photographs and cameras, and of the machine.
    pub fn run(&self) -> Result<()> {
        let batch = self.captures.load(&self.study)?;
        if let (Some(column), false) = (&self.best, batch.studies.iter().any(Study::is_sweep)) {
            return Err(Error::usage(format!("--best {column}: `{}` is no sweep", self.study.study.display()))
                .help("lay a [sweep] over it, such as --set 'sweep.extract.high=[0.8, 1.0]'"));
        }
        let place = batch.results_in(&self.results);
        for study in &batch.studies {
            folder::check_place(&place, &study.name)?;
        }
        let store = self.store.open()?;
        let wanted = self.captures.wanted(&batch, &store)?;
        let (targets, threads) = (batch.targets(), self.machine.threads());
        self.forecast(&batch, &store)?;
        let watch = Watch::new(&batch, &store, &targets, threads, self.trace.trace.clone())?;
        let outcome = Engine::new(&store)
            .threads(threads)
            .memory_bytes(self.machine.memory_bytes())
            .cancel(super::cancel::flag()?)
            .on_event(|event| watch.see(event))
            .attempt(&batch.graph, &targets);
        watch.finish()?;
        let (report, failures) = outcome?;
        let mut faults = Vec::new();
        if let Some(of) = &batch.trial {
            faults = trial::write(&self.results, (&batch, of), &wanted, (&report, &failures), &self.study)?;
        }
        for study in batch.studies.iter().filter(|_| batch.trial.is_none()) {
            if study.is_sweep() {
                let swept = Swept::new(&batch, study, &report, &failures);
                faults.extend(swept.failures());
                self.sweep_results(study, &swept)?;
            } else {
                let reached = batch.graph.upstream(&study.targets());
                let own = failures.iter().filter(|(node, _)| reached[node.index()]).map(|(_, error)| error.clone());
                let own: Vec<Error> = own.collect();
                if own.is_empty() {
                    self.results(&batch, study, &report)?;
                }
                faults.extend(own);
            }
        }
        let mut seen = BTreeSet::new();
        Error::many(faults.into_iter().filter(|e| seen.insert(e.message.clone())).collect())
    }

    /// Tells of a long run before it starts, and refuses one that can hardly be meant.
    fn forecast(&self, batch: &Batch, store: &Store) -> Result<()> {
        let (threads, machine_bytes) = (self.machine.threads(), machine_memory().map_or(u64::MAX, |(total, _)| total));
        // What the store has is looked up only where it matters.
        let mut cost = Cost::of(batch, None);
        if cost.verdict(threads, machine_bytes) != Verdict::Run {
            let plan = Engine::new(store).status(&batch.graph, &batch.targets())?;
            cost = Cost::of(batch, Some(&plan));
        }
        let text = format!(
            "this takes about {:.1} hours on {threads} threads, {} of memory and {} of the store; the largest grid holds \
             {} million voxels",
            cost.seconds(threads) / 3600.0,
            human_bytes(cost.memory_bytes),
            human_bytes(cost.store_bytes),
            cost.voxels / 1_000_000
        );
        match cost.verdict(threads, machine_bytes) {
            Verdict::Refuse if !self.yes => {
                Err(Error::usage(format!("{text}; the machine has {}", human_bytes(machine_bytes)))
                    .help("raise grid.spacing, lower grid.depth, or add --yes to run it all the same"))
            }
            Verdict::Run => Ok(()),
            Verdict::Announce | Verdict::Refuse => {
                talkln!("note: {text}");
                Ok(())
            }
        }
    }

    fn results(&self, batch: &Batch, study: &Study, report: &Report) -> Result<()> {
        let written =
            results::write(&self.results, batch, study, report, &command::run(&self.study.study, &self.study.set))?;
        for (_, nodes) in study.points.iter().filter_map(|point| point.planned.as_ref().ok()) {
            if let Some(score) = nodes.score {
                let score: Score = report.artefact(score)?.json("score")?;
                talkln!("{}", super::score_table::table(&score));
            }
        }
        self.say(study, written, "report.html");
        Ok(())
    }

    fn sweep_results(&self, study: &Study, swept: &Swept<'_>) -> Result<()> {
        let written = swept.write(&self.results)?;
        let failed = swept.failures().len();
        talkln!("{}: {} points, {failed} failed", study.name, study.points.len());
        self.say(study, written, "contact.svg");
        if swept.is_compared() {
            talkln!("points compared: {}", self.results.join(&study.name).join(COMPARE).display());
        }
        let Some(column) = &self.best else { return Ok(()) };
        let table = swept.table()?;
        let best = table.best(column)?.and_then(|n| study.points.get(n).zip(table.rows.get(n)));
        let Some((point, row)) = best else {
            return Err(Error::failed(format!("no point of `{}` has a number in column `{column}`", study.name)));
        };
        let value = table.columns.iter().position(|c| c == column).and_then(|at| row.get(at));
        data!("point {}  {column}={}", point.number, value.map_or("", String::as_str));
        for (parameter, value) in study.parameters.iter().zip(&point.values) {
            data!("  --set {parameter}={value}");
        }
        data!("\n");
        Ok(())
    }

    fn say(&self, study: &Study, written: bool, look_at: &str) {
        let path = self.results.join(&study.name);
        let state = if written { "written" } else { "unchanged" };
        talkln!("results {state}: {}", path.display());
        talkln!("look at: {}", path.join(look_at).display());
    }
}
