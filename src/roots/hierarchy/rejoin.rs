//! Roots that end on another go on beyond it.
//!
//! Where roots cross, one may be followed to the other and end there, while what lies beyond seems a lateral of the other.
//! That a root ends on the surface of another just where that one branches is rare chance; so a tip that touches another root (no
//! farther from its surface than a link) goes on in a lateral that springs from that one within `smooth_mm` of the tip, where both
//! have one direction within [`MOST_DEG`] and one thickness within [`MOST_RATIO`]. Of several the straightest is taken.

use super::Line;
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

/// Roots with those joined that go on beyond another; parents stand first, before and after.
pub fn rejoin(lines: &[Line<'_>], mut grown: Vec<Grown>, pieces: &Pieces, log: &mut Vec<Repair>) -> Vec<Grown> {
    let mut ways: Vec<Way> = grown.iter().map(|g| places(lines, &g.parts)).collect();
    let mut joined = false;
    while let Some((root, lateral, bend_deg)) = straightest(&grown, &ways, pieces) {
        joined = true;
        let place = ways[root][ways[root].len() - 1].0;
        let reason = format!("a root that ended on another goes on beyond it, bent by {bend_deg:.0}°");
        log.push(Repair::new(Kind::Repaired, &place, (ways[lateral][0].0 - place).norm(), reason));
        let (parts, points) = (std::mem::take(&mut grown[lateral].parts), std::mem::take(&mut ways[lateral]));
        grown[root].parts.extend(parts);
        ways[root].extend(points);
        for g in grown.iter_mut().filter(|g| g.parent == Some(lateral)) {
            g.parent = Some(root);
        }
    }
    if joined { sorted(&grown) } else { grown }
}

/// The root and the lateral of another that continue each other best, with the bend between them.
fn straightest(grown: &[Grown], ways: &[Way], pieces: &Pieces) -> Option<(usize, usize, f64)> {
    let mut best: Option<(usize, usize, f64)> = None;
    for (root, way) in ways.iter().enumerate() {
        let Some(&(tip, _)) = way.last() else { continue };
        let touches = |(p, radius): &(Vec3, f64)| (p - tip).norm() - radius <= pieces.link_mm;
        for (lateral, next) in ways.iter().enumerate() {
            let Some(other) = grown[lateral].parent.filter(|&o| o != root && grown[lateral].tied) else { continue };
            let near = next.first().is_some_and(|p| (p.0 - tip).norm() <= pieces.smooth_mm);
            if !near || !ways[other].iter().any(touches) || springs_from(grown, root, lateral) {
                continue;
            }
            let Some((bend_deg, ratio)) = fit(way, next, pieces.smooth_mm) else { continue };
            if bend_deg <= MOST_DEG && ratio <= MOST_RATIO && best.is_none_or(|b| bend_deg < b.2) {
                best = Some((root, lateral, bend_deg));
            }
        }
    }
    best
}

/// Whether `root` is the other one or springs from it, over however many.
fn springs_from(grown: &[Grown], root: usize, other: usize) -> bool {
    std::iter::successors(Some(root), |&r| grown[r].parent).any(|r| r == other)
}

/// Bend in degrees from the last stretch of a way to the first of another, and the ratio of their thicknesses.
fn fit(way: &Way, next: &Way, stretch_mm: f64) -> Option<(f64, f64)> {
    let (back, radius) = stretch(way.iter().rev(), 0.0, stretch_mm)?;
    // The next one's first points lie in the root that it seems to spring from.
    let (onward, other) = stretch(next.iter(), next[0].1.max(0.25 * stretch_mm), stretch_mm)?;
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
