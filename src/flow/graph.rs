//! The graph: files and stages, and what flows into what.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::stage::{Stage, Stored, Streamed, Virtual, Work};
use crate::error::{Error, Result};
use crate::store::Digest;

/// Names a node of one graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub(super) usize);

impl NodeId {
    /// Place of the node in the order in which nodes were added.
    pub fn index(self) -> usize {
        self.0
    }
}

pub(super) enum Kind {
    File(PathBuf),
    Stage { work: Arc<dyn Work>, params: Result<Vec<u8>>, is_virtual: bool },
}

pub(super) struct Node {
    pub(super) label: String,
    pub(super) kind: Kind,
    /// Sorted by port name.
    pub(super) ports: Vec<(String, Vec<NodeId>)>,
}

impl Node {
    pub(super) fn inputs(&self) -> impl Iterator<Item = usize> + '_ {
        self.ports.iter().flat_map(|(_, nodes)| nodes.iter().map(|node| node.0))
    }

    pub(super) fn is_virtual(&self) -> bool {
        matches!(self.kind, Kind::Stage { is_virtual: true, .. })
    }
}

/// Nodes and the arrows between them. A node can only be fed by nodes added before it, so there are no cycles.
///
/// Adding the same work twice (stage, parameters, inputs) gives the same node, whatever its label: the points of a
/// sweep share what they have in common.
#[derive(Default)]
pub struct Graph {
    pub(super) nodes: Vec<Node>,
    same: BTreeMap<Digest, NodeId>,
}

impl Graph {
    /// A graph without nodes.
    pub fn new() -> Self {
        Self::default()
    }

    /// A file of the outside world; its artefact has the one member `file` (bytes). The content counts, not the path.
    pub fn file(&mut self, label: &str, path: impl AsRef<Path>) -> NodeId {
        let path = path.as_ref();
        let identity = Digest::of(&[b"file", path.as_os_str().as_encoded_bytes()].concat());
        self.insert(identity, Node { label: label.to_owned(), kind: Kind::File(path.to_owned()), ports: Vec::new() })
    }

    /// A node that runs `stage` on the artefacts of upstream nodes, by port; the order of ports does not matter.
    pub fn add<S: Stage>(&mut self, label: &str, stage: S, ports: &[(&str, &[NodeId])]) -> NodeId {
        self.add_work(label, Arc::new(Stored(stage)), ports, false)
    }

    /// Like [`Graph::add`], but the result is not stored: it is computed by slabs while a consumer reads it. Keys and
    /// digests are those of the stored result.
    pub fn add_virtual<S: Streamed>(&mut self, label: &str, stage: S, ports: &[(&str, &[NodeId])]) -> NodeId {
        self.add_work(label, Arc::new(Virtual(stage)), ports, true)
    }

    fn add_work(&mut self, label: &str, work: Arc<dyn Work>, ports: &[(&str, &[NodeId])], is_virtual: bool) -> NodeId {
        let mut by_name: BTreeMap<&str, Vec<NodeId>> = BTreeMap::new();
        for (port, nodes) in ports {
            by_name.entry(port).or_default().extend_from_slice(nodes);
        }
        let ports: Vec<(String, Vec<NodeId>)> =
            by_name.into_iter().map(|(port, nodes)| (port.to_owned(), nodes)).collect();
        let params = work.params_bytes();
        let shown = format!("stage {} {} {is_virtual} {ports:?} ", work.name(), work.version());
        let identity = Digest::of(&[shown.as_bytes(), params.as_deref().unwrap_or_default()].concat());
        self.insert(identity, Node { label: label.to_owned(), kind: Kind::Stage { work, params, is_virtual }, ports })
    }

    fn insert(&mut self, identity: Digest, node: Node) -> NodeId {
        *self.same.entry(identity).or_insert_with(|| {
            self.nodes.push(node);
            NodeId(self.nodes.len() - 1)
        })
    }

    /// All nodes in the order in which they were added; inputs come before their consumers.
    pub fn nodes(&self) -> impl Iterator<Item = NodeId> + use<> {
        (0..self.nodes.len()).map(NodeId)
    }

    /// Whether each node is one of `targets` or upstream of one, in the order of [`Self::nodes`].
    pub fn upstream(&self, targets: &[NodeId]) -> Vec<bool> {
        let mut reached = vec![false; self.nodes.len()];
        self.walk().upstream(targets).into_iter().for_each(|n| reached[n.0] = true);
        reached
    }

    /// A walk upstream from many groups of targets in turn.
    pub fn walk(&self) -> Walk<'_> {
        Walk { graph: self, turn: 0, seen: vec![0; self.nodes.len()] }
    }

    /// The label of a node.
    pub fn label(&self, node: NodeId) -> &str {
        &self.nodes[node.0].label
    }

    /// The labels of all nodes, in the order of [`Self::nodes`].
    pub fn labels(&self) -> Vec<String> {
        self.nodes.iter().map(|node| node.label.clone()).collect()
    }

    /// The stage of a node; `None` for a file.
    pub fn stage(&self, node: NodeId) -> Option<&'static str> {
        match &self.nodes[node.0].kind {
            Kind::File(_) => None,
            Kind::Stage { work, .. } => Some(work.name()),
        }
    }

    /// The path of a file; `None` for a stage.
    pub fn path(&self, node: NodeId) -> Option<&Path> {
        match &self.nodes[node.0].kind {
            Kind::File(path) => Some(path),
            Kind::Stage { .. } => None,
        }
    }

    /// The version of a node's stage; `None` for a file.
    pub fn version(&self, node: NodeId) -> Option<u32> {
        match &self.nodes[node.0].kind {
            Kind::File(_) => None,
            Kind::Stage { work, .. } => Some(work.version()),
        }
    }

    /// The parameters of a node's stage, for people; null for a file.
    ///
    /// # Errors
    /// Where they cannot be written.
    pub fn params(&self, node: NodeId) -> Result<serde_json::Value> {
        match &self.nodes[node.0].kind {
            Kind::File(_) => Ok(serde_json::Value::Null),
            Kind::Stage { work, .. } => work.params(),
        }
    }

    /// The nodes that feed a port, in order; none where there is no such port.
    pub fn inputs(&self, node: NodeId, port: &str) -> &[NodeId] {
        let found = self.nodes[node.0].ports.iter().find(|(name, _)| name == port);
        found.map_or(&[], |(_, inputs)| inputs)
    }

    /// The node labelled `label`; where several are, the first.
    pub fn find(&self, label: &str) -> Result<NodeId> {
        let found = self.nodes.iter().position(|node| node.label == label);
        found.map(NodeId).ok_or_else(|| Error::usage(format!("there is no node `{label}`")))
    }
}

/// Walks upstream from one group of targets after the other: each costs what it reaches, not the whole graph.
pub struct Walk<'a> {
    graph: &'a Graph,
    turn: u32,
    /// The turn in which each node was last reached.
    seen: Vec<u32>,
}

impl Walk<'_> {
    /// `targets` and everything upstream of them, each node once, in no order.
    pub fn upstream(&mut self, targets: &[NodeId]) -> Vec<NodeId> {
        self.turn += 1;
        let mut reached = Vec::new();
        let mut open: Vec<usize> = targets.iter().map(|target| target.0).collect();
        while let Some(n) = open.pop() {
            if std::mem::replace(&mut self.seen[n], self.turn) != self.turn {
                reached.push(NodeId(n));
                open.extend(self.graph.nodes[n].inputs());
            }
        }
        reached
    }
}
