//! `rootvox pack`: a study that travels.

use super::options::{StoreOptions, human_bytes};
use super::reach::reach;
use super::terminal::dataln;
use crate::error::{Error, Result};
use crate::store::Destination;
use crate::study::batch::Batch;
use crate::study::folder::LOCK;
use crate::study::pack::Parcel;
use clap::Args;
use std::path::PathBuf;

/// Pack a study with what it reads and its results into one file, for `rootvox rerun` on another machine.
///
/// The file is an ordinary zip with RO-Crate metadata at its root: data repositories and people can read it without
/// rootvox. Run the study first.
///
/// Example:
///   rootvox pack plant-7.toml -o plant-7.rootvox.zip
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Pack {
    /// The study file (TOML).
    study: PathBuf,
    /// Override a value of the study, as when it was run: SECTION.KEY=VALUE, as often as needed.
    #[arg(long = "set", value_name = "SECTION.KEY=VALUE")]
    set: Vec<String>,
    /// The file to write.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Folder that the study's results folder lies in.
    #[arg(long, value_name = "DIR", default_value = "results")]
    results: PathBuf,
    /// Leave the photographs out: their digests go with it, and rerun is told where they are.
    #[arg(long)]
    no_photographs: bool,
    /// Take the nodes of the store along, so that nothing has to be computed where it is opened.
    #[arg(long)]
    nodes: bool,
    #[command(flatten)]
    store: StoreOptions,
}

impl Pack {
    /// Packs.
    ///
    /// # Errors
    /// Where the study was not run, or the file cannot be written.
    pub fn run(&self) -> Result<()> {
        let batch = Batch::load(&self.study, &self.set)?;
        let results = batch.results_in(&self.results);
        let folder = tempfile::tempdir().map_err(|e| Error::io("write", &std::env::temp_dir(), e))?;
        if self.nodes {
            let store = self.store.existing()?;
            let destination = Destination::open(&folder.path().to_string_lossy())?;
            for study in &batch.studies {
                let lock = results.join(&study.name).join(LOCK);
                for (stage, key) in reach(&store, &lock)?.nodes {
                    destination.push(&store, &stage, key)?;
                }
            }
        }
        let parcel = Parcel {
            study: &self.study,
            batch: &batch,
            results: &results,
            photographs: !self.no_photographs,
            nodes: self.nodes.then_some(folder.path()),
        };
        let (files, bytes) = parcel.write(&self.output)?;
        dataln!("{}: {files} files, {}", self.output.display(), human_bytes(bytes));
        Ok(())
    }
}
