//! An earlier day read by a later one: what lies on one root of the later day is one root.
//!
//! Roots do not move and only grow, so that the roots of a day lie on those of the next, which are longer and easier to tell apart.
//! Where a root of the earlier day lies on several of the later, it is cut; stretches that lie on one are joined in its
//! order, over gaps of [`GAP_MM`] at most, whichever way they were traced. What lies on none stays as it is.

use super::rehang::{Rehung, joined, orders};
use crate::growth::overlap::Known;
use crate::optics::Vec3;
use crate::roots::TracedRoot;
use std::ops::Range;

/// Shorter stretches go with their neighbours: near a fork a point lies on both.
const SHORT_MM: f64 = 3.0;
/// Longest gap that is joined over, mm.
const GAP_MM: f64 = 8.0;

/// A stretch of an earlier root with the later root that it lies on.
#[derive(Debug, Clone)]
struct Stretch {
    root: usize,
    points: Range<usize>,
    on: Option<usize>,
    /// Arc positions on the later root, mm, least and greatest.
    arcs_mm: [f64; 2],
    /// Whether it was traced from tip to base.
    backwards: bool,
}

/// Reads day `day` by the next one, `later`; says where roots were cut.
pub(super) fn read_by(day: usize, roots: &mut Vec<TracedRoot>, later: &[TracedRoot], within_mm: f64) -> Vec<Rehung> {
    let known = Known::of(later.iter().map(|r| &r.root), within_mm);
    // Of every point the later roots beside it, with the arc positions there.
    let on = |traced: &TracedRoot| -> Vec<Vec<(usize, f64)>> {
        let points = &traced.root.points_mm;
        let at = |k: usize| {
            let (from, to) = (points[k.saturating_sub(2)], points[(k + 2).min(points.len() - 1)]);
            let direction = (Vec3::from(to) - Vec3::from(from)).try_normalize(1e-9).unwrap_or_else(Vec3::z);
            let beside = known.beside(&Vec3::from(points[k]), &direction, true);
            beside.into_iter().map(|b| (b.root, b.arc_mm)).collect()
        };
        (0..points.len()).map(at).collect()
    };
    let (mut stretches, mut cuts) = (Vec::new(), Vec::new());
    for (n, traced) in roots.iter().enumerate() {
        let own = stretched(n, traced, &on(traced));
        for pair in own.windows(2) {
            cuts.push(Rehung { day, by: day + 1, place_mm: traced.root.points_mm[pair[1].points.start] });
        }
        stretches.extend(own);
    }
    let backwards = stretches.iter().any(|s| s.backwards && s.on.is_some());
    if !cuts.is_empty() || backwards || has_joins(&stretches) {
        *roots = assembled(roots, later, stretches);
    }
    cuts
}

fn has_joins(stretches: &[Stretch]) -> bool {
    let mut on: Vec<usize> = stretches.iter().filter_map(|s| s.on).collect();
    on.sort_unstable();
    on.windows(2).any(|pair| pair[0] == pair[1])
}

