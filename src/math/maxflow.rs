//! Largest flow and least cut between a source and a sink, for graphs of pixels.
//!
//! Y. Boykov, V. Kolmogorov, IEEE TPAMI 26 (2004) 1124: a tree grows from either terminal over arcs that still take
//! flow; where they touch, a path is filled; nodes cut off by that look for a new parent in their own tree or become
//! free. On pixel graphs, with their short paths, this takes a few passes over the arcs. Adopting nodes check that a
//! new parent still hangs on its terminal. Capacities are finite and at least 0; the order of work is fixed by the
//! order in which arcs were added.

use std::collections::VecDeque;

const NONE: u32 = u32::MAX;
/// Parent marks of nodes that hang on their terminal itself, or have lost their parent.
const TERMINAL: u32 = u32::MAX - 1;
const ORPHAN: u32 = u32::MAX - 2;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Tree {
    Free,
    Source,
    Sink,
}

/// A graph whose nodes hang between a source and a sink.
#[derive(Debug, Clone)]
pub struct Graph {
    /// First arc of each node; arcs chain by `next`.
    first: Vec<u32>,
    next: Vec<u32>,
    to: Vec<u32>,
    /// What an arc still takes; arcs 2k and 2k + 1 are each other's reverse.
    residual: Vec<f64>,
    /// What the arc from the source (positive) or to the sink (negative) still takes.
    terminal: Vec<f64>,
    flow: f64,
}

impl Graph {
    /// `nodes` nodes without arcs.
    pub fn new(nodes: usize) -> Self {
        Self {
            first: vec![NONE; nodes],
            next: Vec::new(),
            to: Vec::new(),
            residual: Vec::new(),
            terminal: vec![0.0; nodes],
            flow: 0.0,
        }
    }

    /// Adds capacity from the source to the node and from the node to the sink.
    pub fn terminals(&mut self, node: usize, from_source: f64, to_sink: f64) {
        let (mut source, mut sink) = (from_source, to_sink);
        let left = self.terminal[node];
        if left > 0.0 {
            source += left;
        } else {
            sink -= left;
        }
        self.flow += source.min(sink);
        self.terminal[node] = source - sink;
    }

    /// Adds capacity between two nodes, one way and the other.
    pub fn arc(&mut self, from: usize, to: usize, capacity: f64, reverse: f64) {
        for (a, b, c) in [(from, to, capacity), (to, from, reverse)] {
            let arc = self.to.len() as u32;
            self.next.push(self.first[a]);
            self.first[a] = arc;
            self.to.push(b as u32);
            self.residual.push(c);
        }
    }

    /// Fills the graph; returns the flow and, per node, whether it lies on the source's side of a least cut (nodes that
    /// could lie on either are on the sink's).
    pub fn solve(self) -> (f64, Vec<bool>) {
        let mut search = Search::new(self);
        while let Some(bridge) = search.grow() {
            search.augment(bridge);
            search.adopt();
        }
        let sides = search.tree.iter().map(|t| *t == Tree::Source).collect();
        (search.graph.flow, sides)
    }
}

struct Search {
    graph: Graph,
    tree: Vec<Tree>,
    /// Arc from a node to its parent, or a mark.
    parent: Vec<u32>,
    active: VecDeque<u32>,
    is_active: Vec<bool>,
    orphans: VecDeque<u32>,
    /// When, and how far from its terminal, a node was last seen to hang on it.
    seen: Vec<u32>,
    depth: Vec<u32>,
    time: u32,
}

impl Search {
    fn new(graph: Graph) -> Self {
        let n = graph.first.len();
        let mut s = Self {
            tree: vec![Tree::Free; n],
            parent: vec![NONE; n],
            active: VecDeque::new(),
            is_active: vec![false; n],
            orphans: VecDeque::new(),
            seen: vec![0; n],
            depth: vec![0; n],
            time: 0,
            graph,
        };
        for node in 0..n {
            let left = s.graph.terminal[node];
            if left != 0.0 {
                s.tree[node] = if left > 0.0 { Tree::Source } else { Tree::Sink };
                s.parent[node] = TERMINAL;
                s.depth[node] = 1;
                s.activate(node as u32);
            }
        }
        s
    }

