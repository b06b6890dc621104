//! Which node to take first: the one with the longest path still to go.
//!
//! The path of a node is its own time and that of the longest path after it. Taking long paths first keeps the last
//! thread or machine from sitting on a chain that could have begun earlier (Graham 1969: at most twice the best time
//! for any order; Hu 1961: this order is the best one for trees of equal tasks).

use super::graph::Graph;

/// A node of which nothing is known, seconds.
const UNKNOWN_S: f64 = 1.0;

/// The place of every node in the order of urgency, given the `seconds` that each takes as far as is known. Of equally
/// urgent nodes the one that was added first comes first.
pub(super) fn places(graph: &Graph, seconds: &[Option<f64>]) -> Vec<usize> {
    let mut path = vec![0.0_f64; graph.nodes.len()];
    // Consumers come after their inputs.
    for (n, node) in graph.nodes.iter().enumerate().rev() {
        path[n] += seconds[n].unwrap_or(UNKNOWN_S);
        let own = path[n];
        node.inputs().for_each(|input| path[input] = path[input].max(own));
    }
    let mut order: Vec<usize> = (0..path.len()).collect();
    order.sort_by(|&a, &b| path[b].total_cmp(&path[a]).then(a.cmp(&b)));
    let mut places = vec![0; order.len()];
    order.into_iter().enumerate().for_each(|(place, n)| places[n] = place);
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_path_comes_first() {
        let mut graph = Graph::new();
        let short = graph.file("short", "a");
        let long = graph.file("long", "b");
        let first = graph.file("first of a chain", "c");
        assert_eq!([short.0, long.0, first.0], [0, 1, 2]);
        assert_eq!(places(&graph, &[Some(1.0), Some(5.0), None]), [1, 0, 2]);
        assert_eq!(places(&graph, &[Some(2.0), None, Some(2.0)]), [0, 2, 1]);
    }
}
