//! What happens during a run, for progress displays and for tests.

use super::change::Change;
use super::graph::NodeId;
use crate::error::Error;
use crate::store::{Digest, Key};

/// One thing that happened. Events of one run come one after the other, never at once.
#[derive(Debug, Clone)]
pub enum Event {
    /// Fires once, first: `total` nodes are reachable from the targets.
    Planned {
        /// Number of nodes.
        total: usize,
    },
    /// Fires when a node's result is found in the store; at most once per node.
    Hit {
        /// The node.
        node: NodeId,
        /// Its key.
        key: Key,
        /// Warnings that the stage gave when it ran.
        warnings: Vec<String>,
    },
    /// Fires when a node begins to run.
    Started {
        /// The node.
        node: NodeId,
        /// What differs from the nearest earlier run.
        why: Vec<Change>,
    },
    /// Fires now and then while a node runs.
    Progress {
        /// The node.
        node: NodeId,
        /// Steps done.
        done: u64,
        /// Steps in all, 0 if unknown.
        total: u64,
    },
    /// Fires when another process is computing the node and this one waits for it.
    Waiting {
        /// The node.
        node: NodeId,
    },
    /// Fires when a node's result is published.
    Finished {
        /// The node.
        node: NodeId,
        /// How long it ran.
        seconds: f64,
        /// Digest of its artefact.
        digest: Digest,
        /// Whether the latest earlier result of this stage under this label was the same.
        same_output: bool,
        /// Whether another process had published the same work meanwhile.
        in_vain: bool,
        /// What the stage warned of.
        warnings: Vec<String>,
    },
    /// Fires when a node failed.
    Failed {
        /// The node.
        node: NodeId,
        /// Why.
        error: Error,
    },
    /// Fires when a node cannot run because something upstream failed.
    Skipped {
        /// The node.
        node: NodeId,
    },
}
