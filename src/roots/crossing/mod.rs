//! Where roots cross or touch, the ways through are paired anew.
//!
//! Links pair what continues each other from voxel to voxel. At a crossing the ridges of both roots run together for a few
//! voxels, and one root may go on in the other's ridge, or end in it. A crossing is where strands touch: knots no farther
//! apart than a link (and the radius, up to half a link). Touching knots closer along a strand than two links belong to one
//! crossing; a strand that runs through is cut in the middle of them.
//!
//! A way is judged from where it leaves the others: half a link beyond its last touching knot, one link from the
//! crossing at least; its direction is the chord over the next `baseline_mm`. Two ways may be one root when the straight way
//! between turns from both by α + β <= `angle_deg` in all. That costs ½ ((α + β) / `bend_deg`)²; a way that stays
//! alone costs `alone`. The cheapest pairing of all ways is taken, where that which stood costs `alone` less and nothing
//! closes a ring. What goes on anew loses the points that it shares with others. Where a lateral leaves, bends alone may
//! choose wrongly; thickness is weighed there later ([`super::hierarchy`]).

mod cut;
mod pairing;
#[cfg(test)]
mod tests;

use super::bridge::{Workshop, merged};
use super::curve;
use super::repair::{Kind, Repair};
use super::strand::{End, Strand};
use crate::optics::Vec3;
use cut::{Cut, Links, Meeting, SegmentEnd, cut};
use pairing::{Pairing, cheapest};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Ways at one crossing beyond which no pairing is sought.
const MOST_WAYS: usize = 10;

/// How ways are paired where roots cross.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct CrossingParams {
    /// Length over which a way's direction is taken, mm, 1 to 20.
    #[schemars(range(min = 1.0, max = 20.0))]
    pub baseline_mm: f64,
    /// Largest bend of a root across a crossing, degrees, 0 to 90; 0 leaves every crossing as it is.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub angle_deg: f64,
    /// Standard deviation of a root's bend across a crossing, degrees, 1 to 90.
    #[schemars(range(min = 1.0, max = 90.0))]
    pub bend_deg: f64,
    /// What a way costs that begins or ends at a crossing; a bend of one standard deviation costs 0.5.
    #[schemars(range(min = 0.0))]
    pub alone: f64,
}

impl Default for CrossingParams {
    fn default() -> Self {
        Self { baseline_mm: 4.0, angle_deg: 60.0, bend_deg: 20.0, alone: 1.0 }
    }
}

/// The strands, their ways paired anew at every crossing.
pub fn resolve(
    strands: Vec<Strand>,
    workshop: &Workshop<'_>,
    params: &CrossingParams,
    log: &mut Vec<Repair>,
) -> Vec<Strand> {
    if params.angle_deg <= 0.0 {
        return strands;
    }
    let Cut { mut segments, mut taken, crossings } = cut(&strands, workshop);
    let mut changed = false;
    for meeting in &crossings {
        if meeting.len() > MOST_WAYS {
            continue;
        }
        let ends: Vec<SegmentEnd> = meeting.iter().map(|m| m.0).collect();
        let way = |&(end, shared_mm): &Meeting| Way::new(end, shared_mm, &segments, workshop.link_mm, params);
        let ways: Vec<Way> = meeting.iter().map(way).collect();
        let stood = standing(&ends, &taken);
        let best = cheapest(&costs(&ways, &stood, params), params.alone, &stood);
        if best == stood {
            continue;
        }
        let Some(linked) = linked(&ends, &best, &taken) else { continue };
        taken = linked;
        changed = true;
        let place = ways.iter().map(|w| w.at).sum::<Vec3>() / ways.len() as f64;
        log.push(Repair::new(Kind::Repaired, &place, 0.0, reason(&ways, &best)));
        for (a, way) in ways.iter().enumerate().filter(|&(a, _)| best[a].is_some() && best[a] != stood[a]) {
            trim(&mut segments[ends[a].0], ends[a].1, way.skip_mm, workshop);
        }
    }
    if changed { merged(&segments, &taken, workshop) } else { strands }
}

/// A way out of a crossing, seen from beyond what it shares with others.
struct Way {
    at: Vec3,
    /// Unit direction towards the crossing.
    inward: Vec3,
    /// What lies before `at`, mm.
    skip_mm: f64,
}

