//! Roots that seem to end go on.
//!
//! Where roots cross, what goes on beyond may seem a root of its own. A tip goes on
//! - **beyond another root**: it touches that one (no farther from its surface than a link), and a lateral springs from that one
//!   half of `smooth_mm` from the tip at most. That a root ends on another just where that one branches is rare chance;
//! - **head-on** in another tip as near, the later of the two roots running the other way then;
//! - in **its own lateral** that springs within a third of `smooth_mm` of the tip: roots bear none so near their tips.
//!
//! Both must have one direction within `MOST_DEG` and one thickness within `MOST_RATIO`. The straightest goes first.

use super::Line;
use super::part::Part;
use super::walk::{Grown, places};
use crate::optics::Vec3;
use crate::roots::repair::{Kind, Repair};
use crate::roots::trace::Pieces;

/// Laterals leave at steep angles, roots go on at flat ones.
const MOST_DEG: f64 = 75.0;
/// Largest ratio of thicknesses, thicker over thinner.
const MOST_RATIO: f64 = 1.6;

/// A root's way: points with radii, mm.
type Way = Vec<(Vec3, f64)>;

/// A root that goes on in another.
#[derive(Debug, Clone, Copy)]
struct Join {
    root: usize,
    next: usize,
    /// From the other's tip to its base.
    head_on: bool,
    bend_deg: f64,
}

