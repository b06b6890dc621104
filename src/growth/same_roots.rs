//! Two results of one plant in one frame: which root of the one is which of the other, and what became another.
//!
//! Two roots are one where most of the length of either runs along the other within [`WITHIN_MM`]: a root that was traced shorter is still
//! the same. Pairs are taken from the most common length on; each root once. Of what is left, a root most
//! of whose length runs along a root of the other result is a part of that one (it was cut or joined otherwise there); all else is in one
//! result only. Directions do not matter for this, and are told where they differ.

use super::overlap::overlaps;
use crate::roots::{Root, curve};
use serde::Serialize;
use std::collections::BTreeMap;

/// How far apart the lines of one root may lie, mm: as far as `follow.within_mm` allows between days. Centrelines of one root lie within a
/// voxel of each other however they were traced, and voxels are seldom wider; roots beside each other seldom run nearer.
pub const WITHIN_MM: f64 = 1.5;
/// Least share of the length that is most of it.
const MOST: f64 = 0.5;
/// Lengths that differ by more are told, mm: ends of one root lie within this where they are scored (`rootvox evaluate`).
pub const LENGTH_MM: f64 = 2.0;

/// What became of a root.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// It is in both, as far as its line, order and parent tell.
    Same,
    /// It is in both, with another length.
    Length,
    /// It is in both, with another order, parent or direction, and perhaps another length.
    Place,
    /// It is in one result, and a part of another root there in the other.
    Part,
    /// It is in one result only.
    Only,
}

/// A root of either result, or of both.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Entry {
    /// What became of it.
    pub fate: Fate,
    /// Place of its root in the first result's list. Of a part, the whole that it is of stands at the other's place.
    pub first: Option<usize>,
    /// Place of its root in the other result's list.
    pub other: Option<usize>,
    /// Whether it is the first's: of [`Fate::Part`] the part, of [`Fate::Only`] the root.
    pub is_of_first: bool,
    /// What differs of a root that is in both: `length`, `order`, `parent`, `direction`.
    pub differs: Vec<&'static str>,
}

/// Two results held against each other.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Roots of the first in their order, then those of the other alone.
    pub entries: Vec<Entry>,
    /// Share of the first's length that runs along a root of the other which it is paired with, or a part of, 0 to 1; NaN without roots.
    pub common: f64,
}

/// Holds the roots of another result against the first's.
pub fn compare(first: &[Root], other: &[Root]) -> Comparison {
    let near = Near::of(first, other);
    let pairs = near.pairs();
    let of_first: BTreeMap<usize, usize> = pairs.iter().copied().collect();
    let of_other: BTreeMap<usize, usize> = pairs.iter().map(|(a, b)| (*b, *a)).collect();
    let wholes = Wholes { near: &near, of_first: &of_first };
    let mut entries = Vec::new();
    for n in 0..first.len() {
        entries.push(match (of_first.get(&n), near.whole_of_first(n)) {
            (Some(&m), _) => {
                let differs = wholes.differs(&first[n], &other[m], first, other, is_against(&first[n], &other[m]));
                let fate = match differs[..] {
                    [] => Fate::Same,
                    ["length"] => Fate::Length,
                    _ => Fate::Place,
                };
                Entry { fate, first: Some(n), other: Some(m), is_of_first: true, differs }
            }
            (None, Some(m)) => Entry { fate: Fate::Part, ..Entry::alone(Some(n), Some(m), true) },
            (None, None) => Entry::alone(Some(n), None, true),
        });
    }
    for m in (0..other.len()).filter(|m| !of_other.contains_key(m)) {
        entries.push(match near.whole_of_other(m) {
            Some(n) => Entry { fate: Fate::Part, ..Entry::alone(Some(n), Some(m), false) },
            None => Entry::alone(None, Some(m), false),
        });
    }
    let lengths: Vec<f64> = first.iter().map(length_mm).collect();
    let shared = entries.iter().filter(|e| e.is_of_first).filter_map(|e| {
        let (n, m) = (e.first?, e.other?);
        Some(lengths[n] * near.shares.get(&(n, m))?[0])
    });
    let common = shared.sum::<f64>() / lengths.iter().sum::<f64>();
    Comparison { entries, common }
}

/// Length of a root's centreline, mm.
pub fn length_mm(root: &Root) -> f64 {
    curve::chord_lengths(&root.points_mm).last().copied().unwrap_or(0.0)
}

impl Entry {
    fn alone(first: Option<usize>, other: Option<usize>, is_of_first: bool) -> Self {
        Self { fate: Fate::Only, first, other, is_of_first, differs: Vec::new() }
    }
}

/// Of every pair that runs together the share of the first's root, and of the other's.
struct Near {
    shares: BTreeMap<(usize, usize), [f64; 2]>,
    /// Length that runs together, mm.
    lengths: BTreeMap<(usize, usize), f64>,
}

