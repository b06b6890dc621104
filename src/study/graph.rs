//! A study's settings as a graph of nodes: what is computed from what.

use super::evident::{self, Evident};
use super::inputs::{CameraSource, Frame};
use super::nodes::{CalibrationNodes, CorrectionNodes, StudyNodes};
use super::reconstruct::{Photographs, Reconstruction, measured, reconstruct};
use super::render::Method;
use super::settings::{Settings, Source};
use super::spread::spread;
use crate::error::{Error, Result};
use crate::evaluation::ScoreParams;
use crate::flow::{Graph, NodeId};
use crate::report::page::preview_px;
use crate::stages::camera::Camera;
use crate::stages::cameras::Cameras;
use crate::stages::capture::{Capture, photo_name};
use crate::stages::corrections::Corrections;
use crate::stages::evaluate::Evaluate;
use crate::stages::evaluate_cameras::EvaluateCameras;
use crate::stages::evaluate_roots::EvaluateRoots;
use crate::stages::labels::Labels;
use crate::stages::lattice::Lattice;
use crate::stages::misjudge::Misjudge;
use crate::stages::overlay::Overlay;
use crate::stages::photograph::Photograph;
use crate::stages::pose::Pose;
use crate::stages::pose_pictures::PosePictures;
use crate::stages::preview::Preview;
use crate::stages::render::Render;
use crate::stages::render_patch::RenderPatch;
use crate::stages::root_lines::RootLines;
use crate::stages::root_overlay::RootOverlay;
use crate::stages::sfm::{Sfm, installed};
use crate::stages::sfm_known::SfmKnown;
use crate::stages::sfm_mask::SfmMask;
use crate::stages::sight::Sight;
use crate::stages::slices::Slices;
use crate::stages::survey::Survey;
use crate::stages::undistort::Undistort;
use crate::stages::volume::Volume;
use std::collections::BTreeMap;
use std::path::Path;

