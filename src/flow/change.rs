//! What differs between a node as it is now and an earlier run of it.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;
use serde_json::Value;

use super::graph::{Graph, Kind};
use crate::store::{Digest, InputRecord, Key, Manifest, Past, Store};

/// Earlier runs looked at for the nearest one.
const LOOK_BACK: usize = 16;

/// One difference.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "kind")]
pub enum Change {
    /// No earlier run of this stage is known.
    New,
    /// It was computed before, but its values are no longer in the store.
    NotStored,
    /// The stage computes differently now.
    Version {
        /// Version of the earlier run.
        from: u32,
        /// Version now.
        to: u32,
    },
    /// A parameter has another value; null stands for absent.
    Parameter {
        /// Its name, with dots into nested values.
        name: String,
        /// Value of the earlier run.
        from: Value,
        /// Value now.
        to: Value,
    },
    /// An input has other values.
    Input {
        /// The port.
        port: String,
        /// Label of the upstream node.
        node: String,
        /// Digest in the earlier run.
        from: Digest,
        /// Digest now; `None` while the upstream node has to run.
        to: Option<Digest>,
    },
    /// There is an input more.
    InputAdded {
        /// The port.
        port: String,
        /// Label of the upstream node.
        node: String,
    },
    /// There is an input less.
    InputRemoved {
        /// The port.
        port: String,
        /// Label of the upstream node.
        node: String,
    },
    /// The inputs of a port come in another order.
    Reordered {
        /// The port.
        port: String,
    },
    /// The content of a file is another.
    File {
        /// Its path.
        path: String,
        /// Digest of the earlier content.
        from: Digest,
        /// Digest of the content now.
        to: Digest,
    },
}

impl Change {
    /// What differs between two sets of parameters.
    pub fn of_parameters(before: &Value, now: &Value) -> Vec<Self> {
        let mut changes = Vec::new();
        compare_params("", before, now, &mut changes);
        changes
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::New => write!(f, "never computed before"),
            Self::NotStored => write!(f, "computed before, but no longer in the store"),
            Self::Version { from, to } => write!(f, "stage version {from} -> {to}"),
            Self::Parameter { name, from, to } => write!(f, "`{name}`: {} -> {}", shown(from), shown(to)),
            Self::Input { node, to: None, .. } => write!(f, "input `{node}` has to be computed again"),
            Self::Input { node, .. } => write!(f, "input `{node}` has other values"),
            Self::InputAdded { node, .. } => write!(f, "input `{node}` added"),
            Self::InputRemoved { node, .. } => write!(f, "input `{node}` removed"),
            Self::Reordered { port } => write!(f, "inputs of `{port}` in another order"),
            Self::File { path, .. } => write!(f, "content of `{path}` changed"),
        }
    }
}

/// A node as it is now: its version, parameters and inputs, with the digests as far as they are known.
pub(super) struct Now {
    pub(super) version: u32,
    pub(super) params: Value,
    pub(super) ports: Vec<(String, Vec<Upstream>)>,
}

/// Label of an upstream node and its digest where that is known.
type Upstream = (String, Option<Digest>);

impl Now {
    /// Node `n` of `graph`; `None` for a file.
    pub(super) fn of(graph: &Graph, n: usize, digest: &dyn Fn(usize) -> Option<Digest>) -> Option<Self> {
        let node = &graph.nodes[n];
        let Kind::Stage { work, .. } = &node.kind else { return None };
        let input = |input: usize| (graph.nodes[input].label.clone(), digest(input));
        let ports = node.ports.iter().map(|(port, nodes)| (port.clone(), nodes.iter().map(|n| input(n.0)).collect()));
        Some(Self { version: work.version(), params: work.params().unwrap_or_default(), ports: ports.collect() })
    }

    /// What differs from an earlier run.
    pub(super) fn changes(&self, before: &Manifest) -> Vec<Change> {
        let mut changes = Vec::new();
        if self.version != before.version {
            changes.push(Change::Version { from: before.version, to: self.version });
        }
        compare_params("", &before.params.value(), &self.params, &mut changes);
        let none = Vec::new();
        for (port, inputs) in &self.ports {
            compare_inputs(port, before.inputs.get(port).unwrap_or(&none), inputs, &mut changes);
        }
        for (port, records) in &before.inputs {
            if !self.ports.iter().any(|(name, _)| name == port) {
                compare_inputs(port, records, &[], &mut changes);
            }
        }
        changes
    }
}

