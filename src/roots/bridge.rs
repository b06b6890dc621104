//! Pieces of one root are joined end to end where they continue each other; doubles of a stronger piece
//! are taken away before.
//!
//! Two ends may be joined over a gap g when both tangents point into it within `angle_deg` and the
//! rootness along the bridge (a cubic through both ends along both tangents) reaches `support` of the
//! weaker piece's mean over at least half of the seen way. Gaps no longer than a link need no
//! support. The cost is `g (1 + 4 (2 − cos α − cos β))`; joins are made by rising cost, one per end, none that
//! closes a ring; the pieces are fitted anew and the search repeats until nothing changes.

use super::link::{Union, tree_of, within};
use super::repair::{Kind, Repair};
use super::ridge::{Field, RidgePoint};
use super::strand::{End, Strand, knot_tree};
use crate::optics::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When two pieces are one root.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BridgeParams {
    /// Longest gap, mm, 0 to 30; a crossing root hides some diameters' length.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub gap_mm: f64,
    /// Largest angle between a piece's end and the gap, degrees, 10 to 80.
    #[schemars(range(min = 10.0, max = 80.0))]
    pub angle_deg: f64,
    /// Rootness along the gap against the weaker piece's mean, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub support: f64,
    /// Length over which the direction of an end is taken, mm, 1 to 10.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub baseline_mm: f64,
}

impl Default for BridgeParams {
    fn default() -> Self {
        Self { gap_mm: 8.0, angle_deg: 40.0, support: 0.25, baseline_mm: 3.0 }
    }
}

/// Everything that rebuilding a strand needs.
#[derive(Debug, Clone, Copy)]
pub struct Workshop<'a> {
    /// All ridge points.
    pub points: &'a [RidgePoint],
    /// The dense rootness.
    pub field: Field<'a>,
    /// Spacing of the knots, mm.
    pub step_mm: f64,
    /// Smoothing wavelength, mm.
    pub wavelength_mm: f64,
    /// Longest link between neighbouring ridge points, mm.
    pub link_mm: f64,
}

impl Workshop<'_> {
    /// The strand through ridge points in their order.
    pub fn strand(&self, points: Vec<usize>) -> Strand {
        Strand::new(points, self.points, self.step_mm, self.wavelength_mm)
    }

    /// Share of the seen samples between two places with a rootness of at least `level`, along the
    /// cubic with the given directions; 0.5 where nothing of the way is seen.
    pub fn support(&self, a: &Vec3, leave_a: &Vec3, b: &Vec3, leave_b: &Vec3, level: f64) -> f64 {
        let gap = (b - a).norm();
        let n = (gap / (0.5 * self.field.grid.spacing_mm)).ceil().max(2.0) as usize;
        let (mut seen, mut good) = (0u32, 0u32);
        for k in 1..n {
            let value = self.field.at(&cubic(a, &(leave_a * gap), b, &(-leave_b * gap), k as f64 / n as f64));
            if value.is_finite() {
                seen += 1;
                good += u32::from(value >= level);
            }
        }
        if seen == 0 { 0.5 } else { f64::from(good) / f64::from(seen) }
    }
}

/// The cubic from `a` with velocity `va` to `b` with velocity `vb` at `t` in 0..1 (Hermite).
pub fn cubic(a: &Vec3, va: &Vec3, b: &Vec3, vb: &Vec3, t: f64) -> Vec3 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0) + va * (t3 - 2.0 * t2 + t) + b * (3.0 * t2 - 2.0 * t3) + vb * (t3 - t2)
}

/// Takes away what runs along a longer strand closer than `distance_mm`: whole strands, or their ends.
pub fn drop_doubles(
    strands: Vec<Strand>,
    workshop: &Workshop<'_>,
    distance_mm: f64,
    log: &mut Vec<Repair>,
) -> Vec<Strand> {
    let mut order: Vec<usize> = (0..strands.len()).collect();
    let lengths: Vec<f64> = strands.iter().map(Strand::length_mm).collect();
    order.sort_by(|&a, &b| lengths[b].total_cmp(&lengths[a]).then(a.cmp(&b)));
    let mut kept: Vec<Strand> = Vec::new();
    let (places, tree) = knot_tree(&strands);
    let mut rank = vec![0; strands.len()];
    for (r, &s) in order.iter().enumerate() {
        rank[s] = r;
    }
    let reach = (distance_mm * distance_mm + 0.25 * workshop.step_mm * workshop.step_mm).sqrt();
    for &s in &order {
        let strand = &strands[s];
        let double = |point: usize| {
            let p = workshop.points[point].position_mm;
            let tangent = strand.tangent(strand.nearest(&p).0);
            within(&tree, &p, reach).iter().any(|&n| {
                let (other, k) = places[n];
                rank[other] < rank[s] && strands[other].tangent(k).dot(&tangent).abs() > 0.8
            })
        };
        let flags: Vec<bool> = strand.points.iter().map(|&p| double(p)).collect();
        let doubled = flags.iter().filter(|&&f| f).count();
        if doubled == 0 {
            kept.push(strand.clone());
            continue;
        }
        let from = flags.iter().position(|f| !f).unwrap_or(flags.len());
        let to = flags.iter().rposition(|f| !f).map_or(0, |k| k + 1);
        if to <= from + 1 || 10 * doubled >= 7 * flags.len() {
            log.push(Repair::new(
                Kind::Pruned,
                &strand.at(strand.knots.len() / 2),
                lengths[s],
                format!("{doubled} of {} ridge points run along a longer piece", flags.len()),
            ));
        } else if from > 0 || to < flags.len() {
            kept.push(workshop.strand(strand.points[from..to].to_vec()));
        } else {
            kept.push(strand.clone());
        }
    }
    kept.retain(|s| s.knots.len() > 1);
    kept
}

