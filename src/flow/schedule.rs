//! Which nodes must run, and when: the state of every node during a run.
//!
//! A node is *wanted* for its digest (its consumers' keys need it) or for its values (a consumer runs, or it is a
//! target). Wants travel upstream only as far as needed: below a hit nothing is wanted but digests.

use std::collections::{BTreeMap, BTreeSet};

use super::event::Event;
use super::graph::{Graph, Kind, NodeId};
use super::key::key;
use crate::error::{Error, Result};
use crate::store::{Artefact, Claim, Digest, Held, Key, Manifest, Store};

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(super) enum Want {
    Nothing,
    Digest,
    /// Values, but they may be computed while they are read.
    Stream,
    Values,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Phase {
    Open,
    Queued,
    Running,
    /// Failed or skipped.
    Broken,
}

pub(super) struct Slot {
    pub(super) want: Want,
    pub(super) phase: Phase,
    pub(super) key: Option<Key>,
    pub(super) digest: Option<Digest>,
    pub(super) artefact: Option<Artefact>,
    pub(super) manifest: Option<Manifest>,
    pub(super) ran: bool,
    /// Another process was found to be at it.
    waiting: bool,
    /// Consumers know that this virtual node can be read.
    announced: bool,
}

/// The answer to a worker that asks for a node.
pub(super) enum Taken {
    /// This one, which may hold so many bytes, claimed where its key is known.
    Node { n: usize, bytes: u64, held: Option<Held> },
    /// What is ready is being computed by other processes.
    AllBusy,
    /// Nothing is ready.
    Nothing,
}

/// The nodes of a run and what is known of them.
pub(super) struct Schedule<'a> {
    graph: &'a Graph,
    store: &'a Store,
    consumers: Vec<Vec<usize>>,
    pub(super) slots: Vec<Slot>,
    pub(super) ready: BTreeSet<usize>,
    /// Nodes being run, by key; others with the same key wait for them.
    in_work: BTreeMap<Key, usize>,
    pub(super) errors: Vec<(NodeId, Error)>,
    pub(super) emit: &'a (dyn Fn(&Event) + Sync),
}

impl<'a> Schedule<'a> {
    pub(super) fn new(graph: &'a Graph, store: &'a Store, emit: &'a (dyn Fn(&Event) + Sync)) -> Self {
        let mut consumers = vec![Vec::new(); graph.nodes.len()];
        for (n, node) in graph.nodes.iter().enumerate() {
            for input in node.inputs() {
                if consumers[input].last() != Some(&n) {
                    consumers[input].push(n);
                }
            }
        }
        let slot = || Slot {
            want: Want::Nothing,
            phase: Phase::Open,
            key: None,
            digest: None,
            artefact: None,
            manifest: None,
            ran: false,
            waiting: false,
            announced: false,
        };
        let slots = graph.nodes.iter().map(|_| slot()).collect();
        let (ready, in_work) = (BTreeSet::new(), BTreeMap::new());
        Self { graph, store, consumers, slots, ready, in_work, errors: Vec::new(), emit }
    }

    /// Notes what a file holds.
    pub(super) fn file_known(&mut self, n: usize, found: Result<Artefact>) {
        match found {
            Ok(artefact) => {
                self.slots[n].digest = Some(artefact.digest());
                self.slots[n].artefact = Some(artefact);
            }
            Err(error) => self.fail(n, error),
        }
    }

    /// Marks `n` as failed; everything that needs it will be skipped.
    pub(super) fn fail(&mut self, n: usize, error: Error) {
        self.slots[n].phase = Phase::Broken;
        if error.kind != crate::error::Kind::Interrupted {
            let error = error.at(&self.graph.nodes[n].label);
            (self.emit)(&Event::Failed { node: NodeId(n), error: error.clone() });
            self.errors.push((NodeId(n), error));
        }
        self.release(n);
        self.advance_consumers(n);
    }

    /// Notes the result of a node that ran or was found after waiting.
    pub(super) fn finish(&mut self, n: usize, manifest: Manifest, artefact: Option<Artefact>) {
        self.slots[n].phase = Phase::Open;
        self.know(n, manifest, artefact);
        self.release(n);
        self.advance_consumers(n);
    }

    pub(super) fn know(&mut self, n: usize, manifest: Manifest, artefact: Option<Artefact>) {
        let slot = &mut self.slots[n];
        slot.key = Some(manifest.key);
        slot.digest = Some(manifest.digest);
        slot.artefact = artefact;
        slot.manifest = Some(manifest);
    }

    fn release(&mut self, n: usize) {
        self.in_work.retain(|_, node| *node != n);
        // Nodes with the same key wait in `ready`; whoever takes one looks into the store again.
    }

    pub(super) fn advance_consumers(&mut self, n: usize) {
        for consumer in self.consumers[n].clone() {
            self.advance(consumer);
        }
    }

    /// Wants at least `want` of node `n`.
    pub(super) fn raise(&mut self, n: usize, want: Want) {
        if self.slots[n].want < want {
            self.slots[n].want = want;
            self.advance(n);
        }
    }

    /// Whether a consumer of `n` can read its values now.
    pub(super) fn readable(&self, n: usize) -> bool {
        let node = &self.graph.nodes[n];
        self.slots[n].artefact.is_some() || (node.is_virtual() && node.inputs().all(|input| self.readable(input)))
    }

