//! Loose ends are followed along ridges too weak to be traced by themselves.
//!
//! Where a root ends, its ridge fades over the reach of the kernels and the taper of the tip, below what hysteresis may let
//! through everywhere. From a loose end on, a ridge point goes on that is as near as a link, as straight as a link (both by
//! [`LinkParams`], against the end's own direction over `baseline_mm` too) and at least `share` as strong as `trace.low`;
//! the cheapest link is taken, and so on until `longest_mm` are gone, or another strand, with what was followed from it, is a
//! link away. Strands of most points go first.

use super::bridge::Workshop;
use super::link::{LinkParams, Node, cost, tree_of, within};
use super::repair::{Kind, Repair};
use super::strand::{End, Strand};
use crate::optics::Vec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How far loose ends are followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExtendParams {
    /// Rootness that a ridge needs to be followed from an end on, in shares of `trace.low`, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub share: f64,
    /// Way after which an end is followed no farther, mm, 0 (none is followed) to 50.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub longest_mm: f64,
    /// Length over which the direction of an end is taken, mm, 1 to 10.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub baseline_mm: f64,
}

impl Default for ExtendParams {
    fn default() -> Self {
        Self { share: 0.8, longest_mm: 10.0, baseline_mm: 3.0 }
    }
}

/// The strands with their loose ends followed along the points from `weak` on.
pub fn extend(
    strands: Vec<Strand>,
    weak: usize,
    workshop: &Workshop<'_>,
    links: &LinkParams,
    params: &ExtendParams,
    log: &mut Vec<Repair>,
) -> Vec<Strand> {
    let points = workshop.points;
    let free = tree_of((weak..points.len()).map(|k| (k, &points[k].position_mm)));
    let mut places: Vec<(usize, Vec3)> = strands
        .iter()
        .enumerate()
        .flat_map(|(s, strand)| strand.points.iter().map(move |&k| (s, k)))
        .map(|(s, k)| (s, points[k].position_mm))
        .collect();
    let mut taken = tree_of(places.iter().map(|p| &p.1).enumerate());
    let straight = links.angle_deg.to_radians().cos();
    let mut order: Vec<usize> = (0..strands.len()).collect();
    order.sort_by(|&a, &b| strands[b].points.len().cmp(&strands[a].points.len()).then(a.cmp(&b)));
    let mut used = vec![false; points.len()];
    let mut result = strands.clone();
    for s in order {
        for end in End::BOTH {
            // The strand's points, the end last, and what follows it.
            let mut chain = strands[s].points.clone();
            if end == End::First {
                chain.reverse();
            }
            let before = chain.len();
            let mut gone = 0.0;
            loop {
                let from = points[chain[chain.len() - 1]];
                let near = within(&taken, &from.position_mm, workshop.link_mm);
                if gone >= params.longest_mm || near.iter().any(|&n| places[n].0 != s) {
                    break;
                }
                let Some(onward) = direction(&chain, workshop, params.baseline_mm) else { break };
                let next = within(&free, &from.position_mm, workshop.link_mm)
                    .into_iter()
                    .filter(|&k| !used[k])
                    .filter(|&k| {
                        let way = points[k].position_mm - from.position_mm;
                        way.dot(&onward) >= straight * way.norm() && points[k].tangent.dot(&onward).abs() >= straight
                    })
                    .filter_map(|k| Some((cost(&from, &points[k], straight)?, k)))
                    .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let Some((_, next)) = next else { break };
                gone += (points[next].position_mm - from.position_mm).norm();
                used[next] = true;
                chain.push(next);
                let place = points[next].position_mm;
                taken.insert(Node::new([place.x, place.y, place.z], places.len()));
                places.push((s, place));
            }
            if chain.len() == before {
                continue;
            }
            log.push(Repair::new(
                Kind::Extended,
                &points[chain[before]].position_mm,
                gone,
                "an end was followed along a ridge too weak to be traced by itself".to_owned(),
            ));
            let more = chain.split_off(before);
            match end {
                End::First => _ = result[s].points.splice(0..0, more.into_iter().rev()),
                End::Last => result[s].points.extend(more),
            }
        }
        if result[s].points.len() > strands[s].points.len() {
            result[s] = workshop.strand(std::mem::take(&mut result[s].points));
        }
    }
    result
}

