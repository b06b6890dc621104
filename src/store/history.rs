//! One line per run and stage: what was run when and how long it took.
//!
//! It serves estimates and `why`; nothing is decided by it, lines that cannot be read are passed over.

use std::io::Write;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::digest::{Digest, Key};
use super::manifest::Manifest;

/// One earlier run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Past {
    /// Label of the node.
    pub label: String,
    /// Its key.
    pub key: Key,
    /// Digest of its artefact.
    pub digest: Digest,
    /// How long it took with publishing, in seconds.
    pub seconds: f64,
    /// Bytes stored.
    pub bytes: u64,
}

/// Adds a line for `record`; a line that cannot be written is a loss of comfort only.
pub(super) fn append(folder: &Path, record: &Manifest, seconds: f64) {
    let past =
        Past { label: record.label.clone(), key: record.key, digest: record.digest, seconds, bytes: record.bytes() };
    let Ok(mut line) = serde_json::to_vec(&past) else { return };
    line.push(b'\n');
    let path = folder.join(format!("{}.jsonl", record.stage));
    let open = || std::fs::File::options().create(true).append(true).open(&path);
    if let Ok(mut file) = open().or_else(|_| std::fs::create_dir_all(folder).and_then(|()| open())) {
        // One write of one line: lines of several processes do not mix.
        let _ = file.write_all(&line);
    }
}

/// The earlier runs of `stage`, oldest first.
pub(super) fn read(folder: &Path, stage: &str) -> Vec<Past> {
    let text = std::fs::read_to_string(folder.join(format!("{stage}.jsonl"))).unwrap_or_default();
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}