/// A root in stretches by the later roots that it lies on.
fn stretched(n: usize, traced: &TracedRoot, on: &[Vec<(usize, f64)>]) -> Vec<Stretch> {
    let points = &traced.root.points_mm;
    let mut labels: Vec<Option<usize>> = on.iter().map(|near| near.first().map(|(root, _)| *root)).collect();
    let mut runs: Vec<Range<usize>> = Vec::new();
    for k in 0..labels.len() {
        match runs.last_mut() {
            Some(run) if labels[run.start] == labels[k] => run.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    let length = |run: &Range<usize>| -> f64 {
        let end = run.end.min(points.len() - 1);
        (run.start..end).map(|k| (Vec3::from(points[k + 1]) - Vec3::from(points[k])).norm()).sum()
    };
    // Short runs go to the longer neighbour, the shortest first.
    while runs.len() > 1 {
        let Some(at) = (0..runs.len()).min_by(|&a, &b| length(&runs[a]).total_cmp(&length(&runs[b]))) else { break };
        if length(&runs[at]) >= SHORT_MM {
            break;
        }
        let left = at.checked_sub(1).map_or(-1.0, |k| length(&runs[k]));
        let right = runs.get(at + 1).map_or(-1.0, length);
        let to = if left >= right { at - 1 } else { at + 1 };
        let label = labels[runs[to].start];
        for k in runs[at].clone() {
            labels[k] = label;
        }
        let (low, high) = (at.min(to), at.max(to));
        runs[low] = runs[low].start..runs[high].end;
        runs.remove(high);
        // Neighbours that are now alike are one.
        let mut k = 1;
        while k < runs.len() {
            if labels[runs[k - 1].start] == labels[runs[k].start] {
                runs[k - 1] = runs[k - 1].start..runs[k].end;
                runs.remove(k);
            } else {
                k += 1;
            }
        }
    }
    let of = |run: Range<usize>| {
        let label = labels[run.start];
        let arc = |k: usize| on[k].iter().find(|(root, _)| Some(*root) == label).map(|(_, arc)| *arc);
        let arcs: Vec<f64> = run.clone().filter_map(arc).collect();
        let low = arcs.iter().copied().fold(f64::INFINITY, f64::min);
        let high = arcs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let half = arcs.len() / 2;
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
        let backwards = arcs.len() > 3 && mean(&arcs[..half]) > mean(&arcs[half..]);
        Stretch { root: n, points: run, on: label, arcs_mm: [low, high], backwards }
    };
    runs.into_iter().map(of).collect()
}

/// Roots put together from stretches.
fn assembled(roots: &[TracedRoot], later: &[TracedRoot], stretches: Vec<Stretch>) -> Vec<TracedRoot> {
    let piece = |s: &Stretch| {
        // The corner between two stretches belongs to both.
        let from = s.points.start.saturating_sub(usize::from(s.points.start > 0));
        let mut piece = joined(&roots[s.root], from..s.points.end, None);
        if s.backwards && s.on.is_some() {
            piece.root.points_mm.reverse();
            piece.root.radii_mm.reverse();
            piece.radius_sd_mm.reverse();
            piece.views.reverse();
            piece.confidence.reverse();
        }
        piece
    };
    let mut made: Vec<(Option<usize>, i64, TracedRoot)> = Vec::new();
    for other in 0..later.len() {
        let mut own: Vec<&Stretch> = stretches.iter().filter(|s| s.on == Some(other)).collect();
        own.sort_by(|a, b| a.arcs_mm[0].total_cmp(&b.arcs_mm[0]));
        let mut reached = f64::NEG_INFINITY;
        for s in own {
            let gap = s.arcs_mm[0] - reached;
            // What doubles a stretch stays beside it.
            let doubles = s.arcs_mm[1] <= reached + SHORT_MM;
            match made.last_mut() {
                Some((Some(on), _, whole)) if *on == other && gap < GAP_MM && !doubles => {
                    *whole = joined(whole, 0..whole.root.points_mm.len(), Some(&piece(s)));
                }
                _ => made.push((Some(other), roots[s.root].root.parent, piece(s))),
            }
            reached = reached.max(s.arcs_mm[1]);
        }
    }
    made.extend(stretches.iter().filter(|s| s.on.is_none()).map(|s| (None, roots[s.root].root.parent, piece(s))));
    let number = |id: i64| -> Option<i64> {
        // The first root of this day that lies on that later one.
        let at = later.iter().position(|r| r.root.id == id)?;
        made.iter().position(|(on, ..)| *on == Some(at)).map(|k| k as i64)
    };
    let parents: Vec<i64> = made
        .iter()
        .map(|(on, before, _)| match on {
            Some(on) => {
                let mut up = later[*on].root.parent;
                // A parent that is not seen this day is skipped.
                loop {
                    match (number(up), later.iter().find(|r| r.root.id == up)) {
                        (Some(found), _) => break found,
                        (None, Some(above)) => up = above.root.parent,
                        (None, None) => break -1,
                    }
                }
            }
            None => {
                let main = stretches.iter().find(|s| roots[s.root].root.id == *before).and_then(|s| s.on);
                main.and_then(|on| made.iter().position(|(other, ..)| *other == Some(on))).map_or(-1, |k| k as i64)
            }
        })
        .collect();
    let mut new: Vec<TracedRoot> = made.into_iter().map(|(.., root)| root).collect();
    for (k, root) in new.iter_mut().enumerate() {
        (root.root.id, root.root.parent) = (k as i64, if parents[k] == k as i64 { -1 } else { parents[k] });
    }
    new.retain(|r| r.root.points_mm.len() > 1);
    orders(&mut new);
    new
}