    fn activate(&mut self, node: u32) {
        if !self.is_active[node as usize] {
            self.is_active[node as usize] = true;
            self.active.push_back(node);
        }
    }

    /// What flows from the tree's parent side over `arc` (an arc of the parent towards its child in the source's tree,
    /// against it in the sink's).
    fn takes(&self, tree: Tree, arc: u32) -> bool {
        self.graph.residual[(if tree == Tree::Source { arc } else { arc ^ 1 }) as usize] > 0.0
    }

    /// Grows both trees until they touch: an arc from the source's tree to the sink's.
    fn grow(&mut self) -> Option<u32> {
        while let Some(&node) = self.active.front() {
            let p = node as usize;
            let tree = self.tree[p];
            if tree != Tree::Free {
                let mut arc = self.graph.first[p];
                while arc != NONE {
                    let q = self.graph.to[arc as usize] as usize;
                    if self.takes(tree, arc) {
                        if self.tree[q] == Tree::Free {
                            self.tree[q] = tree;
                            self.parent[q] = arc ^ 1;
                            self.seen[q] = self.seen[p];
                            self.depth[q] = self.depth[p] + 1;
                            self.activate(q as u32);
                        } else if self.tree[q] != tree {
                            return Some(if tree == Tree::Source { arc } else { arc ^ 1 });
                        } else if self.seen[q] <= self.seen[p] && self.depth[q] > self.depth[p] + 1 {
                            // A shorter way to the terminal.
                            self.parent[q] = arc ^ 1;
                            self.seen[q] = self.seen[p];
                            self.depth[q] = self.depth[p] + 1;
                        }
                    }
                    arc = self.graph.next[arc as usize];
                }
            }
            self.active.pop_front();
            self.is_active[p] = false;
        }
        None
    }

    /// Fills the path over the bridge; nodes whose arc to their parent is full become orphans.
    fn augment(&mut self, bridge: u32) {
        let ends = [self.graph.to[(bridge ^ 1) as usize] as usize, self.graph.to[bridge as usize] as usize];
        let mut least = self.graph.residual[bridge as usize];
        for (side, end) in ends.into_iter().enumerate() {
            let mut p = end;
            while self.parent[p] != TERMINAL {
                let up = self.parent[p];
                least = least.min(self.graph.residual[(if side == 0 { up ^ 1 } else { up }) as usize]);
                p = self.graph.to[up as usize] as usize;
            }
            least = least.min(self.graph.terminal[p].abs());
        }
        self.graph.residual[bridge as usize] -= least;
        self.graph.residual[(bridge ^ 1) as usize] += least;
        for (side, end) in ends.into_iter().enumerate() {
            let mut p = end;
            while self.parent[p] != TERMINAL {
                let up = self.parent[p];
                let down = if side == 0 { up ^ 1 } else { up };
                self.graph.residual[down as usize] -= least;
                self.graph.residual[(down ^ 1) as usize] += least;
                if self.graph.residual[down as usize] <= 0.0 {
                    self.parent[p] = ORPHAN;
                    self.orphans.push_front(p as u32);
                }
                p = self.graph.to[up as usize] as usize;
            }
            let left = &mut self.graph.terminal[p];
            *left -= least.copysign(*left);
            if *left == 0.0 {
                self.parent[p] = ORPHAN;
                self.orphans.push_front(p as u32);
            }
        }
        self.graph.flow += least;
    }

    /// How far the node hangs from its terminal; `None` where it hangs on an orphan. Marks the way.
    fn hangs(&mut self, node: usize) -> Option<u32> {
        let (mut p, mut steps) = (node, 0);
        let depth = loop {
            if self.seen[p] == self.time {
                break self.depth[p] + steps;
            }
            match self.parent[p] {
                TERMINAL => {
                    self.seen[p] = self.time;
                    self.depth[p] = 1;
                    break 1 + steps;
                }
                ORPHAN | NONE => return None,
                up => p = self.graph.to[up as usize] as usize,
            }
            steps += 1;
        };
        let (mut p, mut d) = (node, depth);
        while self.seen[p] != self.time {
            self.seen[p] = self.time;
            self.depth[p] = d;
            d -= 1;
            p = self.graph.to[self.parent[p] as usize] as usize;
        }
        Some(depth)
    }

