//! Which branch of a fork is the root that goes on: an earlier day knows.
//!
//! A single day tells by bend, thickness and reach, and is sometimes wrong: a root then goes on into its lateral, and its own tip
//! hangs on it as one. A branch that was there while the other was not yet is the root; the two tails then change places. What is
//! settled so on one day holds for the days after it.

use crate::growth::overlap::{Known, Place, places};
use crate::optics::Vec3;
use crate::roots::TracedRoot;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Length of a branch that is looked at, mm, and how far from the fork, where both branches lie together, it begins.
const LOOK_MM: f64 = 8.0;
const APART_MM: f64 = 2.0;
/// Least share of what is looked at that lies on one root of the other day.
const KNOWN: f64 = 0.6;

/// A fork whose branches changed places.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rehung {
    /// The day, in order.
    pub day: usize,
    /// The day that told it.
    pub by: usize,
    /// Where the fork is, mm.
    pub place_mm: [f64; 3],
}

/// The root that most of the places lie on, where enough do.
fn who(known: &Known, piece: &[Place]) -> Option<usize> {
    let mut counts = vec![0usize; known.len()];
    for place in piece {
        let nearest = known.beside(&place.point_mm, &place.direction, false).first().map(|b| b.root);
        nearest.into_iter().for_each(|root| counts[root] += 1);
    }
    let (root, &count) = counts.iter().enumerate().max_by_key(|(n, count)| (**count, std::cmp::Reverse(*n)))?;
    (count as f64 >= KNOWN * piece.len() as f64 && count > 0).then_some(root)
}

/// A fork: the root that goes on and the one that springs from it, by their places in the day's list.
struct Fork {
    through: usize,
    branch: usize,
    /// Arc position on the first, mm.
    arc_mm: f64,
}

/// Lets the branches of forks change places where other days know better; says where.
pub(super) fn rehang(days: &mut [Vec<TracedRoot>], within_mm: f64) -> Vec<Rehung> {
    let mut all = Vec::new();
    // By day, the ids of branches whose fork an earlier day has settled.
    let mut settled: Vec<BTreeSet<i64>> = vec![BTreeSet::new(); days.len()];
    for day in 1..days.len() {
        let known = Known::of(days[day - 1].iter().map(|r| &r.root), within_mm);
        // The other branch was not there yet, or the earlier day's fork is settled already.
        let (first, rest) = settled.split_at_mut(day);
        let earlier: Vec<bool> = days[day - 1].iter().map(|r| first[day - 1].contains(&r.root.id)).collect();
        let (settled, roots) = (&mut rest[0], &mut days[day]);
        let lateral = |other: Option<usize>| other.is_none_or(|root| earlier[root]);
        let verdict = |[before, on, off]: [Option<usize>; 3], id: i64| {
            let stays = before.is_some() && before == on && off != before && lateral(off);
            let goes = before.is_some() && before == off && on != before && lateral(on);
            if stays || goes {
                settled.insert(id);
            }
            goes
        };
        all.extend(of_day(roots, &known, verdict).into_iter().map(|place_mm| Rehung { day, by: day - 1, place_mm }));
    }
    all
}

/// Goes over the forks of a day; `verdict` gets the roots of the other day before the fork, on, and off, and the branch's id.
fn of_day(
    roots: &mut [TracedRoot],
    known: &Known,
    mut verdict: impl FnMut([Option<usize>; 3], i64) -> bool,
) -> Vec<[f64; 3]> {
    let mut changed = Vec::new();
    // A branch is decided once: after it changed places, its new tail may be a fork's no more.
    let mut done = BTreeSet::new();
    while let Some(fork) = next(roots, &done) {
        let id = roots[fork.branch].root.id;
        done.insert(id);
        let (through, branch) = (places(&roots[fork.through].root), places(&roots[fork.branch].root));
        let within = |all: &'_ [Place], from: f64, to: f64| -> Vec<Place> {
            all.iter().filter(|p| p.arc_mm >= from && p.arc_mm <= to).copied().collect()
        };
        let pieces = [
            within(&through, fork.arc_mm - LOOK_MM, fork.arc_mm),
            within(&through, fork.arc_mm + APART_MM, fork.arc_mm + LOOK_MM),
            within(&branch, APART_MM, LOOK_MM),
        ];
        let who = pieces.map(|piece| who(known, &piece));
        if verdict(who, id) {
            changed.push(exchange(roots, &fork));
        }
    }
    changed
}

