//! When work will be done: nodes laid out on threads or workers as the engine takes them.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::graph::Graph;
use super::urgency;

/// Seconds in an order.
#[derive(Clone, Copy, PartialEq)]
struct Seconds(f64);

impl Eq for Seconds {}

impl PartialOrd for Seconds {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Seconds {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// When the last node ends, seconds from now: the `open` nodes take `cost` seconds each and begin once their inputs are
/// there and one of `at_once` threads is free, the longest path first; `running` nodes end in so many seconds.
pub fn lay_out(graph: &Graph, open: &[bool], cost: &[f64], running: &[(f64, usize)], at_once: usize) -> f64 {
    let count = graph.nodes.len();
    let (mut waits, mut consumers) = (vec![0_usize; count], vec![Vec::new(); count]);
    let mut outstanding = open.to_vec();
    running.iter().for_each(|&(_, n)| outstanding[n] = true);
    let places = urgency::places(graph, &cost.iter().map(|&seconds| Some(seconds)).collect::<Vec<_>>());
    let mut ready = BTreeSet::new();
    for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| open[*n]) {
        for input in node.inputs().filter(|input| outstanding[*input]) {
            waits[n] += 1;
            consumers[input].push(n);
        }
        if waits[n] == 0 {
            ready.insert((places[n], n));
        }
    }
    let mut ends: BinaryHeap<_> = running.iter().map(|&(end, n)| Reverse((Seconds(end), n))).collect();
    let mut time = 0.0;
    loop {
        while ends.len() < at_once.max(1)
            && let Some((_, n)) = ready.pop_first()
        {
            ends.push(Reverse((Seconds(time + cost[n]), n)));
        }
        let Some(Reverse((Seconds(end), n))) = ends.pop() else { return time };
        time = end;
        for &consumer in &consumers[n] {
            waits[consumer] -= 1;
            if waits[consumer] == 0 {
                ready.insert((places[consumer], consumer));
            }
        }
    }
}
