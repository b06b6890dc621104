//! Where a strand's end may spring from another strand.
//!
//! A tie leads from an end to a knot of another strand. Its gap is measured from the surface of that
//! strand (its radius is taken off), because a root's own light hides the base of its laterals. Ties longer
//! than a link must leave the end within `angle_deg`. The cost is
//! `gap (1 + 2 (1 − cos α)) (2 − support)`, support as for bridges; per end and other strand the cheapest knot counts.

use super::bridge::Workshop;
use super::strand::{End, Strand};
use serde::{Deserialize, Serialize};

/// When a root springs from another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TieParams {
    /// Longest gap between a lateral's first ridge point and its parent's surface, mm, 0 to 30.
    pub gap_mm: f64,
    /// Largest angle between the lateral's first direction and the way to its parent, degrees, 10 to 90.
    pub angle_deg: f64,
    /// Rootness along the gap against the lateral's mean, 0 to 1, that counts as support.
    pub support: f64,
    /// Length over which directions are taken, mm, 1 to 10.
    pub baseline_mm: f64,
}

impl Default for TieParams {
    fn default() -> Self {
        Self { gap_mm: 6.0, angle_deg: 60.0, support: 0.25, baseline_mm: 3.0 }
    }
}

/// A possible tie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tie {
    /// The strand that springs.
    pub strand: usize,
    /// Its end at the tie.
    pub end: End,
    /// The strand it springs from.
    pub onto: usize,
    /// The knot it springs from.
    pub knot: usize,
    /// Distance from the end to the other's surface, mm, ≥ 0.
    pub gap_mm: f64,
    /// Smaller is likelier, mm.
    pub cost: f64,
}

/// Every tie that `params` allow, by rising cost.
pub fn ties(strands: &[Strand], workshop: &Workshop<'_>, params: &TieParams) -> Vec<Tie> {
    let slanted = params.angle_deg.to_radians().cos();
    let mut all = Vec::new();
    for (s, strand) in strands.iter().enumerate() {
        for end in End::BOTH {
            let from = strand.at(strand.end(end));
            let outward = strand.outward(end, params.baseline_mm);
            let level = params.support * strand.mean(3);
            for (o, onto) in strands.iter().enumerate().filter(|&(o, _)| o != s) {
                let mut best: Option<Tie> = None;
                for k in 0..onto.knots.len() {
                    let way = onto.at(k) - from;
                    let distance = way.norm();
                    let gap = (distance - onto.radius_mm(k)).max(0.0);
                    if gap > params.gap_mm {
                        continue;
                    }
                    let cos = if distance > 1e-9 { outward.dot(&way) / distance } else { 1.0 };
                    if gap > workshop.link_mm && cos < slanted {
                        continue;
                    }
                    // The axis distance orders the knots within the surface.
                    let cost = (gap + 0.1 * distance) * (1.0 + 2.0 * (1.0 - cos));
                    if best.is_none_or(|b| cost < b.cost) {
                        best = Some(Tie { strand: s, end, onto: o, knot: k, gap_mm: gap, cost });
                    }
                }
                if let Some(mut tie) = best {
                    if tie.gap_mm > workshop.link_mm {
                        let to = onto.at(tie.knot);
                        let straight = (to - from).normalize();
                        tie.cost *= 2.0 - workshop.support(&from, &straight, &to, &-straight, level);
                    }
                    all.push(tie);
                }
            }
        }
    }
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost).then((a.strand, a.end, a.onto).cmp(&(b.strand, b.end, b.onto))));
    all
}
