//! The results of one study: what people look at and what other programs read, copied out of the store.

use super::batch::{Batch, Study};
use super::command;
use super::crate_metadata::Made;
use super::folder::Fresh;
use super::lock::Lock;
use super::nodes::StudyNodes;
use super::page::{self, Commands};
use crate::calibration::Registration;
use crate::error::Result;
use crate::flow::Report;
use crate::formats::{NamedView, cameras_json};
use crate::stages::evidence_pictures;
use crate::stages::pose_pictures::outline_name;
use std::path::Path;

/// The files of the root system that always are; the RSML needs a root.
const ROOT_FILES: [&str; 9] = [
    "roots.csv",
    "traits.csv",
    "per_root.csv",
    "depth_profile.csv",
    "repairs.csv",
    "roots.ply",
    "centrelines.ply",
    "roots.glb",
    "roots.swc",
];

/// Brings `results_dir/<name>` up to date and tells whether it had to be written; `made_by` is the command that asks for it.
///
/// # Errors
/// Where the folder cannot be written; the old results then stay as they were.
pub fn write(results_dir: &Path, batch: &Batch, study: &Study, report: &Report, made_by: &str) -> Result<bool> {
    let lock = Lock::of(batch, study, report, &results_dir.join(&study.name))?;
    let Some(fresh) = Fresh::begin(results_dir, &lock)? else { return Ok(false) };
    for point in &study.points {
        let (_, nodes) = point.planned.as_ref().map_err(Clone::clone)?;
        put_numbers(&fresh, "", nodes, report)?;
        put_roots(&fresh, "", nodes, report)?;
        let shown = nodes.shown()?;
        fresh.put(report, shown.volume, "volume.ome.zarr", "volume.ome.zarr")?;
        fresh.put(report, shown.labels, "labels", "volume.ome.zarr/labels")?;
        for ((photo, &overlay), &roots) in nodes.photos.iter().zip(&shown.overlays).zip(&shown.root_overlays) {
            fresh.put(report, overlay, "overlay.jpg", &overlay_path(photo, ""))?;
            fresh.put(report, roots, "roots.jpg", &overlay_path(photo, "-roots"))?;
            fresh.put(report, roots, "orders.jpg", &overlay_path(photo, "-orders"))?;
        }
        for (photo, &pictures) in nodes.photos.iter().zip(shown.evidence_pictures.iter()) {
            for kind in evidence_pictures::KINDS {
                let to = format!("evidence/{}-{kind}.png", stem(photo));
                fresh.put(report, pictures, &format!("{kind}.png"), &to)?;
            }
        }
        if let Some(spread) = shown.spread {
            fresh.put(report, spread, "trait_spread.csv", "trait_spread.csv")?;
        }
        put_calibration(&fresh, nodes, report)?;
        let again = command::rerun(results_dir, &study.name);
        let page = page::html(point, &batch.graph, report, &lock, &Commands { made_by, again: &again })?;
        fresh.write("report.html", page.as_bytes())?;
    }
    fresh.publish(&lock, &Made::of(batch, study, report))?;
    Ok(true)
}

/// Puts the files of the traced roots under `prefix`.
///
/// # Errors
/// Where something is missing or cannot be copied.
pub fn put_roots(fresh: &Fresh, prefix: &str, nodes: &StudyNodes, report: &Report) -> Result<()> {
    if let Some(score) = nodes.roots_score {
        fresh.put(report, score, "judgement", &format!("{prefix}roots_score.json"))?;
    }
    let rsml = report.artefact(nodes.traits)?.has("roots.rsml").then_some("roots.rsml");
    if let Some(c) = &nodes.corrections {
        fresh.put(report, c.corrections, "corrections.csv", &format!("{prefix}corrections.csv"))?;
        fresh.put(report, c.traits, "traits.csv", &format!("{prefix}traits_traced.csv"))?;
    }
    for name in ROOT_FILES.into_iter().chain(rsml) {
        fresh.put(report, nodes.traits, name, &format!("{prefix}{name}"))?;
    }
    Ok(())
}

/// Puts what a point of a sweep has too, the numbers, under `prefix`.
///
/// # Errors
/// Where something is missing or cannot be copied.
pub fn put_numbers(fresh: &Fresh, prefix: &str, nodes: &StudyNodes, report: &Report) -> Result<()> {
    fresh.put(report, nodes.extract, "root_voxels.csv", &format!("{prefix}root_voxels.csv"))?;
    if let Some(score) = nodes.score {
        fresh.put(report, score, "score", &format!("{prefix}score.json"))?;
    }
    if let Some(errors) = nodes.camera_errors {
        fresh.put(report, errors, "errors", &format!("{prefix}camera_errors.json"))?;
    }
    if let Some(slices) = nodes.slices {
        for name in ["merged.png", "coverage.png", "rootness.png"] {
            fresh.put(report, slices, name, &format!("{prefix}slices/{name}"))?;
        }
    }
    let views: Vec<NamedView> = report.artefact(nodes.cameras)?.json("cameras")?;
    fresh.write(&format!("{prefix}cameras.json"), cameras_json::write(&views)?.as_bytes())
}

/// Puts what shows how the cameras were found, where the photographs gave them.
fn put_calibration(fresh: &Fresh, nodes: &StudyNodes, report: &Report) -> Result<()> {
    let Some(c) = &nodes.calibration else { return Ok(()) };
    for name in ["mask.png", "deviation.png"] {
        fresh.put(report, c.mask, name, &format!("calibration/{name}"))?;
    }
    fresh.put(report, c.pictures, "ring.svg", "calibration/ring.svg")?;
    for photo in nodes.photos.iter() {
        let name = outline_name(photo);
        fresh.put(report, c.pictures, &name, &format!("calibration/{name}"))?;
    }
    let registration: Registration = report.artefact(c.pose)?.json("registration")?;
    let lens = registration.views.first().map(|v| v.lens);
    let all = serde_json::json!({ "lens": lens, "quality": registration.quality, "warnings": registration.warnings });
    fresh.write("calibration/calibration.json", format!("{all:#}\n").as_bytes())
}

/// Where an overlay of a photograph lies in the results.
fn overlay_path(photo: &str, kind: &str) -> String {
    format!("overlays/{}{kind}.jpg", stem(photo))
}

/// A photograph's name without its ending.
fn stem(photo: &str) -> String {
    Path::new(photo).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default()
}