/// Roots with those joined that go on; parents stand first, before and after.
pub fn rejoin(lines: &[Line<'_>], mut grown: Vec<Grown>, pieces: &Pieces, log: &mut Vec<Repair>) -> Vec<Grown> {
    let mut ways: Vec<Way> = grown.iter().map(|g| places(lines, &g.parts)).collect();
    let mut joined = false;
    while let Some(Join { root, next, head_on, bend_deg }) = straightest(&grown, &ways, pieces) {
        joined = true;
        let tip = ways[root][ways[root].len() - 1].0;
        let mut parts = std::mem::take(&mut grown[next].parts);
        if head_on {
            parts.reverse();
            parts.iter_mut().for_each(|p| std::mem::swap(&mut p.from, &mut p.to));
        }
        let start = places(lines, &parts)[0].0;
        cut(lines, &mut grown[root].parts, &start, pieces.smooth_mm);
        let reason = format!("a root that seemed to end goes on in another, bent by {bend_deg:.0}°");
        log.push(Repair::new(Kind::Repaired, &tip, (start - tip).norm(), reason));
        grown[root].parts.extend(parts);
        (ways[root], ways[next]) = (places(lines, &grown[root].parts), Way::new());
        for g in grown.iter_mut().filter(|g| g.parent == Some(next)) {
            g.parent = Some(root);
        }
    }
    if joined { sorted(&grown) } else { grown }
}

/// Takes off what of the last `most_mm` of a way lies beyond its point nearest to a place.
fn cut(lines: &[Line<'_>], parts: &mut Vec<Part>, place: &Vec3, most_mm: f64) {
    let (mut way_mm, mut before): (f64, Option<Vec3>) = (0.0, None);
    let mut best: Option<(f64, usize, usize)> = None;
    'back: for (n, part) in parts.iter().enumerate().rev() {
        for k in part.points().rev() {
            let p = lines[part.piece].at(k);
            way_mm += before.map_or(0.0, |b| (p - b).norm());
            before = Some(p);
            if way_mm > most_mm {
                break 'back;
            }
            let distance = (p - place).norm();
            if best.is_none_or(|b| distance < b.0) {
                best = Some((distance, n, k));
            }
        }
    }
    if let Some((_, n, k)) = best {
        parts.truncate(n + 1);
        parts[n].to = k;
    }
}

/// The root and the other that continue each other best.
fn straightest(grown: &[Grown], ways: &[Way], pieces: &Pieces) -> Option<Join> {
    let mut best: Option<Join> = None;
    let reach_mm = pieces.smooth_mm / 2.0;
    for (root, way) in ways.iter().enumerate() {
        let Some(&(tip, _)) = way.last() else { continue };
        let touches = |(p, radius): &(Vec3, f64)| (p - tip).norm() - radius <= pieces.link_mm;
        let within = |p: &(Vec3, f64), reach_mm: f64| (p.0 - tip).norm() <= reach_mm;
        for (next, other) in ways.iter().enumerate().filter(|(n, other)| *n != root && other.len() > 1) {
            // A root does not end in what it springs from.
            if lineage(grown, root).any(|r| r == next) {
                continue;
            }
            let parent = grown[next].parent.filter(|_| grown[next].tied);
            let on = match parent {
                Some(parent) if parent == root => left_mm(way, &other[0].0) <= pieces.smooth_mm / 3.0,
                // Beside its own parent a tip touches it where it will.
                Some(parent) if grown[root].parent != Some(parent) => {
                    within(&other[0], reach_mm) && ways[parent].iter().any(touches)
                }
                _ => false,
            };
            // What hangs visibly keeps its base. Orders are not followed up while roots are joined.
            let rank = |r: usize| (r > 0 && !grown[r].tied, lineage(grown, r).count(), r);
            let head_on = rank(root) < rank(next)
                && within(&other[other.len() - 1], reach_mm)
                && lineage(grown, next).all(|r| r != root);
            for head_on in [false, true].into_iter().filter(|&h| if h { head_on } else { on }) {
                let next_way: Way = if head_on { other.iter().rev().copied().collect() } else { other.clone() };
                let Some((bend_deg, ratio)) = fit(way, &next_way, pieces) else { continue };
                if bend_deg <= MOST_DEG && ratio <= MOST_RATIO && best.is_none_or(|b| bend_deg < b.bend_deg) {
                    best = Some(Join { root, next, head_on, bend_deg });
                }
            }
        }
    }
    best
}

/// The root, what it springs from, what that springs from, and so on.
fn lineage(grown: &[Grown], root: usize) -> impl Iterator<Item = usize> {
    std::iter::successors(Some(root), |&r| grown[r].parent)
}

/// How much of a way is left from its point nearest to a place on, mm.
fn left_mm(way: &Way, place: &Vec3) -> f64 {
    let distance = |k: &usize| (way[*k].0 - place).norm();
    let at = (0..way.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0);
    way[at..].windows(2).map(|w| (w[1].0 - w[0].0).norm()).sum()
}

/// Bend in degrees from the last stretch of a way to the first of another, and the ratio of their thicknesses; none where
/// they pass each other by more than a third of `smooth_mm`.
fn fit(way: &Way, next: &Way, pieces: &Pieces) -> Option<(f64, f64)> {
    let (back, radius) = stretch(way.iter().rev(), 0.0, pieces.smooth_mm)?;
    // What leaves another root begins within it.
    let (onward, other) = stretch(next.iter(), next[0].1.max(0.25 * pieces.smooth_mm), pieces.smooth_mm)?;
    let gap = next[0].0 - way[way.len() - 1].0;
    let aside_mm = |d: &Vec3| gap.cross(d).norm();
    if aside_mm(&back).min(aside_mm(&onward)) > pieces.smooth_mm / 3.0 {
        return None;
    }
    let bend_deg = (-back).dot(&onward).clamp(-1.0, 1.0).acos().to_degrees();
    Some((bend_deg, (radius / other).max(other / radius)))
}

/// Direction and median radius over a stretch of points that begins some way on; none without two points there.
fn stretch<'a>(points: impl Iterator<Item = &'a (Vec3, f64)>, from_mm: f64, stretch_mm: f64) -> Option<(Vec3, f64)> {
    let (mut way, mut before): (f64, Option<Vec3>) = (0.0, None);
    let mut taken = Way::new();
    for &(p, radius) in points {
        way += before.map_or(0.0, |b| (p - b).norm());
        before = Some(p);
        if way >= from_mm {
            taken.push((p, radius));
        }
        if way >= from_mm + stretch_mm {
            break;
        }
    }
    let direction = (taken.last()?.0 - taken[0].0).try_normalize(1e-9)?;
    taken.sort_by(|a, b| a.1.total_cmp(&b.1));
    Some((direction, taken[taken.len() / 2].1))
}

/// The roots that have a way, parents first, else in their order.
fn sorted(grown: &[Grown]) -> Vec<Grown> {
    let mut number = vec![None; grown.len()];
    let mut list: Vec<Grown> = Vec::with_capacity(grown.len());
    let mut left: Vec<usize> = (0..grown.len()).filter(|&k| !grown[k].parts.is_empty()).collect();
    while let Some(at) = left.iter().position(|&k| grown[k].parent.is_none_or(|p| number[p].is_some())) {
        let k = left.remove(at);
        number[k] = Some(list.len());
        list.push(Grown { parent: grown[k].parent.and_then(|p| number[p]), ..grown[k].clone() });
    }
    list
}
