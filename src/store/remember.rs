//! Digests of input files, remembered so that an unchanged study starts without reading its photographs.
//!
//! A digest is trusted while path, size, modification time, change time and inode are what they were, and only
//! if the file had been left alone for [`SETTLED`] when it was read: a file written twice within one tick of the
//! file system's clock would otherwise go unnoticed. When in doubt the file is read again.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::digest::Digest;
use super::files;
use crate::error::{Error, Result};

/// How long a file must have been left alone when it is read.
const SETTLED: Duration = Duration::from_secs(2);

#[derive(Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    bytes: u64,
    modified_ns: i64,
    changed_ns: i64,
    inode: u64,
}

#[derive(Clone, Copy, Serialize, Deserialize)]
struct Entry {
    #[serde(flatten)]
    stamp: Stamp,
    digest: Digest,
}

/// What is remembered of files, by absolute path.
#[derive(Default)]
pub(super) struct FileMemory {
    known: BTreeMap<String, Entry>,
    learned: BTreeMap<String, Entry>,
}

impl FileMemory {
    /// Reads the memory; a missing or broken one is empty.
    pub(super) fn load(path: &Path) -> Self {
        let known = std::fs::read(path).ok().and_then(|text| serde_json::from_slice(&text).ok()).unwrap_or_default();
        Self { known, learned: BTreeMap::new() }
    }

    /// Adds what was learned to what is on disk now (other processes learn too) by an atomic rename.
    pub(super) fn save(&mut self, path: &Path) {
        if self.learned.is_empty() {
            return;
        }
        let mut all = Self::load(path).known;
        all.append(&mut self.learned);
        self.known = all;
        let write = || -> std::io::Result<()> {
            let folder = path.parent().unwrap_or(Path::new("."));
            let mut file = files::shared_files().prefix(&super::holder::tag()).tempfile_in(folder.join("tmp"))?;
            std::io::Write::write_all(&mut file, &serde_json::to_vec(&self.known)?)?;
            file.persist(path)?;
            Ok(())
        };
        // A memory that cannot be kept costs time, nothing else.
        let _ = write();
    }
}

fn nanoseconds(time: std::io::Result<SystemTime>) -> i64 {
    let since = time.ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    i64::try_from(since.as_nanos()).unwrap_or(i64::MAX)
}

fn stamp(path: &Path) -> Result<Stamp> {
    let meta = std::fs::metadata(path).map_err(|e| Error::io("read", path, e))?;
    if !meta.is_file() {
        return Err(Error::failed(format!("`{}` is not a file", path.display())));
    }
    #[cfg(unix)]
    let (inode, changed_ns) = {
        use std::os::unix::fs::MetadataExt;
        (meta.ino(), meta.ctime().saturating_mul(1_000_000_000).saturating_add(meta.ctime_nsec()))
    };
    #[cfg(not(unix))]
    let (inode, changed_ns) = (0, 0);
    Ok(Stamp { bytes: meta.len(), modified_ns: nanoseconds(meta.modified()), changed_ns, inode })
}

/// Digest and length of the file at `path`, from memory where that can be trusted.
pub(super) fn file_digest(memory: &Mutex<FileMemory>, path: &Path) -> Result<(Digest, u64)> {
    let absolute = std::path::absolute(path).map_err(|e| Error::io("find", path, e))?;
    let name = absolute.to_string_lossy().into_owned();
    let before = stamp(path)?;
    {
        let memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
        let entry = memory.learned.get(&name).or_else(|| memory.known.get(&name));
        if let Some(entry) = entry.filter(|entry| entry.stamp == before) {
            return Ok((entry.digest, before.bytes));
        }
    }
    let begun = nanoseconds(Ok(SystemTime::now()));
    let (digest, bytes) = files::digest_file(path)?;
    let after = stamp(path)?;
    if after != before || bytes != before.bytes {
        return Err(Error::failed(format!("`{}` changed while it was being read", path.display()))
            .help("run again when nothing writes to it"));
    }
    let youngest = before.modified_ns.max(before.changed_ns);
    if begun.saturating_sub(youngest) > i64::try_from(SETTLED.as_nanos()).unwrap_or(i64::MAX) {
        let mut memory = memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.learned.insert(name, Entry { stamp: before, digest });
    }
    Ok((digest, bytes))
}
