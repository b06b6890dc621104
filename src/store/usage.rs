//! Who is at the store: runs share it, cleaning wants it alone. Where locks do not work, nothing is held back.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::time::{Duration, SystemTime};

use super::digest::Key;
use super::{Draft, Store};
use crate::error::{Error, Result};

/// A node's time of last use is kept to within this.
const FRESH: Duration = Duration::from_secs(24 * 3600);

/// Held while the store is in use.
pub struct InUse {
    _lock: Option<File>,
}

impl Store {
    fn lock_file(&self) -> Option<File> {
        File::options().create(true).truncate(false).write(true).open(self.root().join("in-use.lock")).ok()
    }

    /// Keeps cleaning away until the answer is dropped.
    pub fn use_it(&self) -> InUse {
        let lock = self.lock_file().filter(|file| file.lock_shared().is_ok());
        InUse { _lock: lock }
    }

    /// An error while a run is using the store.
    pub(super) fn claim_alone(&self) -> Result<InUse> {
        let lock = self.lock_file();
        match lock.as_ref().map(File::try_lock) {
            Some(Err(TryLockError::WouldBlock)) => {
                Err(Error::failed(format!("a run is using the store `{}`", self.home().display()))
                    .help("clean it when the run is done"))
            }
            _ => Ok(InUse { _lock: lock }),
        }
    }

    /// Notes that a node was found, for [`Store::collect`]; a store that cannot be written does not.
    pub fn touch(&self, stage: &str, key: Key) {
        let path = self.folder(stage, key).join("manifest.json");
        let modified = std::fs::metadata(&path).and_then(|meta| meta.modified());
        let age = modified.ok().and_then(|time| SystemTime::now().duration_since(time).ok());
        if age.is_some_and(|age| age > FRESH) {
            let _ = File::open(&path).and_then(|file| file.set_modified(SystemTime::now()));
        }
    }

    /// Removes a node: at once for readers, by a rename into a private folder.
    pub(super) fn discard(&self, folder: &Path) -> Result<()> {
        let draft: Draft = self.draft()?;
        let aside = draft.folder.join("discarded");
        match std::fs::rename(folder, &aside) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(Error::io("remove", folder, e)),
            _ => Ok(()),
        }
    }
}
