//! Which nodes must run, and when: the state of every node during a run.
//!
//! A node is *wanted* for its digest (its consumers' keys need it) or for its values (a consumer runs, or it is a
//! target). Wants travel upstream only as far as needed: below a hit nothing is wanted but digests.

use std::collections::{BTreeMap, BTreeSet};

use super::event::Event;
use super::found::{self, Found};
use super::graph::{Graph, Kind, NodeId};
use super::remaining::experience;
use super::urgency;
use crate::error::{Error, Result};
use crate::store::{Artefact, Claim, Digest, Held, Key, Manifest, Store};

/// So many nodes that others are at are asked for one by one, further ones at growing distances.
const ASKED_IN_TURN: usize = 8;

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
    /// Its values are in a store far away.
    pub(super) is_far: bool,
    /// It was told that the store has it.
    pub(super) hit: bool,
    /// What the store said of it before the run began.
    asked: Option<Found>,
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
    /// Nodes that can run, with their places in the order of urgency.
    pub(super) ready: BTreeSet<(usize, usize)>,
    /// The place of every node in that order; known once a node is to run.
    places: Option<Vec<usize>>,
    /// Nodes being run, by name of their work; others of the same name wait for them.
    in_work: BTreeMap<Key, usize>,
    pub(super) errors: Vec<(NodeId, Error)>,
    /// Works that are on record as failed.
    failed_before: BTreeSet<Key>,
    /// The log of this process, for the record of failures.
    pub(super) log: Option<String>,
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
            is_far: false,
            hit: false,
            asked: None,
            waiting: false,
            announced: false,
        };
        let slots = graph.nodes.iter().map(|_| slot()).collect();
        let (ready, in_work) = (BTreeSet::new(), BTreeMap::new());
        let failed_before = store.failures().into_iter().map(|(name, _)| name).collect();
        let (errors, places, log) = (Vec::new(), None, None);
        Self { graph, store, consumers, slots, ready, places, in_work, errors, failed_before, log, emit }
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

    /// Asks the store for all of `reached` whose keys follow from the files. What it does not hold is asked for again in its turn: another
    /// process may have computed it.
    pub(super) fn ask_store(&mut self, reached: &[bool]) {
        let mut digests: Vec<Option<Digest>> = self.slots.iter().map(|slot| slot.digest).collect();
        let all = found::find(self.graph, self.store, reached, &mut digests);
        for (slot, found) in self.slots.iter_mut().zip(all) {
            slot.asked = found.and_then(Result::ok);
        }
    }

    /// Marks `n` as failed; everything that needs it will be skipped.
    pub(super) fn fail(&mut self, n: usize, error: Error) {
        self.slots[n].phase = Phase::Broken;
        if error.kind != crate::error::Kind::Interrupted {
            let label = &self.graph.nodes[n].label;
            if let Some(name) = self.work_name(n) {
                self.store.record_failure(name, label, &error.to_string(), self.log.as_deref());
            }
            let error = error.at(label);
            (self.emit)(&Event::Failed { node: NodeId(n), error: error.clone() });
            self.errors.push((NodeId(n), error));
        }
        self.release(n);
        self.advance_consumers(n);
    }

    /// Notes the result of a node that ran or was found after waiting.
    pub(super) fn finish(&mut self, n: usize, manifest: Manifest, artefact: Option<Artefact>) {
        self.slots[n].phase = Phase::Open;
        self.work_name(n).inspect(|&name| self.store.forget_failure(name));
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

    /// Notes that the values of `n` could not be fetched: it is computed.
    pub(super) fn lost(&mut self, n: usize) {
        self.slots[n].phase = Phase::Open;
        self.slots[n].is_far = false;
        self.release(n);
        self.advance(n);
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
        let is_far = self.slots[n].is_far;
        if !is_far {
            for input in node.inputs() {
                self.raise(input, Want::Stream);
            }
        }
        if !self.at_rest(n) && (is_far || node.inputs().all(|input| self.readable(input))) {
            self.slots[n].phase = Phase::Queued;
            let places =
                self.places.get_or_insert_with(|| urgency::places(self.graph, &experience(self.graph, self.store)));
            self.ready.insert((places[n], n));
        }
    }

    /// Computes the key and asks the store; true if nothing more is to be done.
    fn look_up(&mut self, n: usize) -> bool {
        let Kind::Stage { work, .. } = &self.graph.nodes[n].kind else { return true };
        let found = self.key_of(n).and_then(|key| {
            self.slots[n].key = Some(key);
            let asked = self.slots[n].asked.take().filter(|found| found.key == key);
            let manifest = match asked.and_then(|found| found.manifest) {
                Some(manifest) => Some(manifest),
                None => self.store.lookup(work.name(), key)?,
            };
            let Some(manifest) = manifest else { return Ok(None) };
            self.slots[n].is_far = self.store.is_far(&manifest);
            let is_at_hand = !(manifest.is_virtual || self.slots[n].is_far);
            Ok(Some((if is_at_hand { Some(self.store.artefact(&manifest)?) } else { None }, manifest)))
        });
        match found {
            Err(error) => {
                self.fail(n, error);
                true
            }
            Ok(None) => false,
            Ok(Some((artefact, manifest))) => {
                let done = artefact.is_some() || self.slots[n].want <= Want::Digest;
                // What is far is not had before it is here.
                if done || !self.slots[n].is_far {
                    self.slots[n].hit = true;
                    let warnings = manifest.warnings.clone();
                    (self.emit)(&Event::Hit { node: NodeId(n), key: manifest.key, warnings });
                }
                self.store.touch(work.name(), manifest.key);
                if !self.failed_before.is_empty() {
                    let name = self.work_name(n).filter(|name| self.failed_before.contains(name));
                    name.inspect(|&name| self.store.forget_failure(name));
                }
                self.know(n, manifest, artefact);
                self.advance_consumers(n);
                done
            }
        }
    }

    /// The key of a stage node all of whose inputs have known digests.
    pub(super) fn key_of(&self, n: usize) -> Result<Key> {
        found::key_of(self.graph, n, |input| self.slots[input].digest)?
            .ok_or_else(|| Error::failed(format!("an input of `{}` is not known", self.graph.nodes[n].label)))
    }

    /// The name under which the work of node `n` is claimed: its key, or, where it reads what is streamed, the key that
    /// it would have if that had its own name as its digest. So the name is known before anything was streamed, and is
    /// the same in every process.
    pub(super) fn work_name(&self, n: usize) -> Option<Key> {
        let node = &self.graph.nodes[n];
        if !node.inputs().any(|input| self.graph.nodes[input].is_virtual()) {
            return self.slots[n].key.or_else(|| self.key_of(n).ok());
        }
        let of_input = |input: usize| match self.graph.nodes[input].is_virtual() {
            true => self.work_name(input),
            false => self.slots[input].digest,
        };
        found::key_of(self.graph, n, of_input).ok().flatten()
    }

    /// Looks whether other processes learned the digests of what node `n` would stream, and with them its key.
    fn learn(&mut self, n: usize) {
        let inputs: Vec<usize> = self.graph.nodes[n].inputs().collect();
        for &input in &inputs {
            if self.slots[input].digest.is_some() {
                continue;
            }
            self.learn(input);
            let Kind::Stage { work, .. } = &self.graph.nodes[input].kind else { continue };
            if let Some(key) = self.slots[input].key
                && let Ok(Some(manifest)) = self.store.lookup(work.name(), key)
            {
                self.know(input, manifest, None);
                self.advance_consumers(input);
            }
        }
        if self.slots[n].key.is_none() && inputs.iter().all(|&input| self.slots[input].digest.is_some()) {
            self.slots[n].key = self.key_of(n).ok();
        }
    }

    /// Takes the most urgent of the ready nodes that fit into `free` bytes, or any if nothing is running, and that no
    /// other process is at; `only_far`: of those that are fetched.
    pub(super) fn take(&mut self, free: u64, idle: bool, only_far: bool) -> Taken {
        let mut busy: Vec<usize> = Vec::new();
        let ready: Vec<(usize, usize)> = self.ready.iter().copied().collect();
        let (mut at, mut stride) = (0, 1);
        while let Some(&(place, n)) = ready.get(at) {
            at += 1;
            let Kind::Stage { work, .. } = &self.graph.nodes[n].kind else { continue };
            let is_far = self.slots[n].is_far;
            if only_far && !is_far {
                continue;
            }
            let (name, bytes) = (self.work_name(n), if is_far { 0 } else { work.peak_bytes() });
            if !(idle || bytes <= free) || name.is_some_and(|name| self.in_work.contains_key(&name)) {
                continue;
            }
            let held = match name.map(|name| self.store.claim(name, &self.graph.nodes[n].label)) {
                None => None,
                Some(Claim::Ours(held)) => Some(held),
                Some(Claim::Busy) => {
                    busy.push(n);
                    // Where hundreds are at the most urgent nodes, asking for each would keep a file server busy.
                    if busy.len() > ASKED_IN_TURN {
                        at += rand::random_range(0..stride);
                        stride *= 2;
                    }
                    continue;
                }
            };
            if self.slots[n].key.is_none() {
                self.learn(n);
            }
            self.ready.remove(&(place, n));
            self.slots[n].phase = Phase::Running;
            self.in_work.extend(name.map(|name| (name, n)));
            return Taken::Node { n, bytes, held };
        }
        for &n in &busy {
            if !std::mem::replace(&mut self.slots[n].waiting, true) {
                (self.emit)(&Event::Waiting { node: NodeId(n) });
            }
        }
        if busy.is_empty() { Taken::Nothing } else { Taken::AllBusy }
    }
}
