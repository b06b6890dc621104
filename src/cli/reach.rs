//! The nodes that studies reach in a store: those of study files as they are now, and those of locks.

use crate::error::Result;
use crate::flow::{Engine, NodeState};
use crate::store::{Key, Store};
use crate::study::batch::Batch;
use crate::study::lock::{Lock, LockedNode};
use std::collections::BTreeSet;
use std::path::Path;

/// What a study reaches.
pub struct Reach {
    /// Name of the study.
    pub name: String,
    /// Stage and key of its nodes, inputs before consumers, as far as they can be known without running.
    pub nodes: Vec<(String, Key)>,
    /// Nodes that would run, or may: what hangs on them cannot be known.
    pub pending: usize,
}

impl Reach {
    /// Keys of all nodes.
    pub fn keys(&self) -> BTreeSet<Key> {
        self.nodes.iter().map(|(_, key)| *key).collect()
    }
}

/// Follows the study file, or the `.lock`, at `path`.
///
/// # Errors
/// Faults of the study, or an unreadable store.
pub fn reach(store: &Store, path: &Path) -> Result<Reach> {
    if path.extension().is_some_and(|extension| extension == "lock") {
        let lock = Lock::read(path)?;
        let of = |node: &LockedNode| Some((lock.work.get(node.work?)?.stage.clone(), node.key?));
        let nodes = lock.nodes.iter().filter_map(of).collect();
        return Ok(Reach { name: lock.study, nodes, pending: 0 });
    }
    let batch = Batch::load(path, &[])?;
    let plan = Engine::new(store).status(&batch.graph, &batch.targets())?;
    let nodes = plan.nodes().filter_map(|(_, planned)| match planned.state {
        NodeState::Cached { key, .. } | NodeState::WouldRun { key, .. } => Some((planned.stage?.to_owned(), key)),
        _ => None,
    });
    let names: Vec<&str> = batch.studies.iter().map(|study| study.name.as_str()).collect();
    Ok(Reach { name: names.join("+"), nodes: nodes.collect(), pending: plan.pending().count() })
}