/// The next fork that is not decided, from the top of the system on.
fn next(roots: &[TracedRoot], done: &BTreeSet<i64>) -> Option<Fork> {
    let mut forks = Vec::new();
    for (branch, traced) in roots.iter().enumerate().filter(|(_, r)| !done.contains(&r.root.id)) {
        let through = roots.iter().position(|r| r.root.id == traced.root.parent);
        let (Some(through), Some(base)) = (through, traced.root.points_mm.first()) else { continue };
        let (_, arc_mm) = cut(&roots[through], base);
        forks.push(Fork { through, branch, arc_mm });
    }
    forks.sort_by(|a, b| {
        (roots[a.through].root.order, a.arc_mm)
            .partial_cmp(&(roots[b.through].root.order, b.arc_mm))
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    forks.into_iter().next()
}

/// The point of a root that is nearest to `base`: its place in the list and its arc position.
fn cut(traced: &TracedRoot, base: &[f64; 3]) -> (usize, f64) {
    let (base, mut best, mut arc_mm) = (Vec3::from(*base), (f64::INFINITY, 0, 0.0), 0.0);
    let points = &traced.root.points_mm;
    for (k, p) in points.iter().enumerate() {
        if k > 0 {
            arc_mm += (Vec3::from(*p) - Vec3::from(points[k - 1])).norm();
        }
        let distance = (Vec3::from(*p) - base).norm();
        if distance < best.0 {
            best = (distance, k, arc_mm);
        }
    }
    (best.1, best.2)
}

/// Lets the tails of a fork change places; says where.
fn exchange(roots: &mut [TracedRoot], fork: &Fork) -> [f64; 3] {
    let (through, branch) = (roots[fork.through].clone(), roots[fork.branch].clone());
    let (at, _) = cut(&through, &branch.root.points_mm[0]);
    let place_mm = through.root.points_mm[at];
    // Who springs from which tail, before they change.
    let beyond = |r: &TracedRoot| r.root.points_mm.first().is_some_and(|base| cut(&through, base).0 > at);
    for (n, other) in roots.iter_mut().enumerate() {
        if n == fork.branch || n == fork.through {
            continue;
        }
        if other.root.parent == branch.root.id {
            other.root.parent = through.root.id;
        } else if other.root.parent == through.root.id && beyond(other) {
            other.root.parent = branch.root.id;
        }
    }
    roots[fork.through] = joined(&through, 0..at + 1, Some(&branch));
    let tail = joined(&through, at..through.root.points_mm.len(), None);
    let root = crate::roots::Root { id: branch.root.id, parent: through.root.id, ..tail.root };
    roots[fork.branch] = TracedRoot { root, ..tail };
    orders(roots);
    place_mm
}

/// A stretch of a root, with all of another after it.
pub(super) fn joined(of: &TracedRoot, range: std::ops::Range<usize>, after: Option<&TracedRoot>) -> TracedRoot {
    fn list<T: Copy>(of: &[T], range: &std::ops::Range<usize>, after: Option<&Vec<T>>) -> Vec<T> {
        of[range.clone()].iter().chain(after.into_iter().flatten()).copied().collect()
    }
    let mut new = of.clone();
    new.root.points_mm = list(&of.root.points_mm, &range, after.map(|a| &a.root.points_mm));
    new.root.radii_mm = list(&of.root.radii_mm, &range, after.map(|a| &a.root.radii_mm));
    new.radius_sd_mm = list(&of.radius_sd_mm, &range, after.map(|a| &a.radius_sd_mm));
    new.views = list(&of.views, &range, after.map(|a| &a.views));
    new.confidence = list(&of.confidence, &range, after.map(|a| &a.confidence));
    new
}

/// Counts the orders anew from the parents.
pub(super) fn orders(roots: &mut [TracedRoot]) {
    for n in 0..roots.len() {
        let (mut order, mut at) = (0, roots[n].root.parent);
        while let Some(parent) = roots.iter().find(|r| r.root.id == at).filter(|_| order < roots.len() as u32) {
            order += 1;
            at = parent.root.parent;
        }
        roots[n].root.order = order;
    }
}
