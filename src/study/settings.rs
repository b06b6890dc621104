//! A study as its file says it, checked: every section typed, every default written out.

use super::clean_path::clean;
use super::document::{Document, Resolved, Sources, note, written_but};
use super::inputs::{
    CameraSource, Cameras, CorrectionsSection, GridSection, Photos, StudySection, TankSection, TrueTank, Truth,
};
use super::origin::Origin;
use super::photographs::Found;
use super::render::RenderSection;
use super::scale;
use crate::calibration::RegisterParams;
use crate::calibration::masks::MaskParams;
use crate::error::{Error, Result};
use crate::growth::follow::FollowParams;
use crate::growth::recall::RecallParams;
use crate::optics::Tank;
use crate::photo::evidence::ContrastParams;
use crate::roots::diameter::DiameterParams;
use crate::roots::explain::ExplainParams;
use crate::roots::traits::TraitParams;
use crate::roots::{HierarchyParams, TraceParams};
use crate::simulation::{AgeParams, CaptureParams, GrowthParams, MisjudgeParams};
use crate::stages::capture::DayParams;
use crate::stages::sfm::SfmParams;
use crate::volume::Grid;
use crate::volume::hysteresis::Hysteresis;
use crate::volume::merge::Merge;
use crate::volume::rootness::Rootness;
use crate::volume::suppress::Suppress;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `[simulate]`: photograph a grown root system instead of reading photographs.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Simulate {
    /// Seed of growth, rotation and noise.
    pub seed: u64,
    /// How the roots grow.
    pub growth: GrowthParams,
    /// How old the plant is: full grown when it does not say.
    pub age: AgeParams,
    /// How they are photographed.
    pub capture: CaptureParams,
    /// On which day: how the tank was put before the camera.
    pub day: DayParams,
    /// The tank they stand in, where `[tank]` is to be a wrong assumption.
    pub tank: TrueTank,
    /// Errors of the cameras that the reconstruction goes by.
    pub misjudge: MisjudgeParams,
}

/// `[overlay]`: the pictures of roots on photographs.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct OverlaySection {
    /// Radius of a mark, px.
    pub mark_radius: f64,
}

impl OverlaySection {
    /// Refuses a mark that is none.
    fn check(&self) -> Result<()> {
        if (0.0..=100.0).contains(&self.mark_radius) {
            return Ok(());
        }
        Err(Error::usage(format!("overlay.mark_radius is {}", self.mark_radius)).help("give 0 to 100 px"))
    }
}

impl Default for OverlaySection {
    fn default() -> Self {
        Self { mark_radius: 1.0 }
    }
}

/// `[report]`: pictures beside the numbers.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ReportSection {
    /// Depth of a horizontal slice to show, mm below the rim.
    pub slice: Option<f64>,
    /// Show per photograph what is behind the roots, the share of root, and how sure it is, in `evidence/`.
    pub evidence: bool,
}

/// Where the photographs come from.
#[derive(Debug, Clone)]
pub enum Source {
    /// Files, in capture order.
    Files(Vec<PathBuf>),
    /// A simulated capture.
    Simulated(Box<Simulate>),
}

