//! A study's settings as a graph of nodes: what is computed from what.

use super::inputs::{CameraSource, Frame};
use super::render::Method;
use super::settings::{Settings, Source};
use crate::error::{Error, Result};
use crate::evaluation::ScoreParams;
use crate::flow::{Graph, NodeId};
use crate::stages::axis::Axis;
use crate::stages::camera::Camera;
use crate::stages::cameras::Cameras;
use crate::stages::capture::{Capture, photo_name};
use crate::stages::contrast::Contrast;
use crate::stages::diameters::Diameters;
use crate::stages::evaluate::Evaluate;
use crate::stages::extract::Extract;
use crate::stages::feature::Feature;
use crate::stages::labels::Labels;
use crate::stages::lattice::Lattice;
use crate::stages::merge::Merge;
use crate::stages::overlay::Overlay;
use crate::stages::photograph::Photograph;
use crate::stages::pose::Pose;
use crate::stages::pose_pictures::PosePictures;
use crate::stages::render::Render;
use crate::stages::render_patch::RenderPatch;
use crate::stages::rootness::Rootness;
use crate::stages::sfm::{Sfm, installed};
use crate::stages::sfm_known::SfmKnown;
use crate::stages::sfm_mask::SfmMask;
use crate::stages::slices::Slices;
use crate::stages::suppress::Suppress;
use crate::stages::trace::Trace;
use crate::stages::traits::Traits;
use crate::stages::undistort::Undistort;
use crate::stages::volume::Volume;
use std::path::Path;

/// The nodes of cameras found in the photographs.
#[derive(Debug, Clone)]
pub struct CalibrationNodes {
    /// The mask for structure from motion.
    pub mask: NodeId,
    /// Cameras, quality, uncertainties.
    pub pose: NodeId,
    /// Outlines and ring.
    pub pictures: NodeId,
}

/// The nodes of a study whose results people look at.
#[derive(Debug, Clone)]
pub struct StudyNodes {
    /// Name of each photograph, in capture order.
    pub photos: Vec<String>,
    /// The photographs themselves.
    pub photo_nodes: Vec<NodeId>,
    /// Lens and poses.
    pub cameras: NodeId,
    /// How they were found, where the photographs gave them.
    pub calibration: Option<CalibrationNodes>,
    /// The extracted root voxels.
    pub extract: NodeId,
    /// Roots, traits and their files.
    pub traits: NodeId,
    /// The OME-Zarr image.
    pub volume: NodeId,
    /// Its labels.
    pub labels: NodeId,
    /// One overlay per photograph.
    pub overlays: Vec<NodeId>,
    /// Pictures of a slice, where the study asks for one.
    pub slices: Option<NodeId>,
    /// The score, where the truth is known.
    pub score: Option<NodeId>,
}

impl StudyNodes {
    /// The nodes of the numbers: what a point of a sweep is compared by.
    pub fn numbers(&self) -> Vec<NodeId> {
        [self.cameras, self.extract].into_iter().chain(self.slices).chain(self.score).collect()
    }

    /// All nodes that a run brings up to date.
    pub fn targets(&self) -> Vec<NodeId> {
        let mut targets = vec![self.cameras, self.extract, self.traits, self.volume, self.labels];
        targets.extend(&self.overlays);
        targets.extend(self.slices);
        targets.extend(self.score);
        targets.extend(self.calibration.as_ref().map(|c| c.pictures));
        targets
    }
}

/// Adds the nodes that make of every undistorted photograph its contrast along the roots' colour axis.
fn features(graph: &mut Graph, s: &Settings, seen: &[(&String, NodeId, NodeId)]) -> Vec<NodeId> {
    let contrasts: Vec<NodeId> = seen
        .iter()
        .map(|&(name, photo, camera)| {
            let stage = Contrast { tank: s.tank.clone(), params: s.contrast };
            graph.add(&format!("contrast/{name}"), stage, &[("photo", &[photo]), ("camera", &[camera])])
        })
        .collect();
    let axis = graph.add("axis", Axis {}, &[("contrasts", &contrasts)]);
    let feature = |(&(name, ..), contrast): (&(&String, NodeId, NodeId), NodeId)| {
        graph.add(&format!("feature/{name}"), Feature {}, &[("contrast", &[contrast]), ("axis", &[axis])])
    };
    seen.iter().zip(contrasts).map(feature).collect()
}

