//! How long a run will still take, by experience.
//!
//! A node is expected to take the time that it took before (the median of the latest runs under its label, or else of
//! its stage), times how this run's nodes of that stage compare with their own expectations; a stage without a past
//! takes what its nodes took in this run. Outstanding nodes are then laid out on the threads in the order in which the
//! engine takes them, inputs before consumers: the end of the last is the time left. Nodes that turn out to be in the
//! store drop out as they are found.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::event::Event;
use super::graph::{Graph, Kind, NodeId};
use super::layout::lay_out;
use super::plan::Experience;
use crate::store::Store;

/// A run is at least and at most so many times as fast as experience says.
const FACTOR: (f64, f64) = (0.05, 20.0);

/// Evidence on the speed of the whole run weighs against this share of its work at the speed of experience.
const PRIOR_SHARE: f64 = 0.02;

/// A running node is never thought to be nearer to its end than this share of its time.
const LAST_SHARE: f64 = 0.05;

#[derive(Clone, Copy, PartialEq)]
enum State {
    Open,
    Running { since: Instant, share: f64 },
    Done,
}

/// Measured and expected seconds of the nodes that finished.
#[derive(Default, Clone, Copy)]
struct Tally {
    measured: f64,
    expected: f64,
    /// Seconds and number of all that finished, expected or not.
    seconds: f64,
    count: usize,
}

impl Tally {
    /// How this run compares with experience; `prior` seconds at the factor `as_before` stand beside what was measured,
    /// so that little evidence counts little.
    fn factor(&self, prior: f64, as_before: f64) -> f64 {
        let expected = self.expected + prior;
        let factor = (self.measured + prior * as_before) / expected;
        if expected > 0.0 { factor.clamp(FACTOR.0, FACTOR.1) } else { as_before }
    }
}

/// Follows the events of one run.
pub struct Remaining<'a> {
    graph: &'a Graph,
    store: &'a Store,
    threads: usize,
    states: Vec<State>,
    /// By experience, seconds; read when the first node begins.
    expected: Option<Vec<Option<f64>>>,
    /// Seconds of all nodes that were outstanding then.
    whole: f64,
    by_stage: BTreeMap<&'static str, Tally>,
    all: Tally,
}

impl<'a> Remaining<'a> {
    /// A run of `targets` on `threads` threads.
    pub fn new(graph: &'a Graph, store: &'a Store, targets: &[NodeId], threads: usize) -> Self {
        let state = |(node, reached): (NodeId, bool)| {
            if reached && graph.stage(node).is_some() { State::Open } else { State::Done }
        };
        let states = graph.nodes().zip(graph.upstream(targets)).map(state).collect();
        let (by_stage, all, threads) = (BTreeMap::new(), Tally::default(), threads.max(1));
        Self { graph, store, threads, states, expected: None, whole: 0.0, by_stage, all }
    }

    /// Takes an event that happened at `now`.
    pub fn take(&mut self, event: &Event, now: Instant) {
        match event {
            Event::Started { node, .. } => {
                if self.expected.is_none() {
                    let all = experience(self.graph, self.store);
                    let open = self.states.iter().zip(&all).filter(|(state, _)| **state != State::Done);
                    self.whole = open.filter_map(|(_, seconds)| *seconds).sum();
                    self.expected = Some(all);
                }
                self.states[node.0] = State::Running { since: now, share: 0.0 };
            }
            Event::Progress { node, done, total } if *total > 0 => {
                if let State::Running { share, .. } = &mut self.states[node.0] {
                    *share = (*done as f64 / *total as f64).min(1.0);
                }
            }
            Event::Finished { node, .. } => {
                // As in the history: with publishing.
                let State::Running { since, .. } = std::mem::replace(&mut self.states[node.0], State::Done) else {
                    return;
                };
                let seconds = now.saturating_duration_since(since).as_secs_f64();
                let expected = self.expected.as_ref().and_then(|all| all[node.0]);
                let stage = self.graph.stage(*node).unwrap_or_default();
                for tally in [self.by_stage.entry(stage).or_default(), &mut self.all] {
                    tally.seconds += seconds;
                    tally.count += 1;
                    if let Some(expected) = expected {
                        tally.measured += seconds;
                        tally.expected += expected;
                    }
                }
            }
            Event::Hit { node, .. } | Event::Failed { node, .. } | Event::Skipped { node } => {
                self.states[node.0] = State::Done;
            }
            _ => {}
        }
    }

