//! `rootvox corrections`: corrections of a study's roots, as a file.

use super::computed::computed;
use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::terminal::{data, talkln};
use crate::error::{Error, Result};
use crate::flow::Graph;
use crate::formats::{corrections_toml, rsml};
use crate::roots::RootSystem;
use crate::roots::correction::Correction;
use crate::roots::correction::difference::difference;
use crate::study::graph;
use crate::study::settings::Settings;
use clap::{Args, Subcommand};
use std::path::PathBuf;

/// Make a file of corrections.
#[derive(Args)]
pub struct Corrections {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    FromRsml(FromRsml),
}

/// From roots that were corrected in another program.
///
/// Holds the roots of an RSML file (3D, in the tank's frame: a roots.rsml of rootvox opened, corrected and saved elsewhere)
/// against the study's traced roots and writes the corrections that lead from these to those. They name places, so they still
/// apply, or say that they do not, when settings change. Name the file in the study: [corrections] file = "corrections.toml".
///
/// Example:
///   rootvox corrections from-rsml plant-7.toml corrected.rsml -o corrections.toml
#[derive(Args)]
#[command(verbatim_doc_comment)]
struct FromRsml {
    #[command(flatten)]
    study: StudyOptions,
    /// The corrected roots.
    rsml: PathBuf,
    /// The file to write; stdout when absent. A file that is there is not overwritten.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Who corrected; stands in the record of each correction.
    #[arg(long, value_name = "NAME", default_value = "")]
    by: String,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl Corrections {
    /// Writes the file.
    ///
    /// # Errors
    /// Faults of the study or of the RSML, a file that is there already.
    pub fn run(&self) -> Result<()> {
        match &self.what {
            What::FromRsml(from) => from.run(),
        }
    }
}

impl FromRsml {
    fn run(&self) -> Result<()> {
        let text = std::fs::read_to_string(&self.rsml).map_err(|e| Error::io("read", &self.rsml, e))?;
        let reading = rsml::read(&self.rsml.display().to_string(), &text)?;
        reading.notes.iter().for_each(|note| talkln!("note: {note}"));
        let settings = Settings::load(&self.study.study, &self.study.set)?;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        let traced = nodes.corrections.as_ref().map_or(nodes.system, |c| c.traced);
        let report = computed(&graph, &[traced], &self.store, &self.machine)?;
        let system: RootSystem = report.artefact(traced)?.json("system.json")?;
        let changes = difference(&system.roots, &reading.roots, settings.corrections.params())?;
        let (by, when) = (self.by.clone(), jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string());
        let note = format!("from {}", self.rsml.file_name().unwrap_or_default().display());
        let list: Vec<Correction> = changes
            .into_iter()
            .map(|change| Correction { change, by: by.clone(), when: when.clone(), note: note.clone() })
            .collect();
        let text = corrections_toml::write(&list)?;
        match &self.out {
            Some(out) if out.exists() => {
                return Err(Error::usage(format!("`{}` is there already", out.display()))
                    .help("name another file, or take it away first"));
            }
            Some(out) => std::fs::write(out, text).map_err(|e| Error::io("write", out, e))?,
            None => data!("{text}"),
        }
        talkln!("{} corrections", list.len());
        Ok(())
    }
}
