//! What a run would do, and why, without doing it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::change::{Change, Now, nearest};
use super::found::{Found, find, read_files};
use super::graph::{Graph, Kind, NodeId};
use crate::error::{Error, Result};
use crate::store::{Digest, Key, Manifest, Past, Store};

/// Runs of the latest past that an estimate rests on.
const RECENT: usize = 9;

/// What a run would do with a node.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum NodeState {
    /// A file, read or remembered.
    File {
        /// Digest of its content.
        digest: Digest,
    },
    /// A file that cannot be read.
    Unreadable {
        /// Why.
        error: String,
    },
    /// The store has it.
    Cached {
        /// Its key.
        key: Key,
        /// Digest of its artefact.
        digest: Digest,
        /// Whether it was streamed into its consumer, and would be again.
        is_virtual: bool,
    },
    /// It would run.
    WouldRun {
        /// Its key.
        key: Key,
        /// Digest of its artefact, where that is on record and only the values are gone.
        digest: Option<Digest>,
        /// What differs from the nearest earlier run.
        changes: Vec<Change>,
    },
    /// Something upstream would run first; if that gives the same values as before, this would not run.
    Unknown {
        /// What is known to differ from the nearest earlier run.
        changes: Vec<Change>,
    },
}

/// One node of a plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Planned {
    /// Label of the node.
    pub label: String,
    /// Its stage; `None` for a file.
    pub stage: Option<&'static str>,
    /// What a run would do with it.
    #[serde(flatten)]
    pub state: NodeState,
    /// Seconds that running it would take by experience; `None` without any.
    pub seconds: Option<f64>,
    /// Bytes that storing it would take by experience; `None` without any.
    pub bytes: Option<u64>,
}

impl Planned {
    /// Whether a run would compute it, or may.
    fn is_pending(&self) -> bool {
        matches!(self.state, NodeState::WouldRun { .. } | NodeState::Unknown { .. })
    }
}

/// What a run would do.
pub struct Plan {
    entries: Vec<Option<Planned>>,
}

impl Plan {
    /// A node of the plan; `None` if no target depends on it.
    pub fn node(&self, node: NodeId) -> Option<&Planned> {
        self.entries[node.0].as_ref()
    }

    /// All nodes that the targets depend on, inputs before consumers.
    pub fn nodes(&self) -> impl Iterator<Item = (NodeId, &Planned)> {
        self.entries.iter().enumerate().filter_map(|(n, entry)| Some((NodeId(n), entry.as_ref()?)))
    }

    /// The digest of node `n`, where it is known without running.
    fn digest(&self, n: usize) -> Option<Digest> {
        match self.entries[n].as_ref().map(|entry| &entry.state) {
            Some(NodeState::File { digest } | NodeState::Cached { digest, .. }) => Some(*digest),
            Some(NodeState::WouldRun { digest, .. }) => *digest,
            _ => None,
        }
    }

    /// Nodes that would run, or may.
    pub fn pending(&self) -> impl Iterator<Item = (NodeId, &Planned)> {
        self.nodes().filter(|(_, planned)| planned.is_pending())
    }
}

/// One node on the way from the root cause to the node that was asked about.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// Label of the node.
    pub label: String,
    /// What differs from the earlier run.
    pub changes: Vec<Change>,
    /// When that run began (RFC 3339); `None` where there is none, and for files.
    pub against: Option<String>,
}