impl Near {
    fn of(first: &[Root], other: &[Root]) -> Self {
        let (a, b): (Vec<&Root>, Vec<&Root>) = (first.iter().collect(), other.iter().collect());
        let mut near = Self { shares: BTreeMap::new(), lengths: BTreeMap::new() };
        for o in overlaps(&a, &b, WITHIN_MM, true) {
            near.shares.entry((o.earlier, o.later)).or_default()[0] = o.share;
            *near.lengths.entry((o.earlier, o.later)).or_default() += o.length_mm / 2.0;
        }
        for o in overlaps(&b, &a, WITHIN_MM, true) {
            near.shares.entry((o.later, o.earlier)).or_default()[1] = o.share;
            *near.lengths.entry((o.later, o.earlier)).or_default() += o.length_mm / 2.0;
        }
        near
    }

    /// The pairs that are one root.
    fn pairs(&self) -> Vec<(usize, usize)> {
        let is_most = |shares: &[f64; 2]| shares[0].max(shares[1]) >= MOST;
        let near = self.shares.iter().filter(|(_, shares)| is_most(shares));
        let mut all: Vec<(f64, (usize, usize))> = near.map(|(pair, _)| (self.lengths[pair], *pair)).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let (mut of_first, mut of_other) = (BTreeMap::new(), BTreeMap::new());
        for (_, (n, m)) in all {
            if !of_first.contains_key(&n) && !of_other.contains_key(&m) {
                of_first.insert(n, m);
                of_other.insert(m, n);
            }
        }
        of_first.into_iter().collect()
    }

    /// The root of the other along which most of a root of the first runs.
    fn whole_of_first(&self, n: usize) -> Option<usize> {
        let along = self.shares.range((n, 0)..(n + 1, 0)).filter(|(_, shares)| shares[0] >= MOST);
        along.max_by(|a, b| a.1[0].total_cmp(&b.1[0])).map(|((_, m), _)| *m)
    }

    /// The root of the first along which most of a root of the other runs.
    fn whole_of_other(&self, m: usize) -> Option<usize> {
        let along = self.shares.iter().filter(|((_, other), shares)| *other == m && shares[1] >= MOST);
        along.max_by(|a, b| a.1[1].total_cmp(&b.1[1])).map(|((n, _), _)| *n)
    }
}

/// Whether two roots run against each other: the base of one lies at the other's tip.
fn is_against(a: &Root, b: &Root) -> bool {
    let apart = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    match (&a.points_mm[..], &b.points_mm[..]) {
        ([a0, .., a1], [b0, .., b1]) => {
            apart(a0, b1).min(apart(a1, b0)) < WITHIN_MM.min(apart(a0, b0)).min(apart(a1, b1))
        }
        _ => false,
    }
}

/// Tells parents apart: pieces of one root are one parent.
struct Wholes<'a> {
    near: &'a Near,
    of_first: &'a BTreeMap<usize, usize>,
}