impl Way {
    fn new(own: SegmentEnd, shared_mm: f64, segments: &[Strand], link_mm: f64, params: &CrossingParams) -> Self {
        let (strand, end) = (&segments[own.0], own.1);
        let last = strand.knots.len() - 1;
        let number = |k: usize| if end == End::First { k } else { last - k };
        let arcs = curve::chord_lengths(&strand.knots);
        let way = |k: usize| (arcs[number(k)] - arcs[number(0)]).abs();
        // A short way is judged by what there is of it.
        let skip = (shared_mm + 0.5 * link_mm).max(link_mm).min(0.5 * way(last));
        let from = (0..last).find(|&k| way(k) >= skip).unwrap_or(0);
        let to = (from + 1..=last).find(|&k| way(k) - way(from) >= params.baseline_mm).unwrap_or(last);
        let at = strand.at(number(from));
        let inward = (at - strand.at(number(to))).try_normalize(1e-9).unwrap_or_else(Vec3::zeros);
        Self { at, inward, skip_mm: way(from) }
    }

    /// How much a root turns that goes on from one way in the other, degrees.
    fn bend_deg(&self, other: &Self) -> f64 {
        let Some(across) = (other.at - self.at).try_normalize(1e-9) else { return 180.0 };
        let angle = |cosine: f64| cosine.clamp(-1.0, 1.0).acos().to_degrees();
        angle(self.inward.dot(&across)) + angle(-other.inward.dot(&across))
    }
}

/// The pairs of a crossing's ways as they are linked.
fn standing(ends: &[SegmentEnd], taken: &Links) -> Pairing {
    ends.iter()
        .map(|&(segment, end)| {
            let on = taken[segment][end as usize]?;
            ends.iter().position(|&e| e == on)
        })
        .collect()
}

/// What it costs that two ways are one root; infinite where they cannot be.
fn costs(ways: &[Way], stood: &Pairing, params: &CrossingParams) -> Vec<Vec<f64>> {
    let cost = |a: usize, b: usize| {
        let bend = ways[a].bend_deg(&ways[b]);
        if a != b && (bend <= params.angle_deg || stood[a] == Some(b)) {
            0.5 * (bend / params.bend_deg).powi(2)
        } else {
            f64::INFINITY
        }
    };
    (0..ways.len()).map(|a| (0..ways.len()).map(|b| cost(a, b)).collect()).collect()
}

/// The links with a crossing's ways paired so; none where that would close a ring.
fn linked(ends: &[SegmentEnd], pairing: &Pairing, taken: &Links) -> Option<Links> {
    let mut links = taken.clone();
    for &(segment, end) in ends {
        if links[segment][end as usize].is_some_and(|on| ends.contains(&on)) {
            links[segment][end as usize] = None;
        }
    }
    for (a, b) in pairing.iter().enumerate().filter_map(|(a, b)| b.filter(|&b| b > a).map(|b| (a, b))) {
        let (from, onto) = (ends[a], ends[b]);
        let mut at = from;
        loop {
            if at.0 == onto.0 {
                return None;
            }
            match links[at.0][at.1.other() as usize] {
                None => break,
                Some(next) => at = next,
            }
        }
        links[from.0][from.1 as usize] = Some(onto);
        links[onto.0][onto.1 as usize] = Some(from);
    }
    Some(links)
}

/// Takes away what a segment shares with others at an end, two points left at least.
fn trim(segment: &mut Strand, end: End, skip_mm: f64, workshop: &Workshop<'_>) {
    let place = |n: usize| workshop.points[segment.points[n]].position_mm;
    let steps = (1..segment.points.len()).map(|n| (place(n) - place(n - 1)).norm());
    let mut arcs = vec![0.0];
    steps.for_each(|step| arcs.push(arcs[arcs.len() - 1] + step));
    let from = if end == End::First { 0.0 } else { arcs[arcs.len() - 1] };
    let far = |&n: &usize| (arcs[n] - from).abs() >= skip_mm;
    let count = segment.points.len();
    let kept = match end {
        End::First => (0..count).find(far).unwrap_or(count).min(count - 2)..count,
        End::Last => 0..(0..count).rev().find(far).map_or(0, |n| n + 1).max(2),
    };
    *segment = workshop.strand(segment.points[kept].to_vec());
}

fn reason(ways: &[Way], pairing: &Pairing) -> String {
    let bends: Vec<String> = pairing
        .iter()
        .enumerate()
        .filter_map(|(a, b)| b.filter(|&b| b > a).map(|b| format!("{:.0}", ways[a].bend_deg(&ways[b]))))
        .collect();
    if bends.is_empty() {
        return format!("none of {} ways that meet goes on in another: all bend too much", ways.len());
    }
    format!("of {} ways that meet, those go on in each other that bend by {} degrees", ways.len(), bends.join(", "))
}