/// Decides every node that `targets` depend on.
pub(super) fn plan(graph: &Graph, store: &Store, targets: &[NodeId]) -> Result<Plan> {
    let reached = graph.upstream(targets);
    let mut digests: Vec<Option<Digest>> = vec![None; graph.nodes.len()];
    let mut entries: Vec<Option<Planned>> = graph.nodes.iter().map(|_| None).collect();
    let mut experience = Experience::new(store);
    for (n, found) in read_files(graph, store, &reached) {
        let state = match found {
            Ok(artefact) => {
                digests[n] = Some(artefact.digest());
                NodeState::File { digest: artefact.digest() }
            }
            Err(error) => NodeState::Unreadable { error: error.to_string() },
        };
        let label = graph.nodes[n].label.clone();
        entries[n] = Some(Planned { label, stage: None, state, seconds: None, bytes: None });
    }
    store.remember_files();
    let mut found = find(graph, store, &reached, &mut digests);
    for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| reached[*n]) {
        let Kind::Stage { work, .. } = &node.kind else { continue };
        let (stage, label) = (work.name(), node.label.clone());
        let changes = |experience: &mut Experience<'_>, own| {
            let now = Now::of(graph, n, &|input| digests[input]);
            now.map_or_else(Vec::new, |now| nearest(store, experience.of(stage), stage, &label, own, &now).1)
        };
        let state = match found[n].take().transpose()? {
            Some(Found { key, manifest: Some(held) }) => {
                NodeState::Cached { key, digest: held.digest, is_virtual: held.is_virtual }
            }
            Some(Found { key, manifest: None }) => {
                let before = experience.of(stage).iter().any(|past| past.key == key);
                NodeState::WouldRun {
                    key,
                    digest: None,
                    changes: if before { vec![Change::NotStored] } else { changes(&mut experience, Some(key)) },
                }
            }
            None => NodeState::Unknown { changes: changes(&mut experience, None) },
        };
        entries[n] = Some(Planned { label, stage: Some(stage), state, seconds: None, bytes: None });
    }
    want_values(graph, targets, &mut entries);
    for entry in entries.iter_mut().flatten().filter(|entry| entry.is_pending()) {
        let Some(stage) = entry.stage else { continue };
        (entry.seconds, entry.bytes) = experience.estimate(stage, &entry.label);
    }
    Ok(Plan { entries })
}

/// Where only a record is left of what a target or a node that would run has to read, that would run too; what streams
/// is made again while it is read.
fn want_values(graph: &Graph, targets: &[NodeId], entries: &mut [Option<Planned>]) {
    let mut wanted = vec![false; entries.len()];
    targets.iter().for_each(|target| wanted[target.0] = true);
    // Consumers come after what they read.
    for (n, entry) in entries.iter_mut().enumerate().rev() {
        let (Some(entry), node) = (entry, &graph.nodes[n]) else { continue };
        let mut reads = entry.is_pending();
        if let NodeState::Cached { key, digest, is_virtual: true } = entry.state
            && wanted[n]
        {
            reads = true;
            if !node.is_virtual() {
                entry.state = NodeState::WouldRun { key, digest: Some(digest), changes: vec![Change::NotStored] };
            }
        }
        if reads {
            node.inputs().for_each(|input| wanted[input] = true);
        }
    }
}

/// Earlier runs by stage, read once.
pub(super) struct Experience<'a> {
    store: &'a Store,
    by_stage: BTreeMap<&'static str, Vec<Past>>,
    /// By stage and label: a sweep asks the same of thousands of nodes.
    estimates: BTreeMap<(&'static str, String), Estimate>,
}

/// Seconds and bytes, where there is experience.
type Estimate = (Option<f64>, Option<u64>);

impl<'a> Experience<'a> {
    pub(super) fn new(store: &'a Store) -> Self {
        Self { store, by_stage: BTreeMap::new(), estimates: BTreeMap::new() }
    }

    fn of(&mut self, stage: &'static str) -> &[Past] {
        self.by_stage.entry(stage).or_insert_with(|| self.store.history(stage))
    }

    /// The median time and size of the latest runs, under the same label if there are any.
    pub(super) fn estimate(&mut self, stage: &'static str, label: &str) -> Estimate {
        let asked = (stage, label.to_owned());
        if let Some(known) = self.estimates.get(&asked) {
            return *known;
        }
        let estimate = self.estimate_anew(stage, label);
        self.estimates.insert(asked, estimate);
        estimate
    }