/// Adds the study to the graph.
///
/// # Errors
/// Where two photographs have one name but for its ending.
pub fn add(graph: &mut Graph, s: &Settings) -> Result<StudyNodes> {
    let mut survey_node = None;
    let (photos, files, cameras, calibration, truth) = match &s.source {
        Source::Files(paths) => {
            let names: Vec<String> = paths
                .iter()
                .map(|p| p.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default())
                .collect();
            check_names(&names)?;
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
            let has_camera_file = s.cameras.source == CameraSource::File;
            let survey = Survey { photos: names.clone(), has_camera_file };
            survey_node = Some(graph.add("survey", survey, &[("photos", &files)]));
            (names, files, cameras, calibration, truth)
        }
        Source::Simulated(simulate) => {
            let capture = graph.add(
                "capture",
                Capture {
                    tank: s.true_tank.clone(),
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
                        tank: s.true_tank.clone(),
                        capture: simulate.capture.clone(),
                        seed: simulate.seed,
                        view,
                    };
                    graph.add(&format!("photograph/{}", names[view]), stage, &[("capture", &[capture])])
                })
                .collect();
            let (cameras, calibration) = match s.cameras.source {
                CameraSource::File if simulate.misjudge.is_none() => (capture, None),
                CameraSource::File => {
                    let stage = Misjudge { params: simulate.misjudge, seed: simulate.seed };
                    (graph.add("misjudge", stage, &[("cameras", &[capture])]), None)
                }
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
            graph.add(&format!("undistort/{name}"), Undistort {}, &[("photo", &[photo]), ("camera", &[camera])]);
        seen.push((name, undistorted, camera));
    }
    let Evident { rendered, background, pictures: evidence_pictures } = evident::add(graph, s, &seen);
    let evidence: &[NodeId] = if s.contrast.enabled { &rendered } else { &[] };
    let views: Vec<NodeId> = seen
        .iter()
        .zip(&rendered)
        .map(|(&(name, _, camera), &photo)| rendered_view(graph, s, name, photo, camera, is_virtual))
        .collect();
    let all = Photographs { files: &files, seen: &seen, views: &views, background: &background, evidence };
    let Reconstruction { merged, rootness, extract, system, traits } = reconstruct(graph, s, &all, "");
    let spread = spread(graph, s, &all, traits)?;
    let as_traced = (system, traits);
    let corrections = s.corrections_file.as_ref().map(|path| {
        let file = graph.file("corrections-file", path);
        let stage =
            Corrections { tank: s.tank.clone(), grid: s.grid, photos: photos.clone(), params: s.corrections.params() };
        let cameras: Vec<NodeId> = seen.iter().map(|v| v.2).collect();
        let ports = [("system", &[system][..]), ("file", &[file]), ("cameras", &cameras), ("rootness", &[rootness])];
        graph.add("corrections", stage, &ports)
    });
    let system = corrections.unwrap_or(system);
    let traits = corrections.map_or(traits, |corrected| measured(graph, s, corrected, "traits/corrected"));
    let corrections =
        corrections.map(|node| CorrectionNodes { corrections: node, traced: as_traced.0, traits: as_traced.1 });
    let root_overlays = seen
        .iter()
        .map(|&(name, photo, camera)| {
            let stage = RootOverlay { tank: s.tank.clone(), line_radius_px: s.overlay.mark_radius };
            let ports = [("photo", &[photo][..]), ("camera", &[camera]), ("system", &[system])];
            graph.add(&format!("root-overlay/{name}"), stage, &ports)
        })
        .collect();
    let longest_px = preview_px(seen.len());
    let (previews, root_lines) = seen
        .iter()
        .map(|&(name, photo, camera)| {
            let lines = RootLines { tank: s.tank.clone() };
            let ports = [("camera", &[camera][..]), ("system", &[system])];
            (
                graph.add(&format!("preview/{name}"), Preview { longest_px }, &[("photo", &[photo])]),
                graph.add(&format!("root-lines/{name}"), lines, &ports),
            )
        })
        .unzip();
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
    let labels = graph.add("labels", Labels { grid: s.grid }, &[("system", &[system])]);
    let slices = s.report.slice.map(|depth_mm| Slices::at(depth_mm, &s.grid)).transpose()?;
    let slices = slices.map(|stage| graph.add("slices", stage, &[("merged", &[merged]), ("rootness", &[rootness])]));
    let of_truth = truth.as_slice();
    let sight = Sight { grid: s.grid, tank: s.true_tank.clone(), min_views: s.merge.min_views };
    let sight = graph.add("sight", sight, &[("merged", &[merged][..]), ("truth", of_truth)]);
    let params = ScoreParams {
        z_min_mm: s.truth.z_min,
        z_max_mm: s.truth.z_max.unwrap_or(s.grid.spacing_mm * s.grid.shape[0] as f64 - 2.0),
        free_azimuth: calibration.is_some(),
        ..ScoreParams::default()
    };
    let score = truth.map(|truth| {
        let stage = Evaluate { tank: s.true_tank.clone(), params: params.clone() };
        graph.add("evaluate", stage, &[("roots", &[extract]), ("truth", &[truth])])
    });
    let roots_score = truth.map(|truth| {
        let stage = EvaluateRoots { tank: s.true_tank.clone(), params };
        graph.add("evaluate-roots", stage, &[("system", &[system]), ("truth", &[truth])])
    });
    // Two cameras fix no frame.
    let simulated = matches!(s.source, Source::Simulated(_)) && photos.len() > 2;
    let camera_errors = truth.filter(|_| simulated).map(|truth| {
        let stage = EvaluateCameras { true_tank: s.true_tank.clone(), tank: s.tank.clone() };
        graph.add("evaluate-cameras", stage, &[("cameras", &[cameras]), ("truth", &[truth])])
    });
    Ok(StudyNodes {
        photos,
        photo_nodes: files,
        survey: survey_node,
        cameras,
        calibration,
        extract,
        system,
        traits,
        corrections,
        volume,
        labels,
        sight,
        overlays,
        root_overlays,
        previews,
        root_lines,
        spread,
        slices,
        evidence_pictures,
        score,
        roots_score,
        camera_errors,
    })
}

/// Fails where two photographs would have one name in the results.
fn check_names(names: &[String]) -> Result<()> {
    let stem = |name: &str| name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned();
    let mut known: BTreeMap<String, &String> = BTreeMap::new();
    for name in names {
        if let Some(first) = known.insert(stem(name), name) {
            let message = format!("photos.images finds two photographs named `{}`: `{first}` and `{name}`", stem(name));
            return Err(Error::usage(message).help(
                "give each photograph of a study a name of its own; of two formats of one photograph, let the pattern name one",
            ));
        }
    }
    Ok(())
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
    let lens: Vec<NodeId> = s.cameras.lens.iter().map(|path| graph.file("lens-file", s.input_dir.join(path))).collect();
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
            graph.add("sfm", stage, &[("photos", files), ("mask", &[mask]), ("lens", &lens)])
        }
    };
    let pose = Pose { tank: s.tank.clone(), photos: photos.clone(), params: s.pose.clone() };
    let pose = graph.add("pose", pose, &[("sparse", &[sparse]), ("photos", files), ("lens", &lens)]);
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
