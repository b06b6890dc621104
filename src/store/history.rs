//! One line per run and stage: what was run when and how long it took.
//!
//! It serves estimates and `why`; nothing is decided by it, lines that cannot be read are passed over.

use std::io::{Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::digest::{Digest, Key};
use super::holder::this_process;
use super::manifest::Manifest;

/// Bytes that hold the latest runs.
const TAIL: u64 = 64 << 10;

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
    /// When it was published (RFC 3339, UTC); empty in lines of old.
    #[serde(default)]
    pub at: String,
    /// Machine and process that it ran in, as `host:process`; empty in lines of old.
    #[serde(default)]
    pub by: String,
}

/// Adds a line for `record`; a line that cannot be written is a loss of comfort only.
pub(super) fn append(folder: &Path, record: &Manifest, seconds: f64) {
    let past = Past {
        label: record.label.clone(),
        key: record.key,
        digest: record.digest,
        seconds,
        bytes: record.bytes(),
        at: jiff::Timestamp::now().to_string(),
        by: this_process(),
    };
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
    parse(&std::fs::read(folder.join(format!("{stage}.jsonl"))).unwrap_or_default())
}

/// The latest of them, some hundreds, oldest first: a long history costs no more than a short one.
pub(super) fn read_latest(folder: &Path, stage: &str) -> Vec<Past> {
    let tail = || -> std::io::Result<Vec<u8>> {
        let mut file = std::fs::File::open(folder.join(format!("{stage}.jsonl")))?;
        let begin = file.metadata()?.len().saturating_sub(TAIL);
        file.seek(SeekFrom::Start(begin))?;
        let mut text = Vec::new();
        file.read_to_end(&mut text)?;
        Ok(text)
    };
    // The first line may be the end of one: it is then passed over as unreadable.
    parse(&tail().unwrap_or_default())
}

fn parse(text: &[u8]) -> Vec<Past> {
    text.split(|&byte| byte == b'\n').filter_map(|line| serde_json::from_slice(line).ok()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_long_history_the_latest_runs_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let past = |n: usize| Past {
            label: format!("merge {n}"),
            key: Digest([1; 32]),
            digest: Digest([2; 32]),
            seconds: 0.5,
            bytes: 7,
            at: String::new(),
            by: String::new(),
        };
        assert!(read_latest(folder.path(), "merge").is_empty());
        let lines: Vec<String> = (0..2000).map(|n| serde_json::to_string(&past(n)).unwrap() + "\n").collect();
        std::fs::write(folder.path().join("merge.jsonl"), lines.concat()).unwrap();
        let (all, latest) = (read(folder.path(), "merge"), read_latest(folder.path(), "merge"));
        assert_eq!(all.len(), 2000);
        assert!((200..1000).contains(&latest.len()), "{}", latest.len());
        assert_eq!(latest, all[2000 - latest.len()..]);
    }
}