impl Wholes<'_> {
    fn differs(&self, a: &Root, b: &Root, first: &[Root], other: &[Root], is_against: bool) -> Vec<&'static str> {
        let parent = |roots: &[Root], id: i64| roots.iter().position(|r| r.id == id);
        let same_parent = match (parent(first, a.parent), parent(other, b.parent)) {
            (None, None) => true,
            (Some(p), Some(q)) => {
                self.of_first.get(&p) == Some(&q)
                    || self.near.whole_of_first(p) == Some(q)
                    || self.near.whole_of_other(q) == Some(p)
            }
            _ => false,
        };
        let told = [
            ("length", (length_mm(a) - length_mm(b)).abs() > LENGTH_MM),
            ("order", a.order != b.order),
            ("parent", !same_parent),
            ("direction", is_against),
        ];
        told.into_iter().filter(|(_, differs)| *differs).map(|(what, _)| what).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight root from one place to another, mm.
    fn root(id: i64, parent: i64, order: u32, from: [f64; 3], to: [f64; 3]) -> Root {
        let at = |k: usize| std::array::from_fn(|d| from[d] + (to[d] - from[d]) * k as f64 / 40.0);
        Root { id, parent, order, points_mm: (0..=40).map(at).collect(), radii_mm: vec![0.5; 41] }
    }

    fn taproot() -> Root {
        root(0, -1, 0, [0.0, 0.0, 10.0], [0.0, 0.0, 100.0])
    }

    fn fates(c: &Comparison) -> Vec<(Fate, Option<usize>, Option<usize>)> {
        c.entries.iter().map(|e| (e.fate, e.first, e.other)).collect()
    }

    #[test]
    fn a_result_is_like_itself_however_it_is_numbered() {
        let first = [taproot(), root(1, 0, 1, [0.0, 0.0, 40.0], [30.0, 0.0, 50.0])];
        let mut other = [first[1].clone(), first[0].clone()];
        (other[0].id, other[0].parent, other[1].id) = (7, 9, 9);
        let c = compare(&first, &other);
        assert_eq!(fates(&c), [(Fate::Same, Some(0), Some(1)), (Fate::Same, Some(1), Some(0))]);
        assert!((c.common - 1.0).abs() < 1e-9);
    }

    #[test]
    fn what_differs_of_a_root_is_told() {
        let lateral = root(1, 0, 1, [0.0, 0.0, 40.0], [30.0, 0.0, 50.0]);
        let second = root(2, 1, 2, [20.0, 0.0, 46.7], [20.0, 15.0, 50.0]);
        let first = [taproot(), lateral.clone(), second.clone()];
        // Half a millimetre aside and ending early; hung on another; run backwards.
        let aside = root(1, 0, 1, [0.0, 0.5, 40.0], [24.0, 0.5, 48.0]);
        let hung = Root { parent: 0, order: 1, ..second };
        let c = compare(&first, &[taproot(), aside, hung]);
        assert_eq!(c.entries.iter().map(|e| e.fate).collect::<Vec<_>>(), [Fate::Same, Fate::Length, Fate::Place]);
        assert_eq!((&c.entries[1].differs[..], &c.entries[2].differs[..]), (&["length"][..], &["order", "parent"][..]));
        let mut back = lateral;
        back.points_mm.reverse();
        assert_eq!(compare(&first[..2], &[taproot(), back]).entries[1].differs, ["direction"]);
    }

    #[test]
    fn a_root_in_two_pieces_is_one_root_and_a_part() {
        let upper = root(0, -1, 0, [0.0, 0.0, 10.0], [0.0, 0.0, 60.0]);
        let lower = root(1, 0, 1, [0.0, 0.0, 60.5], [0.0, 0.0, 100.0]);
        let child = |id, parent| root(id, parent, 1, [0.0, 0.0, 80.0], [25.0, 0.0, 90.0]);
        let c = compare(&[taproot(), child(1, 0)], &[upper.clone(), lower.clone(), child(2, 1)]);
        let told = [
            (Fate::Length, Some(0), Some(0)),
            // Springing from the part is springing from the whole.
            (Fate::Same, Some(1), Some(2)),
            (Fate::Part, Some(0), Some(1)),
        ];
        assert_eq!(fates(&c), told);
        assert!(!c.entries[2].is_of_first);
        // The other way around it is the first's part.
        let c = compare(&[upper, lower], &[taproot()]);
        assert_eq!(fates(&c), [(Fate::Length, Some(0), Some(0)), (Fate::Part, Some(1), Some(0))]);
        assert!((c.common - 1.0).abs() < 0.02, "{}", c.common);
    }

    #[test]
    fn the_longest_common_stretch_makes_the_pair() {
        // The first's taproot goes on straight; the other's turns into the lateral, and its lower end hangs on it.
        let lateral = root(1, 0, 1, [0.0, 0.0, 60.0], [30.0, 0.0, 85.0]);
        let mut bent = root(0, -1, 0, [0.0, 0.0, 10.0], [0.0, 0.0, 60.0]);
        bent.points_mm.extend(&lateral.points_mm[1..]);
        bent.radii_mm.extend(&lateral.radii_mm[1..]);
        let lower = root(1, 0, 1, [0.0, 0.0, 60.0], [0.0, 0.0, 100.0]);
        let c = compare(&[taproot(), lateral], &[bent, lower]);
        let told = [(Fate::Same, Some(0), Some(0)), (Fate::Part, Some(1), Some(0)), (Fate::Part, Some(0), Some(1))];
        assert_eq!(fates(&c), told);
        assert_eq!(c.entries.iter().map(|e| e.is_of_first).collect::<Vec<_>>(), [true, true, false]);
    }

    #[test]
    fn roots_that_only_cross_or_run_apart_are_in_one_result_only() {
        let across = root(5, -1, 0, [-30.0, 0.0, 50.0], [30.0, 0.0, 50.0]);
        let apart = root(6, -1, 0, [WITHIN_MM + 0.1, 0.0, 10.0], [WITHIN_MM + 0.1, 0.0, 100.0]);
        let c = compare(&[taproot()], &[across, apart]);
        assert_eq!(fates(&c), [(Fate::Only, Some(0), None), (Fate::Only, None, Some(0)), (Fate::Only, None, Some(1))]);
        assert_eq!(c.common, 0.0);
        assert!(compare(&[], &[taproot()]).common.is_nan());
        assert_eq!(fates(&compare(&[], &[taproot()])), [(Fate::Only, None, Some(0))]);
    }
}