/// Adds the study to the graph.
///
/// # Errors
/// Where two photographs have one name.
pub fn add(graph: &mut Graph, s: &Settings) -> Result<StudyNodes> {
    let (photos, files, cameras, calibration, truth) = match &s.source {
        Source::Files(paths) => {
            let names: Vec<String> = paths
                .iter()
                .map(|p| p.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default())
                .collect();
            if let Some(twice) = names.iter().enumerate().find_map(|(n, a)| names[..n].contains(a).then_some(a)) {
                return Err(Error::usage(format!("photos.images finds two photographs named `{twice}`"))
                    .help("give each photograph of a study a name of its own"));
            }
            let files: Vec<NodeId> =
                names.iter().zip(paths).map(|(n, p)| graph.file(&format!("photo/{n}"), p)).collect();
            let (cameras, calibration) = match (s.cameras.source, s.cameras.frame) {
                (CameraSource::File, Frame::Tank) => {
                    let parts = camera_file(graph, s)?;
                    (graph.add("cameras", Cameras { tank: s.tank.clone() }, &[("file", &parts)]), None)
                }
                (CameraSource::File, Frame::Free) => {
                    let parts = camera_file(graph, s)?;
                    registered(graph, s, &names, &files, Some(&parts))
                }
                (CameraSource::Sfm, _) => registered(graph, s, &names, &files, None),
            };
            let truth = s.truth.roots.as_ref().map(|r| graph.file("truth", s.input_dir.join(r)));
            (names, files, cameras, calibration, truth)
        }
        Source::Simulated(simulate) => {
            let capture = graph.add(
                "capture",
                Capture {
                    tank: s.tank.clone(),
                    growth: simulate.growth.clone(),
                    capture: simulate.capture.clone(),
                    seed: simulate.seed,
                },
                &[],
            );
            let names: Vec<String> = (0..simulate.capture.views).map(|n| photo_name(&simulate.capture, n)).collect();
            let files: Vec<NodeId> = (0..simulate.capture.views)
                .map(|view| {
                    let stage = Photograph {
                        tank: s.tank.clone(),
                        capture: simulate.capture.clone(),
                        seed: simulate.seed,
                        view,
                    };
                    graph.add(&format!("photograph/{}", names[view]), stage, &[("capture", &[capture])])
                })
                .collect();
            let (cameras, calibration) = match s.cameras.source {
                CameraSource::File => (capture, None),
                CameraSource::Sfm => registered(graph, s, &names, &files, None),
            };
            (names, files, cameras, calibration, Some(capture))
        }
    };

    let is_virtual = s.render.is_virtual(&s.grid, photos.len());
    let mut seen = Vec::new();
    for (name, &photo) in photos.iter().zip(&files) {
        let camera = graph.add(&format!("camera/{name}"), Camera { photo: name.clone() }, &[("cameras", &[cameras])]);
        let undistorted =
            graph.add(&format!("undistort/{name}"), Undistort {}, &[("photo", &[photo]), ("lens", &[cameras])]);
        seen.push((name, undistorted, camera));
    }
    let rendered = if s.contrast.enabled { features(graph, s, &seen) } else { seen.iter().map(|v| v.1).collect() };
    let views: Vec<NodeId> = seen
        .iter()
        .zip(rendered)
        .map(|(&(name, _, camera), photo)| rendered_view(graph, s, name, photo, camera, is_virtual))
        .collect();
    let merged = graph.add("merge", Merge { params: s.merge.clone() }, &[("views", &views)]);
    let rootness = Rootness { spacing_mm: s.grid.spacing_mm, params: s.rootness.clone() };
    let rootness = graph.add("rootness", rootness, &[("merged", &[merged])]);
    let ridges = graph.add("suppress", Suppress { params: s.suppress }, &[("rootness", &[rootness])]);
    let extract = graph.add("extract", Extract { grid: s.grid, params: s.extract }, &[("ridges", &[ridges])]);
    let traits = roots(graph, s, &files, &seen, [ridges, extract, rootness]);
    let overlays = seen
        .into_iter()
        .map(|(name, photo, camera)| {
            graph.add(
                &format!("overlay/{name}"),
                Overlay { tank: s.tank.clone(), mark_radius_px: s.overlay.mark_radius },
                &[("photo", &[photo]), ("camera", &[camera]), ("roots", &[extract])],
            )
        })
        .collect();
    let volume = graph.add("volume", Volume { grid: s.grid }, &[("merged", &[merged]), ("rootness", &[rootness])]);
    let labels = graph.add("labels", Labels { grid: s.grid }, &[("roots", &[extract])]);
    let slices = s.report.slice.map(|depth_mm| Slices::at(depth_mm, &s.grid)).transpose()?;
    let slices = slices.map(|stage| graph.add("slices", stage, &[("merged", &[merged]), ("rootness", &[rootness])]));
    let score = truth.map(|truth| {
        let stage = Evaluate {
            tank: s.tank.clone(),
            params: ScoreParams {
                z_min_mm: s.truth.z_min,
                z_max_mm: s.truth.z_max.unwrap_or(s.grid.spacing_mm * s.grid.shape[0] as f64 - 2.0),
                free_azimuth: calibration.is_some(),
                ..ScoreParams::default()
            },
        };
        graph.add("evaluate", stage, &[("roots", &[extract]), ("truth", &[truth])])
    });
    Ok(StudyNodes {
        photos,
        photo_nodes: files,
        cameras,
        calibration,
        extract,
        traits,
        volume,
        labels,
        overlays,
        slices,
        score,
    })
}

