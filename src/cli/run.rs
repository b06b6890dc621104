//! `rootvox run`: bring a study up to date.

use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::progress::Display;
use crate::error::Result;
use crate::evaluation::Score;
use crate::flow::{Engine, Graph};
use crate::store::Store;
use crate::study::settings::Settings;
use crate::study::{graph, results};
use clap::Args;
use std::path::PathBuf;

/// Bring a study up to date: compute what is missing, take the rest from the store, write the results.
///
/// What a change does not touch is not computed again. Ctrl-C loses nothing that is finished: the same
/// command goes on from there.
///
/// Examples:
///   rootvox run pipelines/quickstart.toml
///   rootvox run pipelines/licorice.toml --set photos.dir=captures/plant-7 --set extract.high=0.03
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Run {
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
    /// Folder that the study's results folder is written into.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
}

impl Run {
    /// Runs the study.
    ///
    /// # Errors
    /// Faults of the study file, of the photographs and cameras, and of the machine.
    pub fn run(&self) -> Result<()> {
        let settings = Settings::load(&self.study.study, &self.study.set)?;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        let store = Store::open(&self.store.cache)?;
        let display = Display::new(&graph);
        let report = Engine::new(&store)
            .threads(self.machine.threads())
            .memory_bytes(self.machine.memory_bytes())
            .cancel(super::cancel::flag()?)
            .on_event(|event| display.show(event))
            .run(&graph, &nodes.targets())?;
        display.finish();
        let (path, written) = results::write(&self.results, &settings, &graph, &nodes, &report)?;
        if let Some(score) = nodes.score {
            let score: Score = report.artefact(score)?.json("score")?;
            eprintln!("{}", super::score_table::table(&score));
        }
        let state = if written { "written" } else { "unchanged" };
        eprintln!("results {state}: {}", path.display());
        eprintln!("look at: {}", path.join("report.html").display());
        Ok(())
    }
}
