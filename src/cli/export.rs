//! `rootvox export`: single pictures out of a study.

use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::progress::Display;
use crate::error::{Error, Result};
use crate::flow::{Engine, Graph, Inputs};
use crate::formats::picture;
use crate::stages::render::Render;
use crate::store::Store;
use crate::study::graph;
use crate::study::settings::Settings;
use clap::{Args, Subcommand};
use ndarray::{Axis, s};
use std::path::PathBuf;

/// Take a single picture out of a study.
#[derive(Args)]
pub struct Export {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Slice(Slice),
}

/// A horizontal slice of one view's volume: how the rays of that photograph run through the water.
///
/// Voxels that the view says nothing about are black. Nothing but the view's own photograph and camera is
/// computed for it.
///
/// Example:
///   rootvox export slice pipelines/quickstart.toml --view 003.jpg --z 60 -o slice.png
#[derive(Args)]
#[command(verbatim_doc_comment)]
struct Slice {
    #[command(flatten)]
    study: StudyOptions,
    /// Name of the photograph.
    #[arg(long, value_name = "PHOTO")]
    view: String,
    /// Depth of the slice below the rim, mm; the nearest plane of the grid is taken.
    #[arg(long, value_name = "MM")]
    z: f64,
    /// The PNG to write.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl Export {
    /// Writes the picture.
    ///
    /// # Errors
    /// Faults of the study, an unknown photograph, a depth outside the grid.
    pub fn run(&self) -> Result<()> {
        let What::Slice(slice) = &self.what;
        slice.run()
    }
}

impl Slice {
    fn run(&self) -> Result<()> {
        let settings = Settings::load(&self.study.study, &self.study.set)?;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        if !nodes.photos.contains(&self.view) {
            return Err(Error::usage(format!("the study has no photograph `{}`", self.view))
                .help(format!("its photographs are {}", nodes.photos.join(", "))));
        }
        let grid = settings.grid;
        let plane = ((self.z - grid.origin_mm[2]) / grid.spacing_mm).round();
        if !(plane >= 0.0 && plane < grid.shape[0] as f64) {
            let deepest = grid.origin_mm[2] + grid.spacing_mm * (grid.shape[0] - 1) as f64;
            return Err(Error::usage(format!("--z {} mm lies outside the grid", self.z))
                .help(format!("it reaches from {} to {deepest} mm", grid.origin_mm[2])));
        }
        let (photo, camera) =
            (graph.find(&format!("undistort/{}", self.view))?, graph.find(&format!("camera/{}", self.view))?);
        let store = Store::open(&self.store.cache)?;
        let display = Display::new(graph.labels());
        let report = Engine::new(&store)
            .threads(self.machine.threads())
            .memory_bytes(self.machine.memory_bytes())
            .cancel(super::cancel::flag()?)
            .on_event(|event| display.show(event))
            .run(&graph, &[photo, camera])?;
        display.finish();
        let inputs =
            Inputs::new([("photo", vec![report.artefact(photo)?]), ("camera", vec![report.artefact(camera)?])]);
        let render = Render { tank: settings.tank, grid, options: settings.render.options() };
        let slab = render.planes(&inputs)?.get(plane as usize..plane as usize + 1);
        let rgb = slab.index_axis(Axis(0), 0).slice(s![.., .., ..3]).to_owned();
        std::fs::write(&self.out, picture::png(rgb.view())?).map_err(|e| Error::io("write", &self.out, e))?;
        eprintln!("slice written: {}", self.out.display());
        Ok(())
    }
}
