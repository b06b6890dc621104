//! What the store holds of a graph: asked before anything else is decided, by all threads.
//!
//! A node's key needs the digests of its inputs, so nodes are asked for level by level: files are the lowest, and every node stands
//! one above the highest of its inputs. The nodes of one level wait for nothing of each other. A trial of forty captures has thousands
//! of nodes on some twenty levels.

use super::graph::{Graph, Kind};
use super::key::key;
use crate::error::{Error, Result};
use crate::store::{Artefact, Digest, Key, Manifest, Store};
use rayon::prelude::*;

/// The content of all files that are reached, read in parallel where the store does not remember them.
pub(super) fn read_files(graph: &Graph, store: &Store, reached: &[bool]) -> Vec<(usize, Result<Artefact>)> {
    let files = graph.nodes.iter().enumerate().filter_map(|(n, node)| match &node.kind {
        Kind::File(path) if reached[n] => Some((n, path)),
        _ => None,
    });
    let read = |(n, path): (usize, &std::path::PathBuf)| {
        (n, store.file_digest(path).map(|(digest, bytes)| Artefact::file(path, digest, bytes)))
    };
    files.collect::<Vec<_>>().into_par_iter().map(read).collect()
}

/// A node whose key is known.
pub(super) struct Found {
    pub(super) key: Key,
    /// What the store knew of it when it was asked.
    pub(super) manifest: Option<Manifest>,
}

/// Asks for every node of `reached` whose inputs have known digests, and notes the digests of those found; `digests` has those of
/// files. `None` for files and where an input has to run first.
///
/// # Errors
/// Of single nodes: where the store cannot be read or a parameter cannot be written.
pub(super) fn find(
    graph: &Graph,
    store: &Store,
    reached: &[bool],
    digests: &mut [Option<Digest>],
) -> Vec<Option<Result<Found>>> {
    let mut found: Vec<Option<Result<Found>>> = graph.nodes.iter().map(|_| None).collect();
    for level in levels(graph, reached) {
        let known = &*digests;
        let ask = |n: usize| {
            let Kind::Stage { work, .. } = &graph.nodes[n].kind else { return None };
            let key = key_of(graph, n, |input| known[input]).transpose()?;
            let ask = |key| Ok(Found { key, manifest: store.lookup(work.name(), key)? });
            Some((n, key.and_then(ask)))
        };
        for (n, answer) in level.into_par_iter().filter_map(ask).collect::<Vec<_>>() {
            digests[n] = answer.as_ref().ok().and_then(|found| Some(found.manifest.as_ref()?.digest));
            found[n] = Some(answer);
        }
    }
    found
}

/// The stages of `reached`, the lowest level first.
fn levels(graph: &Graph, reached: &[bool]) -> Vec<Vec<usize>> {
    let mut height = vec![0; graph.nodes.len()];
    let mut levels: Vec<Vec<usize>> = Vec::new();
    // Inputs come before their consumers.
    for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| reached[*n]) {
        if matches!(node.kind, Kind::File(_)) {
            continue;
        }
        height[n] = 1 + node.inputs().map(|input| height[input]).max().unwrap_or(0);
        levels.resize_with(levels.len().max(height[n]), Vec::new);
        levels[height[n] - 1].push(n);
    }
    levels
}

/// The key of stage node `n`; `None` where the digest of an input is not known.
///
/// # Errors
/// For a file, and where a parameter cannot be written.
pub(super) fn key_of(graph: &Graph, n: usize, digest: impl Fn(usize) -> Option<Digest>) -> Result<Option<Key>> {
    let node = &graph.nodes[n];
    let Kind::Stage { work, params, .. } = &node.kind else {
        return Err(Error::failed(format!("`{}` is a file and has no key", node.label)));
    };
    let params = params.as_ref().map_err(Clone::clone)?;
    let mut ports = Vec::new();
    for (port, inputs) in &node.ports {
        let Some(digests) = inputs.iter().map(|input| digest(input.0)).collect() else { return Ok(None) };
        ports.push((port.as_str(), digests));
    }
    Ok(Some(key(work.name(), work.version(), params, &ports)))
}