/// A value for people: a number of single precision in its shortest form.
fn shown(value: &Value) -> String {
    match value.as_f64().filter(|_| value.is_f64()) {
        Some(x) if f64::from(x as f32) == x => (x as f32).to_string(),
        _ => value.to_string(),
    }
}

fn compare_params(name: &str, before: &Value, now: &Value, changes: &mut Vec<Change>) {
    if let (Value::Object(before), Value::Object(now)) = (before, now) {
        let mut names: Vec<&String> = before.keys().chain(now.keys()).collect();
        names.sort();
        names.dedup();
        for key in names {
            let path = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
            compare_params(
                &path,
                before.get(key).unwrap_or(&Value::Null),
                now.get(key).unwrap_or(&Value::Null),
                changes,
            );
        }
    } else if before != now {
        changes.push(Change::Parameter { name: name.to_owned(), from: before.clone(), to: now.clone() });
    }
}

fn compare_inputs(port: &str, before: &[InputRecord], now: &[Upstream], changes: &mut Vec<Change>) {
    let port = port.to_owned();
    let old: BTreeMap<&str, Digest> = before.iter().map(|record| (record.node.as_str(), record.digest)).collect();
    // Labels may differ between studies: the same values under another label are the same input.
    let mut unmatched: Vec<Digest> =
        before.iter().filter(|r| !now.iter().any(|(label, _)| *label == r.node)).map(|r| r.digest).collect();
    let begun = changes.len();
    for (label, digest) in now {
        match old.get(label.as_str()) {
            Some(from) if Some(*from) != *digest => {
                changes.push(Change::Input { port: port.clone(), node: label.clone(), from: *from, to: *digest });
            }
            Some(_) => {}
            None => match unmatched.iter().position(|old| Some(*old) == *digest) {
                Some(at) => drop(unmatched.remove(at)),
                None => changes.push(Change::InputAdded { port: port.clone(), node: label.clone() }),
            },
        }
    }
    for record in before.iter().filter(|record| !now.iter().any(|(label, _)| *label == record.node)) {
        if let Some(at) = unmatched.iter().position(|old| *old == record.digest) {
            unmatched.remove(at);
            changes.push(Change::InputRemoved { port: port.clone(), node: record.node.clone() });
        }
    }
    let same = |(record, (_, digest)): (&InputRecord, &Upstream)| Some(record.digest) == *digest;
    if changes.len() == begun && !before.iter().zip(now).all(same) {
        changes.push(Change::Reordered { port });
    }
}

/// The earlier run of `history`, that of the stage, with the fewest differences from `now` and what they are: runs under the same label first, the
/// later of two equals. The run with the node's own key `own` does not count.
pub(super) fn nearest(
    store: &Store,
    history: &[Past],
    stage: &str,
    label: &str,
    own: Option<Key>,
    now: &Now,
) -> (Option<Manifest>, Vec<Change>) {
    let same_label = history.iter().rev().filter(|past| past.label == label);
    let others = history.iter().rev().filter(|past| past.label != label);
    for (group, limit) in [(same_label.collect::<Vec<_>>(), LOOK_BACK), (others.collect(), 1)] {
        let mut seen = Vec::new();
        let mut best: Option<(Manifest, Vec<Change>)> = None;
        for past in group {
            if Some(past.key) == own || seen.contains(&past.key) {
                continue;
            }
            if seen.len() >= limit {
                break;
            }
            seen.push(past.key);
            let Ok(Some(manifest)) = store.lookup(stage, past.key) else { continue };
            let changes = now.changes(&manifest);
            if best.as_ref().is_none_or(|(_, fewest)| changes.len() < fewest.len()) {
                best = Some((manifest, changes));
            }
        }
        if let Some((manifest, changes)) = best {
            return (Some(manifest), changes);
        }
    }
    (None, vec![Change::New])
}