    /// Seconds that node `n` will take in all; `None` where nothing is known.
    fn seconds(&self, n: usize) -> Option<f64> {
        let tally = self.by_stage.get(self.graph.stage(NodeId(n))?);
        match self.expected.as_ref().and_then(|all| all[n]) {
            Some(expected) => {
                let of_run = self.all.factor(PRIOR_SHARE * self.whole, 1.0);
                Some(expected * tally.map_or(of_run, |tally| tally.factor(expected, of_run)))
            }
            None => tally.filter(|t| t.count > 0).map(|t| t.seconds / t.count as f64),
        }
    }

    /// The time left at `now`, and whether every outstanding node is known; `None` before the first node begins.
    pub fn left(&self, now: Instant) -> Option<(Duration, bool)> {
        self.expected.as_ref()?;
        let mut all_known = true;
        let mut cost = vec![0.0; self.states.len()];
        let mut running = Vec::new();
        for (n, state) in self.states.iter().enumerate() {
            if *state == State::Done {
                continue;
            }
            let seconds = self.seconds(n);
            all_known &= seconds.is_some();
            cost[n] = seconds.unwrap_or(0.0);
            if let State::Running { since, share } = *state {
                let ran = now.saturating_duration_since(since).as_secs_f64();
                // Its own progress is the better witness the farther it is.
                let by_progress = if share > 0.0 { ran / share - ran } else { cost[n] - ran };
                let left = share * by_progress + (1.0 - share) * (cost[n] - ran);
                running.push((left.max(LAST_SHARE * cost[n]), n));
            }
        }
        let open: Vec<bool> = self.states.iter().map(|state| *state == State::Open).collect();
        let left = lay_out(self.graph, &open, &cost, &running, self.threads);
        Some((Duration::from_secs_f64(left), all_known))
    }
}

/// Seconds that every node takes by experience.
pub(super) fn experience(graph: &Graph, store: &Store) -> Vec<Option<f64>> {
    let mut experience = Experience::new(store);
    let of_node = |node: &super::graph::Node| match &node.kind {
        Kind::Stage { work, .. } => experience.estimate(work.name(), &node.label).0,
        Kind::File(_) => None,
    };
    graph.nodes.iter().map(of_node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flow::{Inputs, Output, Progress, Stage};
    use crate::store::Digest;

    #[derive(serde::Serialize)]
    struct Nap(usize);

    impl Stage for Nap {
        const NAME: &'static str = "nap";
        const VERSION: u32 = 1;

        fn run(&self, _: &Inputs, _: &mut Output, _: &Progress) -> crate::Result<()> {
            Ok(())
        }
    }

    fn finished(node: NodeId, seconds: f64) -> Event {
        Event::Finished {
            node,
            seconds,
            digest: Digest([0; 32]),
            same_output: false,
            in_vain: false,
            warnings: Vec::new(),
        }
    }

    #[test]
    fn outstanding_nodes_are_laid_out_on_the_threads() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        let mut graph = Graph::new();
        let naps: Vec<NodeId> = (0..6).map(|n| graph.add(&format!("nap/{n}"), Nap(n), &[])).collect();
        let last = graph.add("last", Nap(9), &[("naps", &naps)]);
        let mut remaining = Remaining::new(&graph, &store, &[last], 2);
        let begin = Instant::now();
        assert!(remaining.left(begin).is_none(), "nothing has begun");
        remaining.take(&Event::Started { node: naps[0], why: Vec::new() }, begin);
        assert_eq!(remaining.left(begin).map(|(_, all_known)| all_known), Some(false));
        let later = begin + Duration::from_secs(2);
        remaining.take(&finished(naps[0], 2.0), later);
        remaining.take(&Event::Hit { node: naps[1], key: Digest([0; 32]), warnings: Vec::new() }, later);
        // Four naps on two threads, then the last: 3 * 2 s.
        assert_eq!(remaining.left(later), Some((Duration::from_secs(6), true)));
        remaining.take(&Event::Started { node: naps[2], why: Vec::new() }, later);
        remaining.take(&Event::Progress { node: naps[2], done: 1, total: 2 }, later + Duration::from_secs(1));
        let (left, _) = remaining.left(later + Duration::from_secs(1)).unwrap();
        // The halved nap ends after 1 s; beside and after it run three, then the last.
        assert_eq!(left, Duration::from_secs(6));
        for nap in &naps[2..] {
            remaining.take(&finished(*nap, 2.0), later);
        }
        remaining.take(&finished(last, 2.0), later);
        assert_eq!(remaining.left(later), Some((Duration::ZERO, true)));
    }
}