/// Joins the pieces end to end until nothing more fits.
pub fn bridge(
    mut strands: Vec<Strand>,
    workshop: &Workshop<'_>,
    params: &BridgeParams,
    log: &mut Vec<Repair>,
) -> Vec<Strand> {
    loop {
        let joins = candidates(&strands, workshop, params);
        let mut rings = Union::new(strands.len());
        let mut taken = vec![[None; 2]; strands.len()];
        let mut made = 0;
        for join in joins {
            let (a, b) = (join.from, join.to);
            if taken[a.0][a.1 as usize].is_some() || taken[b.0][b.1 as usize].is_some() || !rings.join(a.0, b.0) {
                continue;
            }
            taken[a.0][a.1 as usize] = Some(b);
            taken[b.0][b.1 as usize] = Some(a);
            made += 1;
            if join.gap_mm > workshop.link_mm {
                log.push(Repair::new(
                    Kind::Bridged,
                    &(0.5 * (strands[a.0].at(strands[a.0].end(a.1)) + strands[b.0].at(strands[b.0].end(b.1)))),
                    join.gap_mm,
                    format!(
                        "the ends continue each other within {:.0} and {:.0} degrees, rootness supports {:.0} % of the gap",
                        join.angles_deg[0],
                        join.angles_deg[1],
                        100.0 * join.support
                    ),
                ));
            }
        }
        if made == 0 {
            return strands;
        }
        strands = merged(&strands, &taken, workshop);
    }
}

/// A possible join.
struct Join {
    cost: f64,
    from: (usize, End),
    to: (usize, End),
    gap_mm: f64,
    angles_deg: [f64; 2],
    support: f64,
}

fn candidates(strands: &[Strand], workshop: &Workshop<'_>, params: &BridgeParams) -> Vec<Join> {
    let ends: Vec<(usize, End)> = (0..strands.len()).flat_map(|s| End::BOTH.into_iter().map(move |e| (s, e))).collect();
    let positions: Vec<Vec3> = ends.iter().map(|&(s, e)| strands[s].at(strands[s].end(e))).collect();
    let outward: Vec<Vec3> = ends.iter().map(|&(s, e)| strands[s].outward(e, params.baseline_mm)).collect();
    let tree = tree_of(positions.iter().enumerate());
    let straight = params.angle_deg.to_radians().cos();
    let mut joins = Vec::new();
    for a in 0..ends.len() {
        for b in within(&tree, &positions[a], params.gap_mm) {
            if b <= a || ends[a].0 == ends[b].0 {
                continue;
            }
            let way = positions[b] - positions[a];
            let gap = way.norm();
            let into = way / gap.max(1e-9);
            let (cos_a, cos_b) = (outward[a].dot(&into), -outward[b].dot(&into));
            if gap < 1e-9 || cos_a < straight || cos_b < straight || -outward[a].dot(&outward[b]) < straight {
                continue;
            }
            let level = params.support * strands[ends[a].0].mean(3).min(strands[ends[b].0].mean(3));
            let support = workshop.support(&positions[a], &outward[a], &positions[b], &outward[b], level);
            if gap > workshop.link_mm && support < 0.5 {
                continue;
            }
            joins.push(Join {
                cost: gap * (1.0 + 4.0 * (2.0 - cos_a - cos_b)),
                from: ends[a],
                to: ends[b],
                gap_mm: gap,
                angles_deg: [cos_a, cos_b].map(|c| c.min(1.0).acos().to_degrees()),
                support,
            });
        }
    }
    joins.sort_by(|a, b| a.cost.total_cmp(&b.cost).then((a.from, a.to).cmp(&(b.from, b.to))));
    joins
}

/// The strands after the joins that `taken` names per strand and end.
pub(super) fn merged(strands: &[Strand], taken: &[[Option<(usize, End)>; 2]], workshop: &Workshop<'_>) -> Vec<Strand> {
    let mut seen = vec![false; strands.len()];
    let mut result = Vec::new();
    for start in 0..strands.len() {
        let Some(free) = End::BOTH.into_iter().find(|&e| taken[start][e as usize].is_none()) else { continue };
        if seen[start] {
            continue;
        }
        let (mut points, mut at, mut enter, mut joined) = (Vec::new(), start, free, false);
        loop {
            seen[at] = true;
            let own = strands[at].points.iter().copied();
            match enter {
                End::First => points.extend(own),
                End::Last => points.extend(own.rev()),
            }
            match taken[at][enter.other() as usize] {
                None => break,
                Some((next, end)) => (at, enter, joined) = (next, end, true),
            }
        }
        result.push(if joined { workshop.strand(points) } else { strands[start].clone() });
    }
    result
}
