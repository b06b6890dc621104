//! `rootvox export cameras`: lens and poses of a study for other programs.

use super::computed::computed;
use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::flow::Graph;
use crate::formats::NamedView;
use crate::formats::camera_file::{self, Format, means};
use crate::study::graph;
use crate::study::settings::Settings;
use clap::Args;
use std::path::PathBuf;

/// Lens and poses of every photograph, in the tank's frame and mm, for other programs.
///
/// colmap: the text files of a model without points, for COLMAP, OpenMVG, Blender's and Metashape's importers.
/// transforms: a transforms.json for nerfstudio and instant-ngp. cameras: a cameras.json as the results hold it.
/// Cameras that the study finds in its photographs are found first; nothing else is computed.
///
/// Examples:
///   rootvox export cameras pipelines/quickstart.toml --format colmap -o sparse/0
///   rootvox export cameras pipelines/quickstart.toml --format transforms -o .
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Cameras {
    #[command(flatten)]
    study: StudyOptions,
    /// colmap, transforms or cameras.
    #[arg(long, value_name = "FORMAT", value_parser = ["colmap", "transforms", "cameras"])]
    format: String,
    /// Folder to write into; made where it is missing.
    #[arg(long, short, value_name = "DIR")]
    out: PathBuf,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl Cameras {
    pub(super) fn run(&self) -> Result<()> {
        let settings = Settings::load(&self.study.study, &self.study.set)?;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        let report = computed(&graph, &[nodes.cameras], &self.store, &self.machine)?;
        let found: Vec<NamedView> = report.artefact(nodes.cameras)?.json("cameras")?;
        let of = |photo: &String| {
            let view = found.iter().find(|v| means(&v.file, photo)).map(|v| v.view.clone());
            let view = view.ok_or_else(|| Error::failed(format!("the photograph `{photo}` has no camera")))?;
            Ok(NamedView { file: photo.clone(), view })
        };
        let views = nodes.photos.iter().map(of).collect::<Result<Vec<_>>>()?;
        let format = match self.format.as_str() {
            "colmap" => Format::Colmap,
            "transforms" => Format::TransformsJson,
            _ => Format::CamerasJson,
        };
        let files = camera_file::write(&views, format)?;
        std::fs::create_dir_all(&self.out).map_err(|e| Error::io("create", &self.out, e))?;
        for (name, text) in files {
            let path = self.out.join(name);
            std::fs::write(&path, text).map_err(|e| Error::io("write", &path, e))?;
            talkln!("cameras written: {}", path.display());
        }
        Ok(())
    }
}
