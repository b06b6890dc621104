//! `rootvox export`: single pictures, figures, or the cameras, out of a study.

use super::computed::computed;
use super::export_cameras::Cameras;
use super::export_figure::Figure;
use super::options::{MachineOptions, StoreOptions, StudyOptions};
use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::flow::{Graph, Inputs};
use crate::formats::picture;
use crate::stages::evidence_pictures::KINDS;
use crate::stages::render::Render;
use crate::stages::render_patch::RenderPatch;
use crate::study::graph;
use crate::study::render::Method;
use crate::study::settings::Settings;
use clap::{Args, Subcommand};
use ndarray::{Axis, s};
use std::path::PathBuf;

/// Take a single picture, a figure, or the cameras, out of a study.
#[derive(Args)]
pub struct Export {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    Slice(Slice),
    Evidence(Evidence),
    Cameras(Cameras),
    Figure(Figure),
}

/// A horizontal slice of one view's volume: how the rays of that photograph run through the water.
///
/// Voxels that the view says nothing about are black. Colours are those of the photograph, rendered as the study's
/// [render] says, whether the study keeps the views' volumes or streams them. Nothing but the view's own photograph and
/// camera is computed for it.
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
    /// Writes the picture, the figure or the cameras.
    ///
    /// # Errors
    /// Faults of the study, an unknown photograph, a depth outside the grid.
    pub fn run(&self) -> Result<()> {
        match &self.what {
            What::Slice(slice) => slice.run(),
            What::Evidence(evidence) => evidence.run(),
            What::Cameras(cameras) => cameras.run(),
            What::Figure(figure) => figure.run(),
        }
    }
}

/// What one photograph tells of roots, pixel by pixel.
///
/// share: black is background, white is root. confidence: white is sure; black has no say, as where roots and background are
/// alike, and takes no part in the merge. background: what is behind the roots, from the turn of the table or from the pixel's
/// surroundings. All are black where the photograph does not look into the water. Setting report.evidence = true puts all of them into
/// the results.
///
/// Example:
///   rootvox export evidence pipelines/quickstart.toml --view 003.jpg -o share.png
#[derive(Args)]
#[command(verbatim_doc_comment)]
struct Evidence {
    #[command(flatten)]
    study: StudyOptions,
    /// Name of the photograph.
    #[arg(long, value_name = "PHOTO")]
    view: String,
    /// share, confidence or background.
    #[arg(long, value_name = "WHAT", default_value = "share", value_parser = KINDS)]
    show: String,
    /// The PNG to write.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
    #[command(flatten)]
    store: StoreOptions,
    #[command(flatten)]
    machine: MachineOptions,
}

impl Evidence {
    fn run(&self) -> Result<()> {
        let mut settings = Settings::load(&self.study.study, &self.study.set)?;
        settings.report.evidence = true;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        let view = numbered(&nodes.photos, &self.view)?;
        let Some(&wanted) = nodes.shown()?.evidence_pictures.get(view) else {
            return Err(Error::usage("the study merges its photographs as they are: contrast.enabled is false")
                .help("there is no share of root to show; leave contrast.enabled out"));
        };
        let report = computed(&graph, &[wanted], &self.store, &self.machine)?;
        let bytes = report.artefact(wanted)?.bytes(&format!("{}.png", self.show))?;
        std::fs::write(&self.out, bytes).map_err(|e| Error::io("write", &self.out, e))?;
        talkln!("{} written: {}", self.show, self.out.display());
        Ok(())
    }
}

/// Place of a photograph among those of the study.
fn numbered(photos: &[String], view: &str) -> Result<usize> {
    photos.iter().position(|photo| photo == view).ok_or_else(|| {
        Error::usage(format!("the study has no photograph `{view}`"))
            .help(format!("its photographs are {}", photos.join(", ")))
    })
}

impl Slice {
    fn run(&self) -> Result<()> {
        let settings = Settings::load(&self.study.study, &self.study.set)?;
        let mut graph = Graph::new();
        let nodes = graph::add(&mut graph, &settings)?;
        numbered(&nodes.photos, &self.view)?;
        let grid = settings.grid;
        let plane = ((self.z - grid.origin_mm[2]) / grid.spacing_mm).round();
        if !(plane >= 0.0 && plane < grid.shape[0] as f64) {
            let deepest = grid.origin_mm[2] + grid.spacing_mm * (grid.shape[0] - 1) as f64;
            return Err(Error::usage(format!("--z {} mm lies outside the grid", self.z))
                .help(format!("it reaches from {} to {deepest} mm", grid.origin_mm[2])));
        }
        // The port of each input of the rendering, whose node is `<port>/<photograph>` but for the photograph's own.
        let mut ports = vec![("photo", "undistort"), ("camera", "camera")];
        if settings.render.method == Method::PatchRbf {
            ports.push(("lattice", "lattice"));
        }
        let of_view = |&(_, node): &(&str, &str)| graph.find(&format!("{node}/{}", self.view));
        let wanted = ports.iter().map(of_view).collect::<Result<Vec<_>>>()?;
        let report = computed(&graph, &wanted, &self.store, &self.machine)?;
        let input = |port: usize| Ok::<_, Error>((ports[port].0, vec![report.artefact(wanted[port])?]));
        let (tank, sizes) = (settings.tank, settings.render.sizes());
        let volume = match settings.render.method {
            Method::Exact => {
                let render = Render { tank, grid, options: settings.render.options() };
                render.planes(&Inputs::new([input(0)?, input(1)?]))?
            }
            Method::PatchRbf => {
                RenderPatch { tank, grid, sizes }.planes(&Inputs::new([input(0)?, input(1)?, input(2)?]))?
            }
        };
        let slab = volume.get(plane as usize..plane as usize + 1);
        let rgb = slab.index_axis(Axis(0), 0).slice(s![.., .., ..3]).to_owned();
        std::fs::write(&self.out, picture::png(rgb.view())?).map_err(|e| Error::io("write", &self.out, e))?;
        talkln!("slice written: {}", self.out.display());
        Ok(())
    }
}
