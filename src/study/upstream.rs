//! From photographs to the views' volumes: the nodes that no setting of what is measured changes.

use super::evident::{self, Evident, Seen};
use super::inputs::{CameraSource, Frame};
use super::nodes::CalibrationNodes;
use super::reconstruct::Photographs;
use super::render::Method;
use super::settings::{Settings, Source};
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId};
use crate::stages::camera::Camera;
use crate::stages::cameras::Cameras;
use crate::stages::capture::{Capture, photo_name};
use crate::stages::lattice::Lattice;
use crate::stages::misjudge::Misjudge;
use crate::stages::photograph::Photograph;
use crate::stages::pose::Pose;
use crate::stages::pose_pictures::PosePictures;
use crate::stages::render::Render;
use crate::stages::render_patch::RenderPatch;
use crate::stages::sfm::{Sfm, installed};
use crate::stages::sfm_known::SfmKnown;
use crate::stages::sfm_mask::SfmMask;
use crate::stages::survey::Survey;
use crate::stages::undistort::Undistort;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// The photographs of a study and what becomes of each.
pub(super) struct Upstream {
    pub names: Arc<[String]>,
    pub files: Arc<[NodeId]>,
    pub survey: Option<NodeId>,
    pub cameras: NodeId,
    pub calibration: Option<CalibrationNodes>,
    pub truth: Option<NodeId>,
    /// Of each photograph its name, undistorted picture and camera.
    pub seen: Vec<Seen>,
    /// The cameras alone.
    pub seen_by: Vec<NodeId>,
    pub views: Vec<NodeId>,
    /// What is behind the roots, where it is learned.
    pub background: Vec<NodeId>,
    /// Shares of root, where they are.
    pub evidence: Vec<NodeId>,
    pub evidence_pictures: Arc<[NodeId]>,
}

impl Upstream {
    /// Adds them to the graph.
    ///
    /// # Errors
    /// Where two photographs have one name but for its ending.
    pub fn add(graph: &mut Graph, s: &Settings) -> Result<Self> {
        let mut survey = None;
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
                let stage = Survey { photos: names.clone(), has_camera_file };
                survey = Some(graph.add("survey", stage, &[("photos", &files)]));
                (names, files, cameras, calibration, truth)
            }
            Source::Simulated(simulate) => {
                let capture = graph.add(
                    "capture",
                    Capture {
                        tank: s.true_tank.clone(),
                        growth: simulate.growth.clone(),
                        age: simulate.age.clone(),
                        day: simulate.day.clone(),
                        capture: simulate.capture.clone(),
                        seed: simulate.seed,
                    },
                    &[],
                );
                let names: Vec<String> =
                    (0..simulate.capture.views).map(|n| photo_name(&simulate.capture, n)).collect();
                let files: Vec<NodeId> = (0..simulate.capture.views)
                    .map(|view| {
                        let stage = Photograph {
                            tank: s.true_tank.clone(),
                            capture: simulate.capture.clone(),
                            seed: simulate.day.seed.unwrap_or(simulate.seed),
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
            let camera =
                graph.add(&format!("camera/{name}"), Camera { photo: name.clone() }, &[("cameras", &[cameras])]);
            let undistorted =
                graph.add(&format!("undistort/{name}"), Undistort {}, &[("photo", &[photo]), ("camera", &[camera])]);
            seen.push((name.clone(), undistorted, camera));
        }
        let Evident { rendered, background, pictures: evidence_pictures } = evident::add(graph, s, &seen);
        let views: Vec<NodeId> = seen
            .iter()
            .zip(&rendered)
            .map(|((name, _, camera), &photo)| rendered_view(graph, s, name, photo, *camera, is_virtual))
            .collect();
        let evidence = if s.contrast.enabled { rendered } else { Vec::new() };
        let seen_by = seen.iter().map(|v| v.2).collect();
        let (names, files) = (photos.into(), files.into());
        let evidence_pictures = evidence_pictures.into();
        Ok(Self {
            names,
            files,
            survey,
            cameras,
            calibration,
            truth,
            seen,
            seen_by,
            views,
            background,
            evidence,
            evidence_pictures,
        })
    }

    /// All photographs, to reconstruct from.
    pub fn all(&self) -> Photographs<'_> {
        Photographs {
            files: &self.files,
            cameras: &self.seen_by,
            views: &self.views,
            background: &self.background,
            evidence: &self.evidence,
        }
    }
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
