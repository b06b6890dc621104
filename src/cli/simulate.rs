//! `rootvox simulate`: grow a root system and photograph it through a tank.

use super::computed::computed;
use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::flow::{Artefact, NodeId, Report};
use crate::formats::{NamedView, cameras_json, roots_json, rsml, tables, tank_json};
use crate::roots::traits::traits;
use crate::roots::{Root, TracedRoot};
use crate::study::batch::Batch;
use crate::study::nodes::StudyNodes;
use crate::study::settings::{Settings, Source};
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};

/// Grow a root system, photograph it through a tank, and write photographs and truth as a data set.
///
/// The study's [tank] and [simulate] sections say what grows and how it is photographed (docs/simulation.md); the folder
/// then holds images/ and the truth: tank.json, cameras.json, roots.json, the same roots as roots.rsml, and their
/// traits.csv. It can be reconstructed like any capture. Of a trial ([plants]) every capture is written into a folder of its own, with
/// plants.csv beside them (docs/trials.md).
///
/// Examples:
///   rootvox simulate pipelines/quickstart.toml --out captures/plant-8 --set simulate.seed=8
///   rootvox simulate pipelines/trial.toml --out captures/trial
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Simulate {
    #[command(flatten)]
    study: StudyOptions,
    /// Folder to write; it must not exist yet.
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl Simulate {
    /// Writes the data set.
    ///
    /// # Errors
    /// Faults of the study, a study without [simulate], a folder that exists or cannot be written.
    pub fn run(&self) -> Result<()> {
        let batch = Batch::load(&self.study.study, &self.study.set)?;
        let points = batch.studies.iter().flat_map(|study| &study.points);
        let planned: Vec<_> = points.map(|p| p.planned.as_ref().map_err(Clone::clone)).collect::<Result<_>>()?;
        let file = self.study.study.display();
        if planned.iter().any(|(settings, _)| !matches!(settings.source, Source::Simulated(_))) {
            return Err(Error::usage(format!("`{file}` has no [simulate] section"))
                .help("an empty [simulate] is enough; pipelines/quickstart.toml is an example"));
        }
        if planned.len() != 1 && (batch.trial.is_none() || planned.len() != batch.studies.len()) {
            return Err(Error::usage(format!("`{file}` means several captures"))
                .help("leave [sweep] and [studies] out; of a trial, [plants], every capture is written"));
        }
        if self.out.exists() {
            return Err(
                Error::usage(format!("`{}` exists already", self.out.display())).help("name a new folder with --out")
            );
        }
        let truth = |nodes: &StudyNodes| nodes.photo_nodes.first().map(|photo| batch.graph.inputs(*photo, "capture"));
        let of = |(_, nodes): &&(Settings, StudyNodes)| {
            nodes.photo_nodes.iter().copied().chain(truth(nodes).into_iter().flatten().copied()).collect::<Vec<_>>()
        };
        let targets: Vec<NodeId> = planned.iter().flat_map(of).collect();
        let report = computed(&batch.graph, &targets, &self.store, &self.machine)?;

        let parent = self.out.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(|e| Error::io("create", parent, e))?;
        let fresh = tempfile::tempdir_in(parent).map_err(|e| Error::io("write into", parent, e))?;
        for (n, (settings, nodes)) in planned.iter().enumerate() {
            let Some([capture]) = truth(nodes) else { return Err(Error::failed("a capture without photographs")) };
            let folder = match &batch.trial {
                Some(trial) => fresh.path().join(trial.captures[n].name()),
                None => fresh.path().to_owned(),
            };
            write(&folder, settings, nodes, &report, &report.artefact(*capture)?)?;
        }
        if let Some(trial) = &batch.trial {
            let columns: Vec<&str> = trial.columns().chain(["photos"]).collect();
            let rows = trial.captures.iter().map(|capture| {
                let mut row = capture.values();
                row.push(capture.name());
                row
            });
            let to = fresh.path().join("plants.csv");
            fs::write(&to, tables::csv(&columns, rows)?).map_err(|e| Error::io("write", &to, e))?;
        }
        fs::rename(fresh.keep(), &self.out).map_err(|e| Error::io("write", &self.out, e))?;
        talkln!("data set written: {}", self.out.display());
        Ok(())
    }
}

/// Writes photographs and truth of one capture.
fn write(folder: &Path, settings: &Settings, nodes: &StudyNodes, report: &Report, capture: &Artefact) -> Result<()> {
    let images = folder.join("images");
    fs::create_dir_all(&images).map_err(|e| Error::io("create", &images, e))?;
    for (name, &node) in nodes.photos.iter().zip(nodes.photo_nodes.iter()) {
        let to = images.join(name);
        fs::copy(report.artefact(node)?.path("file")?, &to).map_err(|e| Error::io("write", &to, e))?;
    }
    let views: Vec<NamedView> = capture.json("cameras")?;
    let put = |name: &str, text: String| {
        let to = folder.join(name);
        fs::write(&to, text).map_err(|e| Error::io("write", &to, e))
    };
    put("cameras.json", cameras_json::write(&views)?)?;
    put("tank.json", tank_json::write(&settings.true_tank)?)?;
    let roots: Vec<Root> = capture.json("roots")?;
    put("roots.json", roots_json::write(&roots)?)?;
    put("roots.rsml", rsml::write(&known(&roots), &about(&settings.name))?)?;
    let all = traits(&roots, settings.true_tank.water_level_mm, &settings.traits);
    let to = folder.join("traits.csv");
    fs::write(&to, tables::traits(&all)?).map_err(|e| Error::io("write", &to, e))
}

/// The true roots as if they were traced: without doubt.
fn known(roots: &[Root]) -> Vec<TracedRoot> {
    let of = |root: &Root| TracedRoot {
        radius_sd_mm: vec![0.0; root.points_mm.len()],
        views: vec![0; root.points_mm.len()],
        confidence: vec![1.0; root.points_mm.len()],
        root: root.clone(),
    };
    roots.iter().map(of).collect()
}

/// What the RSML says about itself; no clock, so that equal captures give equal files.
fn about(study: &str) -> rsml::About {
    rsml::About {
        last_modified: rsml::PROFILE_DATE.to_owned(),
        software: concat!("rootvox ", env!("CARGO_PKG_VERSION")).to_owned(),
        user: "rootvox simulate".to_owned(),
        file_key: study.to_owned(),
        image: None,
        sequence: None,
    }
}
