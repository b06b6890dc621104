//! The results of one study: what people look at and what other programs read, copied out of the store.

use super::batch::{Batch, Study};
use super::crate_metadata::Made;
use super::folder::Fresh;
use super::lock::Lock;
use super::nodes::StudyNodes;
use super::settings::Settings;
use crate::calibration::Registration;
use crate::error::Result;
use crate::evaluation::{Band, Sight};
use crate::flow::{Graph, Report};
use crate::formats::{NamedView, cameras_json};
use crate::report::page::Page;
use crate::stages::extract;
use crate::stages::pose_pictures::outline_name;
use std::collections::BTreeMap;
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

/// Warnings of one stage that the page shows.
const MOST_WARNINGS: usize = 3;

/// Brings `results_dir/<name>` up to date and tells whether it had to be written.
///
/// # Errors
/// Where the folder cannot be written; the old results then stay as they were.
pub fn write(results_dir: &Path, batch: &Batch, study: &Study, report: &Report) -> Result<bool> {
    let lock = Lock::of(batch, study, report, &results_dir.join(&study.name))?;
    let Some(fresh) = Fresh::begin(results_dir, &lock)? else { return Ok(false) };
    for point in &study.points {
        let (settings, nodes) = point.planned.as_ref().map_err(Clone::clone)?;
        put_numbers(&fresh, "", nodes, report)?;
        put_roots(&fresh, "", nodes, report)?;
        fresh.put(report, nodes.volume, "volume.ome.zarr", "volume.ome.zarr")?;
        fresh.put(report, nodes.labels, "labels", "volume.ome.zarr/labels")?;
        for ((photo, &overlay), &roots) in nodes.photos.iter().zip(&nodes.overlays).zip(&nodes.root_overlays) {
            fresh.put(report, overlay, "overlay.jpg", &overlay_path(photo, ""))?;
            fresh.put(report, roots, "roots.jpg", &overlay_path(photo, "-roots"))?;
            fresh.put(report, roots, "orders.jpg", &overlay_path(photo, "-orders"))?;
        }
        if let Some(spread) = nodes.spread {
            fresh.put(report, spread, "trait_spread.csv", "trait_spread.csv")?;
        }
        put_calibration(&fresh, nodes, report)?;
        fresh.write("report.html", page(settings, &batch.graph, nodes, report)?.as_bytes())?;
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
    for photo in &nodes.photos {
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
    let stem = Path::new(photo).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    format!("overlays/{stem}{kind}.jpg")
}

/// The report's page.
fn page(settings: &Settings, graph: &Graph, nodes: &StudyNodes, report: &Report) -> Result<String> {
    let roots: Vec<_> =
        extract::read(&report.artefact(nodes.extract)?)?.iter().map(|r| (r.point_mm, r.component)).collect();
    let score = nodes.score.map(|n| report.artefact(n)?.json("score")).transpose()?;
    let bands: Option<Vec<Band>> = nodes.score.map(|n| report.artefact(n)?.json("bands")).transpose()?;
    let sight: Vec<Sight> = report.artefact(nodes.sight)?.json("sight")?;
    let (mut parameters, mut warnings) = (BTreeMap::new(), Vec::new());
    let mut warned: BTreeMap<&str, usize> = BTreeMap::new();
    for node in graph.nodes() {
        let Some(manifest) = report.manifest(node) else { continue };
        let count = warned.entry(graph.stage(node).unwrap_or_default()).or_default();
        // What every photograph warns of alike is said for the first ones.
        let shown = manifest.warnings.len().min(MOST_WARNINGS.saturating_sub(*count));
        warnings.extend(manifest.warnings[..shown].iter().map(|w| format!("{}: {w}", graph.label(node))));
        *count += manifest.warnings.len();
        parameters.entry(manifest.stage.clone()).or_insert_with(|| format!("{:#}", manifest.params));
    }
    for (stage, count) in warned.into_iter().filter(|&(_, count)| count > MOST_WARNINGS) {
        warnings.push(format!("{stage}: {} more warnings of this kind", count - MOST_WARNINGS));
    }
    let spread_px = report.artefact(nodes.traits)?.json("spread_px")?;
    let overlays: Vec<String> = nodes.photos.iter().map(|p| overlay_path(p, "")).collect();
    Ok(Page {
        name: &settings.name,
        tank: &settings.tank,
        grid: &settings.grid,
        roots: &roots,
        score: score.as_ref(),
        sight: &sight,
        bands: bands.as_deref().unwrap_or_default(),
        settings: &parameters.into_iter().collect::<Vec<_>>(),
        warnings: &warnings,
        spread_px,
        overlays: &overlays,
    }
    .html())
}
