//! `rootvox cache verify`: every digest again, and damaged nodes made anew.

use super::options::human_bytes;
use super::terminal::dataln;
use crate::error::{Error, Result};
use crate::flow::{Engine, NodeId, NodeState};
use crate::store::{Digest, Key, Store};
use crate::study::batch::Batch;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

/// A study and, with their digests where they are known, its nodes that the store held.
type Planned = (Batch, Vec<(NodeId, Key, Option<Digest>)>);

/// Verifies `store`; with `repair`, damaged nodes are removed, and computed again where `studies` need them.
///
/// # Errors
/// Where nodes are damaged and stay so, or are computed again with other values.
pub fn verify(store: &Store, repair: bool, studies: &[PathBuf]) -> Result<()> {
    let cancel = super::cancel::flag()?;
    let planned: Vec<Planned> = studies.iter().map(|path| plan(store, path)).collect::<Result<_>>()?;
    let stopped = || cancel.load(Ordering::Relaxed);
    let verdict = store.verify(repair, &|_, _| if stopped() { Err(Error::interrupted()) } else { Ok(()) })?;
    for bad in &verdict.bad {
        dataln!("bad: {}: {}", bad.folder.display(), bad.cause);
    }
    let (nodes, read, removed) = (verdict.nodes, human_bytes(verdict.bytes), verdict.removed);
    dataln!("{nodes} nodes, {read} read: {} bad, {removed} removed", verdict.bad.len());
    if verdict.bad.len() > removed {
        return Err(Error::failed(format!("{} nodes are damaged", verdict.bad.len()))
            .help("`rootvox cache verify --repair` removes them; the next run computes them again"));
    }
    let bad: BTreeSet<Key> = verdict.bad.iter().filter_map(|bad| bad.key).collect();
    let mut others = Vec::new();
    for (batch, nodes) in planned {
        let damaged: Vec<_> = nodes.into_iter().filter(|(_, key, _)| bad.contains(key)).collect();
        let targets: Vec<NodeId> = damaged.iter().map(|(node, ..)| *node).collect();
        let report = Engine::new(store).cancel(cancel.clone()).run(&batch.graph, &targets)?;
        for (node, _, before) in damaged {
            let same = before.is_none_or(|before| report.digest(node) == Some(before));
            dataln!("computed again: {}{}", batch.graph.label(node), if same { "" } else { ", with other values" });
            others.extend((!same).then(|| batch.graph.label(node).to_owned()));
        }
    }
    if others.is_empty() {
        return Ok(());
    }
    Err(Error::failed(format!("{} gave other values than before", others.join(", ")))
        .help("its record was damaged, or its stage is not deterministic: please report it"))
}

fn plan(store: &Store, path: &std::path::Path) -> Result<Planned> {
    let batch = Batch::load(path, &[])?;
    let plan = Engine::new(store).status(&batch.graph, &batch.targets())?;
    let known = plan.nodes().filter_map(|(node, planned)| match planned.state {
        NodeState::Cached { key, digest, .. } => Some((node, key, Some(digest))),
        NodeState::WouldRun { key, digest, .. } => Some((node, key, digest)),
        _ => None,
    });
    let known = known.collect();
    Ok((batch, known))
}