    /// Whether there is nothing to do for node `n` now: not wanted, at work, broken, or all that is wanted is known.
    fn at_rest(&self, n: usize) -> bool {
        let slot = &self.slots[n];
        let satisfied = slot.artefact.is_some() || (slot.want <= Want::Digest && slot.digest.is_some());
        slot.want == Want::Nothing || slot.phase != Phase::Open || satisfied
    }

    /// Takes node `n` as far as it goes with what is known.
    pub(super) fn advance(&mut self, n: usize) {
        let node = &self.graph.nodes[n];
        if self.at_rest(n) {
            return;
        }
        if node.inputs().any(|input| self.slots[input].phase == Phase::Broken) {
            self.slots[n].phase = Phase::Broken;
            (self.emit)(&Event::Skipped { node: NodeId(n) });
            self.advance_consumers(n);
            return;
        }
        if self.slots[n].key.is_none() {
            for input in node.inputs() {
                self.raise(input, Want::Digest);
            }
            if self.at_rest(n) {
                return; // Raising an input came back here.
            }
            if node.inputs().all(|input| self.slots[input].digest.is_some()) {
                if self.slots[n].key.is_none() && self.look_up(n) {
                    return;
                }
            } else if node
                .inputs()
                .any(|input| self.slots[input].digest.is_none() && !self.graph.nodes[input].is_virtual())
            {
                return;
            }
        }
        let want = self.slots[n].want;
        if node.is_virtual() && want <= Want::Stream {
            if want == Want::Stream {
                for input in node.inputs() {
                    self.raise(input, Want::Stream);
                }
                if self.readable(n) && !self.slots[n].announced {
                    self.slots[n].announced = true;
                    self.advance_consumers(n);
                }
            } else {
                // The digest can only be learned by streaming: consumers go on without it.
                self.advance_consumers(n);
            }
            return;
        }
        for input in node.inputs() {
            self.raise(input, Want::Stream);
        }
        if !self.at_rest(n) && node.inputs().all(|input| self.readable(input)) {
            self.slots[n].phase = Phase::Queued;
            self.ready.insert(n);
        }
    }

    /// Computes the key and asks the store; true if nothing more is to be done.
    fn look_up(&mut self, n: usize) -> bool {
        let Kind::Stage { work, .. } = &self.graph.nodes[n].kind else { return true };
        let found = self.key_of(n).and_then(|key| {
            self.slots[n].key = Some(key);
            let manifest = self.store.lookup(work.name(), key)?;
            manifest.map(|m| Ok((if m.is_virtual { None } else { Some(self.store.artefact(&m)?) }, m))).transpose()
        });
        match found {
            Err(error) => {
                self.fail(n, error);
                true
            }
            Ok(None) => false,
            Ok(Some((artefact, manifest))) => {
                let done = artefact.is_some() || self.slots[n].want <= Want::Digest;
                (self.emit)(&Event::Hit { node: NodeId(n), key: manifest.key, warnings: manifest.warnings.clone() });
                self.store.touch(work.name(), manifest.key);
                self.know(n, manifest, artefact);
                self.advance_consumers(n);
                done
            }
        }
    }

    /// The key of a stage node all of whose inputs have known digests.
    pub(super) fn key_of(&self, n: usize) -> Result<Key> {
        let node = &self.graph.nodes[n];
        let Kind::Stage { work, params, .. } = &node.kind else {
            return Err(Error::failed(format!("`{}` is a file and has no key", node.label)));
        };
        let params = params.as_ref().map_err(Clone::clone)?;
        let mut ports = Vec::new();
        for (port, inputs) in &node.ports {
            let digests: Option<Vec<Digest>> = inputs.iter().map(|input| self.slots[input.0].digest).collect();
            let digests = digests.ok_or_else(|| Error::failed(format!("an input of `{}` is not known", node.label)))?;
            ports.push((port.as_str(), digests));
        }
        Ok(key(work.name(), work.version(), params, &ports))
    }

    /// Takes a ready node that fits into `free` bytes, or any if nothing is running, and that no other process is at.
    pub(super) fn take(&mut self, free: u64, idle: bool) -> Taken {
        let mut busy = false;
        for n in self.ready.iter().copied().collect::<Vec<_>>() {
            let Kind::Stage { work, .. } = &self.graph.nodes[n].kind else { continue };
            let (key, bytes) = (self.slots[n].key, work.peak_bytes());
            if !(idle || bytes <= free) || key.is_some_and(|key| self.in_work.contains_key(&key)) {
                continue;
            }
            let held = match key.map(|key| self.store.claim(key)) {
                None => None,
                Some(Claim::Ours(held)) => Some(held),
                Some(Claim::Busy) => {
                    busy = true;
                    if !std::mem::replace(&mut self.slots[n].waiting, true) {
                        (self.emit)(&Event::Waiting { node: NodeId(n) });
                    }
                    continue;
                }
            };
            self.ready.remove(&n);
            self.slots[n].phase = Phase::Running;
            self.in_work.extend(key.map(|key| (key, n)));
            return Taken::Node { n, bytes, held };
        }
        if busy { Taken::AllBusy } else { Taken::Nothing }
    }
}
