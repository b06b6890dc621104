//! The private folder of one process under `tmp/`, and the sweeping of those whose process is gone.
//!
//! `tmp/<name>.lock` is held locked as long as the process lives; the system releases it however the process ends.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use crate::error::{Error, Result};

/// Where locks do not work, leftovers are swept at this age.
const STALE: Duration = Duration::from_secs(7 * 24 * 3600);

/// The drafts of this process.
pub(super) struct Session {
    folder: PathBuf,
    lock_path: PathBuf,
    _lock: File,
    next: AtomicU64,
}

impl Session {
    /// Makes a folder in `tmp` that no other process uses or sweeps.
    pub(super) fn begin(tmp: &Path) -> Result<Self> {
        let cannot = |e| {
            Error::io("write to the store in", tmp, e)
                .help("make it writable, or name another folder with `--cache FOLDER` or ROOTVOX_CACHE")
        };
        std::fs::create_dir_all(tmp).map_err(cannot)?;
        loop {
            let lock = tempfile::Builder::new()
                .prefix(&format!("{}-", std::process::id()))
                .suffix(".lock")
                .tempfile_in(tmp)
                .map_err(cannot)?;
            let (file, lock_path) = lock.keep().map_err(|e| cannot(e.error))?;
            // Without working locks the age decides.
            let _ = file.try_lock();
            if !lock_path.exists() {
                continue; // A sweeper came between the making and the locking.
            }
            let folder = lock_path.with_extension("");
            std::fs::create_dir(&folder).map_err(cannot)?;
            return Ok(Self { folder, lock_path, _lock: file, next: AtomicU64::new(0) });
        }
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
        // What cannot be removed now is swept later.
        let _ = std::fs::remove_dir_all(&self.folder);
        let _ = std::fs::remove_file(&self.lock_path);
    }
}

/// Removes what processes that are gone left in `tmp`; what cannot be removed stays.
pub(super) fn sweep(tmp: &Path) {
    let Ok(entries) = std::fs::read_dir(tmp) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        let is_lock = path.extension().is_some_and(|extension| extension == "lock");
        if is_lock && is_abandoned(&path) {
            let _ = std::fs::remove_dir_all(path.with_extension(""));
            let _ = std::fs::remove_file(&path);
        } else if !is_lock && !path.with_extension("lock").exists() {
            // The lock is made before the folder and removed after it: nobody owns this one.
            let _ = std::fs::remove_dir_all(&path);
        }
    }
}

fn is_abandoned(lock: &Path) -> bool {
    let Ok(file) = File::open(lock) else { return false };
    match file.try_lock() {
        Ok(()) => true,
        Err(TryLockError::WouldBlock) => false,
        Err(TryLockError::Error(_)) => {
            let age = file.metadata().and_then(|m| m.modified()).ok().and_then(|time| time.elapsed().ok());
            age.is_some_and(|age| age > STALE)
        }
    }
}
