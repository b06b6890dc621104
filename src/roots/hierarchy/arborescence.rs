//! The cheapest way to hang everything on one root: the minimum spanning arborescence (Chu and Liu 1965, Edmonds 1967).

/// A way to hang `to` on `from`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edge {
    /// What is hung on.
    pub from: usize,
    /// What hangs.
    pub to: usize,
    /// Smaller is better.
    pub cost: f64,
}

/// Per vertex below `n` the number of the edge that it hangs by, so that all hang on `root` and the sum of costs is
/// least; none for the root and for what no edge reaches. Of equal edges the first counts.
pub fn arborescence(n: usize, root: usize, edges: &[Edge]) -> Vec<Option<usize>> {
    let mut best: Vec<Option<usize>> = vec![None; n];
    for (k, e) in edges.iter().enumerate().filter(|(_, e)| e.to != root && e.from != e.to) {
        if best[e.to].is_none_or(|b| e.cost < edges[b].cost) {
            best[e.to] = Some(k);
        }
    }
    let (group, groups, cyclic) = cycles(&best, edges);
    if cyclic == 0 {
        return best;
    }
    // Every cycle becomes one vertex; an edge into it costs what it saves of the cycle's own edge there.
    let mut inner = Vec::new();
    let mut outer = Vec::new();
    for (k, e) in edges.iter().enumerate().filter(|(_, e)| group[e.from] != group[e.to]) {
        let saved = best[e.to].filter(|_| group[e.to] < cyclic).map_or(0.0, |b| edges[b].cost);
        inner.push(k);
        outer.push(Edge { from: group[e.from], to: group[e.to], cost: e.cost - saved });
    }
    for chosen in arborescence(groups, group[root], &outer).into_iter().flatten() {
        best[edges[inner[chosen]].to] = Some(inner[chosen]);
    }
    best
}

/// The group of each vertex (cycles first), the number of groups and that of cycles among them.
fn cycles(best: &[Option<usize>], edges: &[Edge]) -> (Vec<usize>, usize, usize) {
    const NONE: usize = usize::MAX;
    let (mut group, mut seen) = (vec![NONE; best.len()], vec![NONE; best.len()]);
    let mut groups = 0;
    for start in 0..best.len() {
        let mut at = start;
        while seen[at] == NONE {
            seen[at] = start;
            match best[at] {
                Some(edge) => at = edges[edge].from,
                None => break,
            }
        }
        if seen[at] == start && group[at] == NONE && best[at].is_some() {
            while group[at] == NONE {
                group[at] = groups;
                at = best[at].map_or(at, |edge| edges[edge].from);
            }
            groups += 1;
        }
    }
    let cyclic = groups;
    for g in group.iter_mut().filter(|g| **g == NONE) {
        *g = groups;
        groups += 1;
    }
    (group, groups, cyclic)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};

    /// The least cost over all choices of one edge per vertex that reach the root.
    fn slow(n: usize, edges: &[Edge]) -> f64 {
        let into: Vec<Vec<&Edge>> =
            (1..n).map(|v| edges.iter().filter(|e| e.to == v && e.from != v).collect()).collect();
        let mut best = f64::INFINITY;
        let combinations: usize = into.iter().map(Vec::len).product();
        for mut code in 0..combinations {
            let choice: Vec<&Edge> = into
                .iter()
                .map(|list| {
                    let e = list[code % list.len()];
                    code /= list.len();
                    e
                })
                .collect();
            let reaches = |v: usize| {
                let mut at = v;
                for _ in 0..n {
                    if at == 0 {
                        return true;
                    }
                    at = choice[at - 1].from;
                }
                at == 0
            };
            if (1..n).all(reaches) {
                best = best.min(choice.iter().map(|e| e.cost).sum());
            }
        }
        best
    }

    #[test]
    fn as_cheap_as_trying_all() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(3);
        for _ in 0..300 {
            let n = rng.random_range(2..6);
            let mut edges: Vec<Edge> =
                (1..n).map(|to| Edge { from: 0, to, cost: f64::from(rng.random_range(5..20)) }).collect();
            for _ in 0..rng.random_range(0..9) {
                let (from, to) = (rng.random_range(0..n), rng.random_range(1..n));
                edges.push(Edge { from, to, cost: f64::from(rng.random_range(0..12)) });
            }
            let chosen = arborescence(n, 0, &edges);
            let cost: f64 = (1..n).map(|v| edges[chosen[v].unwrap()].cost).sum();
            assert_eq!(cost, slow(n, &edges), "{edges:?}");
            for v in 1..n {
                let mut at = v;
                for _ in 0..n {
                    at = chosen[at].map_or(0, |k| edges[k].from);
                }
                assert_eq!(at, 0, "all hang on the root");
            }
        }
        assert_eq!(arborescence(3, 0, &[Edge { from: 0, to: 1, cost: 1.0 }]), [None, Some(0), None]);
    }
}
