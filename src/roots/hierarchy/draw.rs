//! Roots from their ways: one smooth line each, led on to its parent; pruned and numbered.

use super::part::Part;
use super::walk::Grown;
use super::{HierarchyParams, Line};
use crate::math::robust::median;
use crate::optics::Vec3;
use crate::roots::bridge::cubic;
use crate::roots::repair::{Kind, Repair};
use crate::roots::system::TracedRoot;
use crate::roots::trace::Pieces;
use crate::roots::{Root, curve};

/// x, y, z, radius, its standard deviation (mm), views, confidence.
type Point = [f64; 7];

/// Draws, prunes and numbers the roots.
pub fn draw(
    lines: &[Line<'_>],
    mut grown: Vec<Grown>,
    pieces: &Pieces,
    params: &HierarchyParams,
    log: &mut Vec<Repair>,
) -> Vec<TracedRoot> {
    let mut drawn: Vec<Vec<Point>> = Vec::with_capacity(grown.len());
    for n in 0..grown.len() {
        climb(&mut grown, n, &drawn, pieces.link_mm, log);
        let root = &grown[n];
        let own = joined(lines, &root.parts, pieces);
        let led = match root.parent {
            Some(parent) if root.tied => led(own, &drawn[parent], &root.place, pieces.step_mm),
            _ => own,
        };
        drawn.push(led);
    }
    if !pieces.looks.is_empty() {
        shorten(&grown, &mut drawn, params.shown, log);
    }
    let keep = prune(&grown, &drawn, pieces, params, log);
    number(&grown, &drawn, &keep)
}

/// Hangs root `n` on its parent's parent while the parent runs along that one's surface up to where the root springs: which of two
/// roots that lie side by side a third touches is chance, and the older one branches there already.
fn climb(grown: &mut [Grown], n: usize, drawn: &[Vec<Point>], link_mm: f64, log: &mut Vec<Repair>) {
    while let Some(parent) = grown[n].parent.filter(|_| grown[n].tied)
        && let Some(older) = grown[parent].parent.filter(|_| grown[parent].tied)
    {
        let way = &drawn[parent];
        let at = closest(way, &grown[n].place);
        let beside = |p: &Point| {
            let (distance, radius) = nearest(&drawn[older], &curve::position(p));
            distance <= radius + link_mm
        };
        if !way[..=at].iter().all(beside) {
            break;
        }
        let reason = "its parent runs along an older root up to here: hung on that one".to_owned();
        log.push(Repair::new(Kind::Repaired, &grown[n].place, 0.0, reason));
        grown[n].parent = Some(older);
    }
    if let Some(parent) = grown[n].parent {
        grown[n].order = grown[parent].order + 1;
    }
}

/// The points of a way in order; over junctions from piece to piece smoothed anew.
fn joined(lines: &[Line<'_>], parts: &[Part], pieces: &Pieces) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for (n, part) in parts.iter().enumerate() {
        let line = &lines[part.piece];
        let piece = line.piece;
        let point = |k: usize| {
            let p = piece.root.points_mm[k];
            [
                p[0],
                p[1],
                p[2],
                piece.root.radii_mm[k],
                piece.radius_sd_mm[k],
                f64::from(piece.views[k]),
                piece.confidence[k],
            ]
        };
        let mut own: Vec<Point> = part.points().map(point).collect();
        // Within a radius of a junction the ridge belongs to both.
        if n > 0 && own.len() > 2 {
            let radius = own[0][3];
            let skip = curve::chord_lengths(&own).partition_point(|s| *s < radius).min(own.len() - 2);
            own.drain(..skip);
        }
        if n + 1 < parts.len() && own.len() > 2 {
            let radius = own[own.len() - 1][3];
            let arc = curve::chord_lengths(&own);
            let end = arc[arc.len() - 1];
            own.truncate(arc.partition_point(|s| end - *s >= radius).max(2));
        }
        points.append(&mut own);
    }
    if parts.len() > 1 { curve::smooth(&points, pieces.step_mm, pieces.smooth_mm) } else { points }
}

/// The points led from the parent's line on: what lies within the parent is replaced by a smooth way out.
fn led(own: Vec<Point>, parent: &[Point], place: &Vec3, step_mm: f64) -> Vec<Point> {
    let Some(start) = parent.iter().min_by(|a, b| {
        let distance = |p: &Point| (curve::position(p) - place).norm_squared();
        distance(a).total_cmp(&distance(b))
    }) else {
        return own;
    };
    let (from, radius) = (curve::position(start), start[3]);
    let inside = own.iter().take_while(|p| (curve::position(p) - from).norm() < radius).count();
    let first = inside.min(own.len().saturating_sub(2));
    let Some(head) = own.get(first).copied() else { return own };
    let to = curve::position(&head);
    let gap = (to - from).norm();
    let ahead = own.get((first + 4).min(own.len() - 1)).map_or(to, curve::position);
    let onward = (ahead - to).try_normalize(1e-9).unwrap_or_else(Vec3::zeros);
    let n = (gap / step_mm).round().max(1.0) as usize;
    let lead = (0..n).map(|k| {
        let p = cubic(&from, &(to - from), &to, &(onward * gap), k as f64 / n as f64);
        [p.x, p.y, p.z, head[3], head[4], 0.0, head[6]]
    });
    lead.chain(own[first..].iter().copied()).collect()
}

/// Takes tips back to the last point that the share `shown` of the photographs shows, or from which a lateral springs.
fn shorten(grown: &[Grown], drawn: &mut [Vec<Point>], shown: f64, log: &mut Vec<Repair>) {
    let mut least = vec![1; drawn.len()];
    for root in grown.iter().filter(|g| g.tied) {
        if let Some(parent) = root.parent {
            least[parent] = least[parent].max(closest(&drawn[parent], &root.place));
        }
    }
    for (way, least) in drawn.iter_mut().zip(least) {
        let count = way.iter().rposition(|p| p[6].clamp(0.0, 1.0) >= shown - 1e-6).unwrap_or(0).max(least) + 1;
        if count >= way.len() {
            continue;
        }
        let length = curve::chord_lengths(&way[count - 1..]).last().copied().unwrap_or(0.0);
        let reason = format!("fewer than {:.0} % of the photographs show the tip", 100.0 * shown);
        log.push(Repair::new(Kind::Pruned, &curve::position(&way[way.len() - 1]), length, reason));
        way.truncate(count);
    }
}

/// Number of a line's point nearest to a place.
fn closest(line: &[Point], place: &Vec3) -> usize {
    let distance = |k: usize| (curve::position(&line[k]) - place).norm_squared();
    (0..line.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
}

/// Which roots stay: no specks, no spurs, none that too few photographs measure. A root whose laterals all go may go with them.
fn prune(
    grown: &[Grown],
    drawn: &[Vec<Point>],
    pieces: &Pieces,
    params: &HierarchyParams,
    log: &mut Vec<Repair>,
) -> Vec<bool> {
    let views = |p: &Point| p[5].max(0.0);
    let mut all: Vec<f64> = drawn.iter().flatten().map(views).collect();
    // What the photographs need is no chance, be they few.
    let least_views = if pieces.explained { 0.0 } else { params.seen * median(&mut all) };
    let mut keep = vec![true; grown.len()];
    let mut carried = vec![0_usize; grown.len()];
    grown.iter().filter_map(|g| g.parent).for_each(|p| carried[p] += 1);
    for r in (0..grown.len()).rev() {
        if carried[r] > 0 {
            continue;
        }
        let points = &drawn[r];
        let length = curve::chord_lengths(points).last().copied().unwrap_or(0.0);
        let views = points.iter().map(views).sum::<f64>() / points.len() as f64;
        let reason = match grown[r].parent {
            _ if grown[r].order > 0 && views < least_views => Some(format!(
                "measured by {views:.1} photographs on average, by {least_views:.1} at least it ought to be"
            )),
            None if grown[r].order > 0 && length < params.speck_mm => {
                Some(format!("hangs on nothing and is shorter than {} mm", params.speck_mm))
            }
            Some(parent) if grown[r].tied => {
                let radius = nearest(&drawn[parent], &grown[r].place).1;
                // Its farthest point, not its tip: a root may come back to the one that it hangs on.
                let away = |p: &Point| nearest(&drawn[parent], &curve::position(p)).0;
                let beyond = points.iter().map(away).fold(0.0, f64::max) - radius;
                let least = (params.spur_radii * radius).max(pieces.link_mm);
                (beyond < least).then(|| {
                    format!("a spur: {beyond:.1} mm beyond its parent's surface, under {least:.1} mm (radius {radius:.2} mm)")
                })
            }
            _ => None,
        };
        if let Some(reason) = reason {
            keep[r] = false;
            if let Some(parent) = grown[r].parent {
                carried[parent] -= 1;
            }
            let middle = points.get(points.len() / 2).map_or(grown[r].place, curve::position);
            log.push(Repair::new(Kind::Pruned, &middle, length, reason));
        }
    }
    keep
}

/// Distance to a line's nearest point, and the radius there, mm.
fn nearest(line: &[Point], p: &Vec3) -> (f64, f64) {
    line.iter()
        .map(|q| ((curve::position(q) - p).norm(), q[3]))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap_or((f64::INFINITY, 0.0))
}

/// Numbers by order, parents first, then from the parent's base to its tip.
fn number(grown: &[Grown], drawn: &[Vec<Point>], keep: &[bool]) -> Vec<TracedRoot> {
    let position = |r: usize| -> usize { grown[r].parent.map_or(0, |parent| closest(&drawn[parent], &grown[r].place)) };
    let mut list: Vec<usize> = (0..grown.len()).filter(|&r| keep[r] && drawn[r].len() > 1).collect();
    list.sort_by_key(|&r| (grown[r].order, r));
    let mut ids = vec![-1_i64; grown.len()];
    let mut roots: Vec<TracedRoot> = Vec::with_capacity(list.len());
    let mut from = 0;
    while from < list.len() {
        let order = grown[list[from]].order;
        let to = from + list[from..].iter().take_while(|&&r| grown[r].order == order).count();
        list[from..to].sort_by_cached_key(|&r| (grown[r].parent.map_or(-1, |p| ids[p]), position(r), r));
        for &r in &list[from..to] {
            ids[r] = roots.len() as i64;
            let points = &drawn[r];
            roots.push(TracedRoot {
                root: Root {
                    id: ids[r],
                    parent: grown[r].parent.map_or(-1, |p| ids[p]),
                    order,
                    points_mm: points.iter().map(|p| [p[0], p[1], p[2]]).collect(),
                    radii_mm: points.iter().map(|p| p[3].max(0.0)).collect(),
                },
                radius_sd_mm: points.iter().map(|p| p[4].max(0.0)).collect(),
                views: points.iter().map(|p| p[5].round().max(0.0) as u32).collect(),
                confidence: points.iter().map(|p| p[6].clamp(0.0, 1.0)).collect(),
            });
        }
        from = to;
    }
    roots
}