/// Unit chord over the last `over_mm` of a chain of points; none where that is a point.
fn direction(chain: &[usize], workshop: &Workshop<'_>, over_mm: f64) -> Option<Vec3> {
    let at = |k: usize| workshop.points[chain[k]].position_mm;
    let last = chain.len() - 1;
    let far = (0..last).rev().find(|&k| (at(k) - at(last)).norm() >= over_mm).unwrap_or(0);
    (at(last) - at(far)).try_normalize(1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roots::ridge::{Field, RidgePoint};
    use crate::volume::Grid;
    use ndarray::Array3;

    fn line(from: Vec3, to: Vec3) -> Vec<RidgePoint> {
        let n = ((to - from).norm() / 0.5).round() as usize;
        let point = |k: usize| RidgePoint {
            position_mm: from + (to - from) * (k as f64 / n as f64),
            tangent: (to - from).normalize(),
            rootness: 1.0,
            sigma_mm: 0.3,
            strong: false,
        };
        (0..n).map(point).collect()
    }

    /// Length of the strand along x up to 10 mm, with these weak ridges and perhaps another strand; and the number of repairs.
    fn followed(weak: &[[Vec3; 2]], other: Option<[Vec3; 2]>, longest_mm: f64) -> (f64, usize) {
        let mut points = line(Vec3::zeros(), Vec3::x() * 10.0);
        let mut chains = vec![(0..points.len()).collect::<Vec<_>>()];
        if let Some([from, to]) = other {
            let first = points.len();
            points.extend(line(from, to));
            chains.push((first..points.len()).collect());
        }
        let strong = points.len();
        weak.iter().for_each(|[from, to]| points.extend(line(*from, *to)));
        let rootness = Array3::zeros((2, 2, 2));
        let grid = Grid { origin_mm: [0.0; 3], spacing_mm: 0.5, shape: [2, 2, 2] };
        let field = Field { grid, rootness: rootness.view() };
        let workshop = Workshop { points: &points, field, step_mm: 0.5, wavelength_mm: 6.0, link_mm: 1.3 };
        let strands = chains.into_iter().map(|chain| workshop.strand(chain)).collect();
        let params = ExtendParams { longest_mm, ..ExtendParams::default() };
        let mut log = Vec::new();
        let found = extend(strands, strong, &workshop, &LinkParams::default(), &params, &mut log);
        (found[0].length_mm(), log.len())
    }

    #[test]
    fn a_loose_end_goes_on_where_the_ridge_does() {
        let near = |a: f64, b: f64| (a - b).abs() < 0.6;
        let on = [Vec3::x() * 10.0, Vec3::x() * 15.0];
        let (length, repairs) = followed(&[on], None, 10.0);
        assert!(near(length, 14.5) && repairs == 1, "{length}");
        // A bit off, at the other end too, no farther than asked.
        let back = [Vec3::new(-0.5, 0.1, 0.0), Vec3::new(-4.5, 1.0, 0.0)];
        assert!(near(followed(&[on, back], None, 10.0).0, 18.6));
        assert!(near(followed(&[on], None, 2.0).0, 11.8));
        assert_eq!(followed(&[on], None, 0.0), followed(&[], None, 10.0));
    }

    #[test]
    fn what_lies_aside_across_or_beyond_a_gap_is_not_followed() {
        let gap = [Vec3::x() * 12.0, Vec3::x() * 16.0];
        let across = [Vec3::new(10.0, -2.0, 0.0), Vec3::new(10.0, 2.0, 0.0)];
        let aside = [Vec3::new(10.0, 0.9, 0.0), Vec3::new(14.0, 6.0, 0.0)];
        for weak in [gap, across, aside] {
            assert_eq!(followed(&[weak], None, 10.0).1, 0, "{weak:?}");
        }
        // A root that stands in the way ends it.
        let other = [Vec3::new(13.0, -5.0, 0.0), Vec3::new(13.0, 5.0, 0.0)];
        let (length, _) = followed(&[[Vec3::x() * 10.0, Vec3::x() * 18.0]], Some(other), 10.0);
        assert!(length > 10.0 && length < 13.0, "{length}");
    }
}
