//! The results folder: what people look at and what other programs read, copied out of the store.
//!
//! `results/<name>/` is written beside itself and swapped in by rename, so that it never mixes two runs;
//! `study.lock` says which nodes it was made from, and a folder whose lock is equal is left alone.

use super::graph::StudyNodes;
use super::lock;
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId, Report};
use crate::formats::{NamedView, cameras_json};
use crate::report::page::Page;
use crate::stages::extract;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the lock file in a results folder.
pub const LOCK: &str = "study.lock";

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

/// Brings `results_dir/<name>` up to date and tells its path, and whether it had to be written.
///
/// # Errors
/// Where the folder cannot be written; the old results then stay as they were.
pub fn write(
    results_dir: &Path,
    settings: &Settings,
    graph: &Graph,
    nodes: &StudyNodes,
    report: &Report,
) -> Result<(PathBuf, bool)> {
    let target = results_dir.join(&settings.name);
    let lock = lock::text(settings, graph, report)?;
    if fs::read_to_string(target.join(LOCK)).is_ok_and(|old| old == lock) {
        return Ok((target, false));
    }
    fs::create_dir_all(results_dir)
        .map_err(|e| Error::io("create", results_dir, e).help("name another folder with --results"))?;
    let fresh = tempfile::Builder::new()
        .prefix(&format!(".{}-", settings.name))
        .tempdir_in(results_dir)
        .map_err(|e| Error::io("write into", results_dir, e).help("name another folder with --results"))?;
    let to = fresh.path();
    let put = |node: NodeId, member: &str, name: &str| copy(&report.artefact(node)?.path(member)?, &to.join(name));
    put(nodes.extract, "root_voxels.csv", "root_voxels.csv")?;
    for name in ROOT_FILES {
        put(nodes.traits, name, name)?;
    }
    let rsml = "roots.rsml";
    if report.artefact(nodes.traits)?.has(rsml) {
        put(nodes.traits, rsml, rsml)?;
    }
    put(nodes.volume, "volume.ome.zarr", "volume.ome.zarr")?;
    put(nodes.labels, "labels", "volume.ome.zarr/labels")?;
    for (photo, &overlay) in nodes.photos.iter().zip(&nodes.overlays) {
        put(overlay, "overlay.jpg", &overlay_path(photo))?;
    }
    if let Some(score) = nodes.score {
        put(score, "score", "score.json")?;
    }
    let views: Vec<NamedView> = report.artefact(nodes.cameras)?.json("cameras")?;
    let cameras_path = to.join("cameras.json");
    fs::write(&cameras_path, cameras_json::write(&views)?).map_err(|e| Error::io("write", &cameras_path, e))?;
    let page = page(settings, graph, nodes, report)?;
    let page_path = to.join("report.html");
    fs::write(&page_path, page).map_err(|e| Error::io("write", &page_path, e))?;
    let lock_path = to.join(LOCK);
    fs::write(&lock_path, lock).map_err(|e| Error::io("write", &lock_path, e))?;
    swap_in(fresh, &target)?;
    Ok((target, true))
}

/// Where the overlay of a photograph lies in the results.
fn overlay_path(photo: &str) -> String {
    let stem = Path::new(photo).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    format!("overlays/{stem}.jpg")
}

/// The report's page.
fn page(settings: &Settings, graph: &Graph, nodes: &StudyNodes, report: &Report) -> Result<String> {
    let roots: Vec<_> =
        extract::read(&report.artefact(nodes.extract)?)?.iter().map(|r| (r.point_mm, r.component)).collect();
    let score = nodes.score.map(|n| report.artefact(n)?.json("score")).transpose()?;
    let (mut parameters, mut warnings) = (BTreeMap::new(), Vec::new());
    for node in graph.nodes() {
        let Some(manifest) = report.manifest(node) else { continue };
        warnings.extend(manifest.warnings.iter().map(|w| format!("{}: {w}", graph.label(node))));
        parameters.entry(manifest.stage.clone()).or_insert_with(|| format!("{:#}", manifest.params));
    }
    let overlays: Vec<String> = nodes.photos.iter().map(|p| overlay_path(p)).collect();
    Ok(Page {
        name: &settings.name,
        tank: &settings.tank,
        grid: &settings.grid,
        roots: &roots,
        score: score.as_ref(),
        settings: &parameters.into_iter().collect::<Vec<_>>(),
        warnings: &warnings,
        overlays: &overlays,
    }
    .html())
}

/// Puts the fresh folder in the target's place.
fn swap_in(fresh: tempfile::TempDir, target: &Path) -> Result<()> {
    let fresh = fresh.keep();
    let aside = fresh.with_extension("old");
    let had = target.exists();
    let swapped = (if had { fs::rename(target, &aside) } else { Ok(()) }).and_then(|()| fs::rename(&fresh, target));
    if let Err(e) = swapped {
        // Back to where we were.
        if had && !target.exists() {
            let _ = fs::rename(&aside, target);
        }
        let _ = fs::remove_dir_all(&fresh);
        return Err(Error::io("replace", target, e).help("is a program using the results? close it and run again"));
    }
    if had {
        let _ = fs::remove_dir_all(&aside);
    }
    Ok(())
}

/// Copies a file or a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to).map_err(|e| Error::io("create", to, e))?;
        for entry in fs::read_dir(from).map_err(|e| Error::io("read", from, e))? {
            let entry = entry.map_err(|e| Error::io("read", from, e))?;
            copy(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    }
    fs::copy(from, to).map(|_| ()).map_err(|e| Error::io("write", to, e))
}
