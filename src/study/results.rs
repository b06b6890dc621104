//! The results folder: what people look at and what other programs read, copied out of the store.
//!
//! `results/<name>/` is written beside itself and swapped in by rename, so that it never mixes two runs;
//! `study.lock` says which nodes it was made from, and a folder whose lock is equal is left alone.

use super::graph::StudyNodes;
use super::lock;
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Graph, NodeId, Report};
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the lock file in a results folder.
pub const LOCK: &str = "study.lock";

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
    put(nodes.volume, "volume.ome.zarr", "volume.ome.zarr")?;
    put(nodes.labels, "labels", "volume.ome.zarr/labels")?;
    for (photo, &overlay) in nodes.photos.iter().zip(&nodes.overlays) {
        let stem = Path::new(photo).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        put(overlay, "overlay.jpg", &format!("overlays/{stem}.jpg"))?;
    }
    if let Some(score) = nodes.score {
        put(score, "score", "score.json")?;
    }
    let lock_path = to.join(LOCK);
    fs::write(&lock_path, lock).map_err(|e| Error::io("write", &lock_path, e))?;
    swap_in(fresh, &target)?;
    Ok((target, true))
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
