//! Where a strand's end may spring from another strand.
//!
//! A tie leads from an end to a knot of another strand. Its gap is measured from the surface of that
//! strand (its radius is taken off), because a root's own light hides the base of its laterals. Ties longer
//! than a link must leave the end within `angle_deg`. The cost is
//! `(gap + distance / 10) (1 + 2 (1 − cos α)) (2 − support)`, support as for bridges (1 for a link's length); the
//! distance to the axis orders the knots within the surface. Per end and other strand the cheapest knot counts.

use super::bridge::Workshop;
use super::strand::{End, Strand};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a root springs from another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TieParams {
    /// Longest gap between a lateral's first ridge point and its parent's surface, mm, 0 to 30.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub gap_mm: f64,
    /// Largest angle between the lateral's first direction and the way to its parent, degrees, 10 to 90.
    #[schemars(range(min = 10.0, max = 90.0))]
    pub angle_deg: f64,
    /// Rootness along the gap against the lateral's mean, 0 to 1, that counts as support.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub support: f64,
    /// Length over which directions are taken, mm, 1 to 10.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub baseline_mm: f64,
}

impl Default for TieParams {
    fn default() -> Self {
        Self { gap_mm: 6.0, angle_deg: 60.0, support: 0.25, baseline_mm: 3.0 }
    }
}

/// A possible tie.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Tie {
    /// The strand that springs.
    pub strand: usize,
    /// Its end at the tie.
    pub end: End,
    /// The strand it springs from.
    pub onto: usize,
    /// The knot it springs from.
    pub knot: usize,
    /// Distance from the end to the other's axis, mm.
    pub distance_mm: f64,
    /// Cosine of the angle between the strand's way out and the way to the knot.
    pub cosine: f64,
    /// Share of the gap that shows rootness, 0 to 1.
    pub support: f64,
}

impl Tie {
    /// Smaller is likelier, mm; `radius_mm` is the other strand's at the knot.
    pub fn cost(&self, radius_mm: f64) -> f64 {
        let gap = (self.distance_mm - radius_mm).max(0.0);
        (gap + 0.1 * self.distance_mm) * (1.0 + 2.0 * (1.0 - self.cosine)) * (2.0 - self.support)
    }
}

/// Every tie that `params` allow, by strand, end and other strand.
pub fn ties(strands: &[Strand], workshop: &Workshop<'_>, params: &TieParams) -> Vec<Tie> {
    let slanted = params.angle_deg.to_radians().cos();
    let mut all = Vec::new();
    for (s, strand) in strands.iter().enumerate() {
        for end in End::BOTH {
            let from = strand.at(strand.end(end));
            let outward = strand.outward(end, params.baseline_mm);
            let level = params.support * strand.mean(3);
            for (o, onto) in strands.iter().enumerate().filter(|&(o, _)| o != s) {
                let mut best: Option<(f64, Tie)> = None;
                for knot in 0..onto.knots.len() {
                    let way = onto.at(knot) - from;
                    let distance_mm = way.norm();
                    let gap = distance_mm - onto.radius_mm(knot);
                    if gap > params.gap_mm {
                        continue;
                    }
                    let cosine = if distance_mm > 1e-9 { outward.dot(&way) / distance_mm } else { 1.0 };
                    if gap > workshop.link_mm && cosine < slanted {
                        continue;
                    }
                    let tie = Tie { strand: s, end, onto: o, knot, distance_mm, cosine, support: 1.0 };
                    let cost = tie.cost(onto.radius_mm(knot));
                    if best.is_none_or(|b| cost < b.0) {
                        best = Some((cost, tie));
                    }
                }
                if let Some((_, mut tie)) = best {
                    let to = onto.at(tie.knot);
                    if tie.distance_mm - onto.radius_mm(tie.knot) > workshop.link_mm {
                        let straight = (to - from).normalize();
                        tie.support = workshop.support(&from, &straight, &to, &-straight, level);
                    }
                    all.push(tie);
                }
            }
        }
    }
    all
}