    fn estimate_anew(&mut self, stage: &'static str, label: &str) -> Estimate {
        let all = self.of(stage);
        let mut latest: Vec<&Past> = all.iter().rev().filter(|past| past.label == label).take(RECENT).collect();
        if latest.is_empty() {
            latest = all.iter().rev().take(RECENT).collect();
        }
        let mut seconds: Vec<f64> = latest.iter().map(|past| past.seconds).collect();
        let mut bytes: Vec<u64> = latest.iter().map(|past| past.bytes).collect();
        seconds.sort_by(f64::total_cmp);
        bytes.sort_unstable();
        (seconds.get(seconds.len() / 2).copied(), bytes.get(bytes.len() / 2).copied())
    }
}

/// What changed at `node` against the nearest earlier run, and upstream of it: root causes first, `node` last.
pub(super) fn why(graph: &Graph, store: &Store, node: NodeId) -> Result<Vec<Step>> {
    let plan = plan(graph, store, &[node])?;
    let mut trail = Trail { graph, store, plan: &plan, seen: BTreeSet::new(), steps: Vec::new() };
    let Kind::Stage { work, .. } = &graph.nodes[node.0].kind else {
        return Err(Error::usage(format!("`{}` is a file: ask about a node that reads it", graph.label(node))));
    };
    let before = before_of(graph, store, &plan, node.0, &store.history(work.name()));
    trail.follow(node.0, before);
    Ok(trail.steps)
}

/// The earlier run that is nearest to node `n` as it is planned.
fn before_of(graph: &Graph, store: &Store, plan: &Plan, n: usize, pasts: &[Past]) -> Option<Manifest> {
    let own = match plan.entries[n].as_ref().map(|entry| &entry.state) {
        Some(NodeState::WouldRun { key, .. } | NodeState::Cached { key, .. }) => Some(*key),
        _ => None,
    };
    let now = Now::of(graph, n, &|input| plan.digest(input))?;
    nearest(store, pasts, graph.stage(NodeId(n))?, graph.label(NodeId(n)), own, &now).0
}

struct Trail<'a> {
    graph: &'a Graph,
    store: &'a Store,
    plan: &'a Plan,
    seen: BTreeSet<usize>,
    steps: Vec<Step>,
}

impl Trail<'_> {
    /// Adds node `n`, compared with `before`, after everything upstream that explains it.
    fn follow(&mut self, n: usize, before: Option<Manifest>) {
        if !self.seen.insert(n) {
            return;
        }
        let node = &self.graph.nodes[n];
        let Some(now) = Now::of(self.graph, n, &|input| self.plan.digest(input)) else { return };
        let not_stored = matches!(self.plan.entries[n].as_ref().map(|e| &e.state),
            Some(NodeState::WouldRun { changes, .. }) if changes.contains(&Change::NotStored));
        let changes = match &before {
            _ if not_stored => vec![Change::NotStored],
            Some(before) => now.changes(before),
            None => vec![Change::New],
        };
        for change in &changes {
            let Change::Input { port, node: label, from, to } = change else { continue };
            let inputs = node.ports.iter().find(|(name, _)| name == port).map_or(&[][..], |(_, inputs)| inputs);
            let Some(input) = inputs.iter().find(|input| self.graph.nodes[input.0].label == *label) else { continue };
            match &self.graph.nodes[input.0].kind {
                Kind::File(path) => {
                    if let (Some(to), true) = (to, self.seen.insert(input.0)) {
                        let change = Change::File { path: path.display().to_string(), from: *from, to: *to };
                        self.steps.push(Step { label: label.clone(), changes: vec![change], against: None });
                    }
                }
                Kind::Stage { work, .. } => {
                    let pasts = self.store.history(work.name());
                    let before = if to.is_some() {
                        // The values that were read then were made by this run.
                        let past = pasts.iter().rev().find(|past| past.digest == *from && past.label == *label);
                        let past = past.or_else(|| pasts.iter().rev().find(|past| past.digest == *from));
                        past.and_then(|past| self.store.lookup(work.name(), past.key).ok().flatten())
                    } else {
                        // What is still to run is explained by its own nearest run, as in the plan.
                        before_of(self.graph, self.store, self.plan, input.0, &pasts)
                    };
                    self.follow(input.0, before);
                }
            }
        }
        self.steps.push(Step { label: node.label.clone(), changes, against: before.map(|before| before.started) });
    }
}
