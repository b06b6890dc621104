//! The private folder of one process under `tmp/`, and the sweeping of those whose process is gone.
//!
//! The names of whatever lies in `tmp/` begin with the process that made it (`holder.rs`); `tmp/<name>.lock` is touched as long as
//! it lives, for other machines.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use super::files::shared_files;
use super::heart::Heart;
use super::holder::{is_left_over, is_silent, tag};
use crate::error::{Error, Result};

/// Leftovers of processes that another machine ran are swept when these were silent for so long.
const STALE: Duration = Duration::from_secs(3600);

/// The drafts of this process.
pub(super) struct Session {
    folder: PathBuf,
    lock_path: PathBuf,
    heart: Arc<Heart>,
    next: AtomicU64,
}

impl Session {
    /// Makes a folder in `tmp` that no other process uses or sweeps.
    pub(super) fn begin(tmp: &Path, heart: &Arc<Heart>) -> Result<Self> {
        let cannot = |e| {
            Error::io("write to the store in", tmp, e)
                .help("make it writable, or name another folder with `--cache FOLDER` or ROOTVOX_CACHE")
        };
        std::fs::create_dir_all(tmp).map_err(cannot)?;
        let lock = shared_files().prefix(&tag()).suffix(".lock").tempfile_in(tmp).map_err(cannot)?;
        let (_, lock_path) = lock.keep().map_err(|e| cannot(e.error))?;
        heart.add(&lock_path);
        let folder = lock_path.with_extension("");
        std::fs::create_dir(&folder).map_err(cannot)?;
        Ok(Self { folder, lock_path, heart: heart.clone(), next: AtomicU64::new(0) })
    }

    /// A new empty folder for one draft.
    pub(super) fn new_folder(&self) -> Result<PathBuf> {
        let folder = self.folder.join(self.next.fetch_add(1, Ordering::Relaxed).to_string());
        std::fs::create_dir(&folder).map_err(|e| Error::io("create", &folder, e))?;
        Ok(folder)
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.heart.remove(&self.lock_path);
        // What cannot be removed now is swept later.
        let _ = std::fs::remove_dir_all(&self.folder);
        let _ = std::fs::remove_file(&self.lock_path);
    }
}

/// Removes what processes that are gone left in `tmp`; what cannot be removed stays.
pub(super) fn sweep(tmp: &Path) {
    let Ok(entries) = std::fs::read_dir(tmp) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        let is_lock = path.extension().is_some_and(|extension| extension == "lock");
        let is_gone = path.file_name().and_then(|name| name.to_str()).is_some_and(is_left_over);
        // The lock is made before the folder and removed after it: a folder without one is nobody's.
        let is_stray = path.is_dir() && !path.with_extension("lock").exists();
        if is_lock && (is_gone || is_silent(&path, STALE)) {
            let _ = std::fs::remove_dir_all(path.with_extension(""));
            let _ = std::fs::remove_file(&path);
        } else if is_stray {
            let _ = std::fs::remove_dir_all(&path);
        } else if path.is_file() && (is_gone || is_silent(&path, STALE)) {
            let _ = std::fs::remove_file(&path);
        }
    }
}