/// A study, ready to be made into a graph.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Name of the results folder.
    pub name: String,
    /// Folder that input paths start from.
    pub input_dir: PathBuf,
    /// The photographs.
    pub source: Source,
    /// `[cameras]`.
    pub cameras: Cameras,
    /// A mask given as a picture.
    pub mask_picture: Option<PathBuf>,
    /// `[mask]`, read where cameras come from the photographs.
    pub mask: MaskParams,
    /// `[sfm]`, read where cameras come from the photographs.
    pub sfm: SfmParams,
    /// `[pose]`, read where cameras come from the photographs.
    pub pose: RegisterParams,
    /// The tank that the reconstruction goes by.
    pub tank: Tank,
    /// The tank that was photographed: another only in simulated captures that say so.
    pub true_tank: Tank,
    /// The voxels.
    pub grid: Grid,
    /// `[render]`.
    pub render: RenderSection,
    /// `[contrast]`.
    pub contrast: ContrastParams,
    /// `[merge]`.
    pub merge: Merge,
    /// `[rootness]`.
    pub rootness: Rootness,
    /// `[suppress]`.
    pub suppress: Suppress,
    /// `[extract]`.
    pub extract: Hysteresis,
    /// `[trace]`.
    pub trace: TraceParams,
    /// `[explain]`.
    pub explain: ExplainParams,
    /// `[diameters]`.
    pub diameters: DiameterParams,
    /// `[hierarchy]`.
    pub hierarchy: HierarchyParams,
    /// `[follow]`, read where a plant has several days.
    pub follow: FollowParams,
    /// `[recall]`, read where a plant has several days.
    pub recall: RecallParams,
    /// `[corrections]`.
    pub corrections: CorrectionsSection,
    /// The file of corrections, where there is one.
    pub corrections_file: Option<PathBuf>,
    /// `[traits]`.
    pub traits: TraitParams,
    /// `[overlay]`.
    pub overlay: OverlaySection,
    /// `[report]`.
    pub report: ReportSection,
    /// `[truth]`.
    pub truth: Truth,
    /// What a person should know of how the settings were understood.
    pub notes: Vec<String>,
    /// Every value that counted, by section and key, as TOML.
    pub resolved: Resolved,
}

/// The sections of a study file.
const SECTIONS: &[&str] = &[
    "study",
    "plants",
    "simulate",
    "photos",
    "cameras",
    "mask",
    "sfm",
    "pose",
    "tank",
    "grid",
    "render",
    "contrast",
    "merge",
    "rootness",
    "suppress",
    "extract",
    "trace",
    "explain",
    "diameters",
    "hierarchy",
    "follow",
    "recall",
    "corrections",
    "traits",
    "overlay",
    "report",
    "truth",
];