    /// Finds every orphan a parent in its tree, or lets it go.
    fn adopt(&mut self) {
        self.time += 1;
        while let Some(orphan) = self.orphans.pop_front() {
            let p = orphan as usize;
            let tree = self.tree[p];
            let mut best: Option<(u32, u32)> = None;
            let mut arc = self.graph.first[p];
            while arc != NONE {
                let q = self.graph.to[arc as usize] as usize;
                // From the would-be parent to the orphan.
                if self.tree[q] == tree
                    && self.takes(tree, arc ^ 1)
                    && let Some(depth) = self.hangs(q)
                    && best.is_none_or(|(d, _)| depth < d)
                {
                    best = Some((depth, arc));
                }
                arc = self.graph.next[arc as usize];
            }
            if let Some((depth, arc)) = best {
                self.parent[p] = arc;
                self.seen[p] = self.time;
                self.depth[p] = depth + 1;
                continue;
            }
            let mut arc = self.graph.first[p];
            while arc != NONE {
                let q = self.graph.to[arc as usize] as usize;
                if self.tree[q] == tree {
                    if self.takes(tree, arc ^ 1) {
                        self.activate(q as u32);
                    }
                    if self.parent[q] == arc ^ 1 {
                        self.parent[q] = ORPHAN;
                        self.orphans.push_back(q as u32);
                    }
                }
                arc = self.graph.next[arc as usize];
            }
            self.tree[p] = Tree::Free;
            self.parent[p] = NONE;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Shortest augmenting paths on a matrix of capacities: slow and plain.
    fn slow_flow(mut capacity: Vec<Vec<f64>>, source: usize, sink: usize) -> f64 {
        let n = capacity.len();
        let mut flow = 0.0;
        loop {
            let mut from = vec![usize::MAX; n];
            from[source] = source;
            let mut queue = VecDeque::from([source]);
            while let Some(p) = queue.pop_front() {
                for q in 0..n {
                    if from[q] == usize::MAX && capacity[p][q] > 0.0 {
                        from[q] = p;
                        queue.push_back(q);
                    }
                }
            }
            if from[sink] == usize::MAX {
                return flow;
            }
            let path: Vec<(usize, usize)> = std::iter::successors(Some(sink), |&p| (p != source).then(|| from[p]))
                .collect::<Vec<_>>()
                .windows(2)
                .map(|w| (w[1], w[0]))
                .collect();
            let least = path.iter().map(|&(a, b)| capacity[a][b]).fold(f64::INFINITY, f64::min);
            for (a, b) in path {
                capacity[a][b] -= least;
                capacity[b][a] += least;
            }
            flow += least;
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn flow_and_cut_equal_those_of_plain_augmenting_paths(
            n in 1..9_usize,
            arcs in prop::collection::vec((0..9_usize, 0..9_usize, 0..6_u8, 0..6_u8), 0..30),
            ends in prop::collection::vec((0..6_u8, 0..6_u8), 9),
        ) {
            let mut graph = Graph::new(n);
            let (source, sink) = (n, n + 1);
            let mut capacity = vec![vec![0.0; n + 2]; n + 2];
            for node in 0..n {
                let (s, t) = (f64::from(ends[node].0), f64::from(ends[node].1));
                graph.terminals(node, s, t);
                capacity[source][node] += s;
                capacity[node][sink] += t;
            }
            for (a, b, c, r) in arcs {
                if a < n && b < n && a != b {
                    graph.arc(a, b, f64::from(c), f64::from(r));
                    capacity[a][b] += f64::from(c);
                    capacity[b][a] += f64::from(r);
                }
            }
            let expected = slow_flow(capacity.clone(), source, sink);
            let (flow, mut side) = graph.solve();
            prop_assert_eq!(flow, expected);
            // The cut between the sides is as large as the flow.
            side.extend([true, false]);
            let cut: f64 = (0..n + 2).flat_map(|a| (0..n + 2).map(move |b| (a, b)))
                .filter(|&(a, b)| side[a] && !side[b]).map(|(a, b)| capacity[a][b]).sum();
            prop_assert_eq!(cut, expected);
        }
    }
}
