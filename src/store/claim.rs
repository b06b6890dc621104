//! Claims: a courtesy between processes, so that the same work is rarely done twice.
//!
//! Correctness does not rest on them: where locks do not work, every claim succeeds, both processes compute, and
//! the second to publish finds the result there.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::digest::Key;
/// The answer to a claim.
pub enum Claim {
    /// The work is ours until this is dropped.
    Ours(Held),
    /// Another thread or process is at it.
    Busy,
}

/// A claim held; released when dropped, or when the process ends.
pub struct Held {
    file: Option<(File, PathBuf)>,
}

impl Drop for Held {
    fn drop(&mut self) {
        if let Some((file, path)) = self.file.take() {
            // Removed while locked. Somebody who opened it before may then claim a file without a name while a
            // third makes a new one: both compute, which is harmless.
            let _ = std::fs::remove_file(path);
            drop(file);
        }
    }
}

pub(super) fn claim(locks: &Path, key: Key) -> Claim {
    let path = locks.join(format!("{key}.lock"));
    let open = || File::options().create(true).truncate(false).write(true).open(&path);
    let Ok(file) = open().or_else(|_| std::fs::create_dir_all(locks).and_then(|()| open())) else {
        return Claim::Ours(Held { file: None });
    };
    match file.try_lock() {
        Ok(()) => Claim::Ours(Held { file: Some((file, path)) }),
        Err(TryLockError::WouldBlock) => Claim::Busy,
        Err(TryLockError::Error(_)) => Claim::Ours(Held { file: None }),
    }
}