impl Settings {
    /// Reads the study file at `path` with `--set` overrides laid over it; what it sweeps, and the studies that it
    /// derives from itself, are left out.
    ///
    /// # Errors
    /// Every fault of the file at once, with line, column and remedy.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self> {
        let sources = Sources::open(path, overrides)?;
        let mut file = Document::parse(&sources)?;
        for left_out in ["sweep", "studies", "plants"] {
            file.take_table(left_out);
        }
        Self::read(file, &Origin::of(path, overrides))
    }

    /// Every value that counted, but those of some sections.
    pub(super) fn resolved_but(&self, sections: &[&str]) -> String {
        written_but(&self.resolved, sections)
    }

    /// Reads the sections of `file`.
    ///
    /// # Errors
    /// As [`Settings::load`].
    pub(super) fn read(mut file: Document<'_>, origin: &Origin) -> Result<Self> {
        let study: StudySection = file.section("study");
        let simulated = file.has("simulate");
        let simulate: Simulate = file.section("simulate");
        let photos: Photos = file.section("photos");
        let cameras: Cameras = file.section("cameras");
        let mask: MaskParams = file.section("mask");
        let sfm: SfmParams = file.section("sfm");
        let pose: RegisterParams = file.section("pose");
        let tank: TankSection = file.section("tank");
        let grid: GridSection = file.section("grid");
        let render: RenderSection = file.section("render");
        let contrast: ContrastParams = file.section("contrast");
        let merge: Merge = file.section("merge");
        let rootness: Rootness = file.section("rootness");
        let suppress: Suppress = file.section("suppress");
        let extract: Hysteresis = file.section("extract");
        let trace: TraceParams = file.section("trace");
        let explain: ExplainParams = file.section("explain");
        let diameters: DiameterParams = file.section("diameters");
        let hierarchy: HierarchyParams = file.section("hierarchy");
        let follow: FollowParams = file.section("follow");
        let recall: RecallParams = file.section("recall");
        let corrections: CorrectionsSection = file.section("corrections");
        let traits: TraitParams = file.section("traits");
        let overlay: OverlaySection = file.section("overlay");
        let report: ReportSection = file.section("report");
        let truth: Truth = file.section("truth");
        let simulated_as =
            [simulate.growth.check(), simulate.age.check(), simulate.capture.check(), simulate.misjudge.check()];
        let checks = [
            render.check(),
            contrast.check(),
            merge.check(),
            extract.check("extract"),
            trace.hysteresis().check("trace"),
            explain.check(),
            rootness.check(grid.spacing.unwrap_or(f64::NAN)),
            overlay.check(),
            corrections.check(),
            follow.check(),
            recall.check(),
        ];
        for checked in checks.into_iter().chain(simulated_as.into_iter().filter(|_| simulated)) {
            if let Err(e) = checked {
                file.refuse(e);
            }
        }
        if !simulate.misjudge.is_none() && cameras.source == CameraSource::Sfm {
            file.refuse(
                Error::usage("simulate.misjudge has no effect on cameras that are found in the photographs")
                    .help("leave it out, or set cameras.source = \"file\""),
            );
        }
        if cameras.lens.is_some() && cameras.source == CameraSource::File {
            file.refuse(
                Error::usage("cameras.lens has no effect on cameras from a file, which have their lenses")
                    .help("leave it out, or set cameras.source = \"sfm\""),
            );
        }
        if recall.enabled && !contrast.enabled {
            file.refuse(
                Error::usage("recall.enabled looks at each photograph's share of root, which contrast.enabled = false leaves out")
                    .help("leave one of both out"),
            );
        }
        let mut resolved = file.finish(SECTIONS)?;

        let input_dir = clean(&origin.base.join(&photos.dir));
        // A folder that is not there is told of before the files in it.
        let found = if simulated { Found::default() } else { origin.photographs(&input_dir, &photos)? };
        let mut notes: Vec<String> = found.note().into_iter().collect();
        let tank = tank.resolve(&input_dir)?;
        let true_tank = simulate.tank.resolve(&tank)?;
        let source = if simulated { Source::Simulated(Box::new(simulate)) } else { Source::Files(found.paths) };
        note(&mut resolved, "tank", &TankSection::from(&tank))?;
        resolved.retain(|name, _| simulated || !name.starts_with("simulate."));
        let depth_mm = grid.depth.unwrap_or_else(|| tank.floor_mm());
        let spacing_mm = match grid.spacing {
            Some(spacing_mm) => spacing_mm,
            None => {
                let make = || scale::of(&source, &cameras, &input_dir, &tank, depth_mm);
                let scale = origin.scale(&resolved, make)?;
                rootness.check(scale.spacing_mm)?;
                notes.push(scale.reason);
                note(&mut resolved, "grid", &GridSection { spacing: Some(scale.spacing_mm), ..grid })?;
                scale.spacing_mm
            }
        };
        let name = study.name.unwrap_or_else(|| origin.name.clone());
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\']) {
            return Err(Error::usage(format!("study.name `{name}` cannot name a folder"))
                .help("use letters, digits, `-` and `_`"));
        }
        resolved.insert("study.name".into(), toml::Value::from(name.as_str()).to_string());
        Ok(Self {
            name,
            source,
            mask_picture: photos.mask.map(|m| input_dir.join(m)),
            input_dir,
            cameras,
            mask,
            sfm,
            pose,
            grid: Grid::of_tank(&tank, spacing_mm, depth_mm)?,
            tank,
            true_tank,
            render,
            contrast,
            merge,
            rootness,
            suppress,
            extract,
            trace,
            explain,
            diameters,
            hierarchy,
            follow,
            recall,
            corrections_file: corrections.file.as_ref().map(|file| clean(&origin.corrections.join(file))),
            corrections,
            traits,
            overlay,
            report,
            truth,
            notes,
            resolved,
        })
    }
}
