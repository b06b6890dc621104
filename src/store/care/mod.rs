//! Looking after a store: what lies in it, whether it is sound, what can go.

mod collect;
mod pins;
pub(super) mod verify;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use rayon::prelude::*;
use serde::Serialize;

pub use collect::{Collect, Removal};
pub use verify::{Bad, Verdict};

use super::{Manifest, Store};
use crate::error::{Error, Result};

/// One node in the store.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Listed {
    /// Its record.
    pub manifest: Manifest,
    /// When it was made or last found, to within a day.
    pub used: SystemTime,
}

/// What the nodes of one stage take.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Usage {
    /// Nodes.
    pub nodes: usize,
    /// Nodes whose values are not stored.
    pub without_values: usize,
    /// Bytes of their members.
    pub bytes: u64,
    /// Seconds it took to compute them.
    pub seconds: f64,
}

impl Store {
    /// The folders of all nodes, by stage and key.
    fn node_folders(&self) -> Result<Vec<PathBuf>> {
        let mut folders = Vec::new();
        for stage in subfolders(&self.root().join("nodes"))? {
            folders.extend(subfolders(&stage)?);
        }
        folders.sort();
        Ok(folders)
    }

    /// All nodes by stage and key; folders without a readable manifest are passed over ([`Store::verify`] finds them).
    ///
    /// # Errors
    /// Where the store cannot be listed.
    pub fn list(&self) -> Result<Vec<Listed>> {
        let read = |folder: PathBuf| {
            let path = folder.join("manifest.json");
            let manifest = serde_json::from_slice(&std::fs::read(&path).ok()?).ok()?;
            let used = std::fs::metadata(&path).and_then(|meta| meta.modified()).ok()?;
            Some(Listed { manifest, used })
        };
        Ok(self.node_folders()?.into_par_iter().filter_map(read).collect())
    }

    /// What each stage takes.
    ///
    /// # Errors
    /// Where the store cannot be listed.
    pub fn usage(&self) -> Result<BTreeMap<String, Usage>> {
        let mut stages: BTreeMap<String, Usage> = BTreeMap::new();
        for Listed { manifest, .. } in self.list()? {
            let usage = stages.entry(manifest.stage.clone()).or_default();
            usage.nodes += 1;
            usage.without_values += usize::from(manifest.is_virtual);
            usage.bytes += manifest.bytes();
            usage.seconds += manifest.seconds;
        }
        Ok(stages)
    }
}

fn subfolders(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(Error::io("list", folder, e)),
    };
    let entries = entries.flatten().filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    Ok(entries.map(|entry| entry.path()).collect())
}
