//! The nodes that studies reach in a store: those of study files as they are now, and those of locks.

use crate::error::Result;
use crate::flow::{Engine, NodeState};
use crate::store::{Key, Store};
use crate::study::batch::Batch;
use crate::study::lock::Lock;
use std::collections::BTreeSet;
use std::path::Path;

/// What a study reaches.
pub struct Reach {
    /// Name of the study.
    pub name: String,
    /// Keys of its nodes, as far as they can be known without running.
    pub keys: BTreeSet<Key>,
    /// Nodes that would run, or may: what hangs on them cannot be known.
    pub pending: usize,
}

/// Follows the study file, or the `.lock`, at `path`.
///
/// # Errors
/// Faults of the study, or an unreadable store.
pub fn reach(store: &Store, path: &Path) -> Result<Reach> {
    if path.extension().is_some_and(|extension| extension == "lock") {
        let lock = Lock::read(path)?;
        let keys = lock.nodes.iter().filter_map(|node| node.key).collect();
        return Ok(Reach { name: lock.study, keys, pending: 0 });
    }
    let batch = Batch::load(path, &[])?;
    let plan = Engine::new(store).status(&batch.graph, &batch.targets())?;
    let keys = plan.nodes().filter_map(|(_, planned)| match planned.state {
        NodeState::Cached { key, .. } | NodeState::WouldRun { key, .. } => Some(key),
        _ => None,
    });
    let names: Vec<&str> = batch.studies.iter().map(|study| study.name.as_str()).collect();
    Ok(Reach { name: names.join("+"), keys: keys.collect(), pending: plan.pending().count() })
}

/// The nodes of a study by stage and key.
pub struct Reached {
    /// Those that the store has, inputs before consumers.
    pub nodes: Vec<(String, Key)>,
    /// How many it does not have.
    pub pending: usize,
}

/// The nodes of the study file, or the `.lock`, at `path` that the store has.
///
/// # Errors
/// As [`reach`].
pub fn nodes(store: &Store, path: &Path) -> Result<Reached> {
    if path.extension().is_some_and(|extension| extension == "lock") {
        let lock = Lock::read(path)?;
        let of = |node: &crate::study::lock::LockedNode| Some((lock.work.get(node.work?)?.stage.clone(), node.key?));
        let nodes: Vec<(String, Key)> = lock.nodes.iter().filter_map(of).collect();
        return Ok(Reached { nodes, pending: 0 });
    }
    let batch = Batch::load(path, &[])?;
    let plan = Engine::new(store).status(&batch.graph, &batch.targets())?;
    let nodes = plan.nodes().filter_map(|(_, planned)| match (&planned.state, planned.stage) {
        (NodeState::Cached { key, .. }, Some(stage)) => Some((stage.to_owned(), *key)),
        _ => None,
    });
    Ok(Reached { nodes: nodes.collect(), pending: plan.pending().count() })
}
