//! Making room.
//!
//! Where room is short, the values of the nodes unused for longest go, but their manifests stay: a node downstream can
//! still be found without computing what it was made from. Nodes that are too old, or that no study wants, go whole.

use std::collections::BTreeSet;
use std::time::{Duration, SystemTime};

use serde::Serialize;

use super::Listed;
use crate::error::Result;
use crate::store::digest::Key;
use crate::store::{Manifest, Store};

/// What may stay beside pinned nodes ([`Store::pins`]). Everything does by default.
#[derive(Debug, Clone, Default)]
pub struct Collect {
    /// Bytes that all values together may take.
    pub max_bytes: Option<u64>,
    /// How long ago a node may have been used last.
    pub max_age: Option<Duration>,
    /// The only nodes to stay.
    pub keep_only: Option<BTreeSet<Key>>,
    /// Count only.
    pub dry_run: bool,
}

/// What went, or would go.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct Removal {
    /// Nodes removed whole.
    pub nodes: usize,
    /// Nodes that lost their values only.
    pub emptied: usize,
    /// Bytes made free.
    pub bytes: u64,
    /// Nodes that stay, with values or without.
    pub kept_nodes: usize,
    /// Bytes that stay.
    pub kept_bytes: u64,
}

impl Store {
    /// Removes what `rules` do not let stay; an error while a run is using the store.
    ///
    /// # Errors
    /// Where the store cannot be listed or written, or is in use.
    pub fn collect(&self, rules: &Collect) -> Result<Removal> {
        let _alone = if rules.dry_run { None } else { Some(self.claim_alone()?) };
        let now = SystemTime::now();
        let pinned: BTreeSet<Key> = self.pins()?.into_values().flatten().collect();
        let mut removal = Removal::default();
        let mut kept: Vec<Listed> = Vec::new();
        for listed in self.list()? {
            let manifest = &listed.manifest;
            let age = now.duration_since(listed.used).unwrap_or_default();
            let too_old = rules.max_age.is_some_and(|limit| age > limit);
            let unwanted = rules.keep_only.as_ref().is_some_and(|keep| !keep.contains(&manifest.key));
            if (too_old || unwanted) && !pinned.contains(&manifest.key) {
                removal.nodes += 1;
                removal.bytes += manifest.bytes();
                if !rules.dry_run {
                    self.discard(&self.folder(&manifest.stage, manifest.key))?;
                }
            } else {
                removal.kept_bytes += manifest.bytes();
                kept.push(listed);
            }
        }
        removal.kept_nodes = kept.len();
        kept.sort_by_key(|listed| (listed.used, listed.manifest.key));
        for Listed { manifest, .. } in kept {
            if removal.kept_bytes <= rules.max_bytes.unwrap_or(u64::MAX) {
                break;
            }
            if manifest.is_virtual || manifest.bytes() == 0 || pinned.contains(&manifest.key) {
                continue;
            }
            removal.emptied += 1;
            removal.bytes += manifest.bytes();
            removal.kept_bytes -= manifest.bytes();
            if !rules.dry_run {
                self.empty(manifest)?;
            }
        }
        Ok(removal)
    }

    /// Removes the values of a node and keeps its manifest.
    fn empty(&self, mut manifest: Manifest) -> Result<()> {
        let folder = self.folder(&manifest.stage, manifest.key);
        manifest.is_virtual = true;
        for member in &mut manifest.members {
            member.bytes = 0;
        }
        // Between the two steps the node is not there: whoever looks computes it again, no harm done.
        self.discard(&folder)?;
        let draft = self.draft()?;
        self.publish(draft, manifest).map(drop)
    }
}