/// From ridges to roots, their diameters, their traits.
fn roots(
    graph: &mut Graph,
    s: &Settings,
    photos: &[NodeId],
    seen: &[(&String, NodeId, NodeId)],
    [ridges, extract, rootness]: [NodeId; 3],
) -> NodeId {
    let trace = Trace { grid: s.grid, sigma_mm: s.rootness.sigma.clone(), params: s.trace.clone() };
    let ports = [("ridges", &[ridges][..]), ("roots", &[extract]), ("rootness", &[rootness])];
    let traced = graph.add("trace", trace, &ports);
    let measured = if s.diameters.enabled {
        let cameras: Vec<NodeId> = seen.iter().map(|v| v.2).collect();
        let diameters = Diameters { tank: s.tank.clone(), params: s.diameters.clone() };
        graph.add("diameters", diameters, &[("system", &[traced][..]), ("photos", photos), ("cameras", &cameras)])
    } else {
        traced
    };
    let traits = Traits { water_level_mm: s.tank.water_level_mm, study: s.name.clone(), params: s.traits.clone() };
    graph.add("traits", traits, &[("system", &[measured])])
}

/// The parts of the camera file.
fn camera_file(graph: &mut Graph, s: &Settings) -> Result<Vec<NodeId>> {
    let label = |path: &Path| match path.file_name() {
        Some(name) => format!("cameras-file/{}", name.to_string_lossy()),
        None => "cameras-file".to_owned(),
    };
    Ok(s.cameras.files(&s.input_dir)?.iter().map(|path| graph.file(&label(path), path)).collect())
}

/// The cameras in the tank frame that the photographs give: alone, or with the poses of a camera file.  Paper 2.2.
fn registered(
    graph: &mut Graph,
    s: &Settings,
    names: &[String],
    files: &[NodeId],
    known: Option<&[NodeId]>,
) -> (NodeId, Option<CalibrationNodes>) {
    let given: Vec<NodeId> = s.mask_picture.iter().map(|path| graph.file("mask-file", path)).collect();
    let mask = graph.add("sfm-mask", SfmMask { params: s.mask.clone() }, &[("photos", files), ("given", &given)]);
    let photos = names.to_vec();
    let sparse = match known {
        Some(parts) => {
            let stage = SfmKnown { photos: photos.clone(), params: s.sfm.clone() };
            graph.add("sfm-known", stage, &[("file", parts), ("photos", files), ("mask", &[mask])])
        }
        None => {
            let stage = Sfm { photos: photos.clone(), program: installed(), params: s.sfm.clone() };
            graph.add("sfm", stage, &[("photos", files), ("mask", &[mask])])
        }
    };
    let pose = Pose { tank: s.tank.clone(), photos: photos.clone(), params: s.pose.clone() };
    let pose = graph.add("pose", pose, &[("sparse", &[sparse]), ("photos", files)]);
    let pictures = PosePictures { tank: s.tank.clone(), print_thickness_mm: s.pose.print_thickness_mm, photos };
    let pictures = graph.add("pose-pictures", pictures, &[("pose", &[pose]), ("photos", files)]);
    (pose, Some(CalibrationNodes { mask, pose, pictures }))
}

/// One view's volume, by the method of the study.
fn rendered_view(
    graph: &mut Graph,
    s: &Settings,
    name: &str,
    photo: NodeId,
    camera: NodeId,
    is_virtual: bool,
) -> NodeId {
    let (tank, grid, sizes) = (s.tank.clone(), s.grid, s.render.sizes());
    let label = format!("render/{name}");
    match s.render.method {
        Method::Exact => {
            let (stage, ports) =
                (Render { tank, grid, options: s.render.options() }, [("photo", &[photo][..]), ("camera", &[camera])]);
            if is_virtual { graph.add_virtual(&label, stage, &ports) } else { graph.add(&label, stage, &ports) }
        }
        Method::PatchRbf => {
            let lattice = Lattice { tank: tank.clone(), grid, sizes };
            let lattice = graph.add(&format!("lattice/{name}"), lattice, &[("camera", &[camera])]);
            let ports = [("photo", &[photo][..]), ("camera", &[camera]), ("lattice", &[lattice])];
            let stage = RenderPatch { tank, grid, sizes };
            if is_virtual { graph.add_virtual(&label, stage, &ports) } else { graph.add(&label, stage, &ports) }
        }
    }
}
