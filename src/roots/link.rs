//! Ridge points become chains: a graph in which every point has two sides, one along its tangent and
//! one against it, and each side holds one link at most.
//!
//! - Thinning: where two points mark the same place of one crest (closer than `same_along` spacings along
//!   and `same_across` across the stronger one's tangent, tangents
//!   within half of `angle_deg`), the stronger stays.
//! - A link p–q may be when it is shorter than `reach` spacings and bends at neither end, nor between the
//!   two tangents, by more than `angle_deg`. Its cost is its length times `1 + 8 (3 − cos α − cos β
//!   − cos γ)` (α, β: link against the tangents, γ: tangent against tangent): a bend of 25 degrees at either end weighs as
//!   much as twice the length, so that a straight link leaves out a point beside it.
//! - Links are taken by rising cost when both sides are free and no ring closes (ties: lower indices).
//!
//! At a junction the two branches that continue each other take each other's sides, so the third ends
//! there; at a crossing each root passes through. A chain is therefore one voxel thick by construction.

use super::ridge::RidgePoint;
use crate::optics::Vec3;
use rstar::RTree;
use rstar::primitives::GeomWithData;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When neighbouring ridge points belong to one curve.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LinkParams {
    /// Longest link, in voxels, 1 to 5; voxels of one crest lie at most √3 apart, one may be missing.
    #[schemars(range(min = 1.0, max = 5.0))]
    pub reach: f64,
    /// Largest bend of a link, degrees, 20 to 80; half a right angle is the coarsest voxel direction.
    #[schemars(range(min = 20.0, max = 80.0))]
    pub angle_deg: f64,
    /// Two points mark the same place when closer along the tangent than this, in voxels, 0 to 1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub same_along: f64,
    /// ... and closer across the tangent than this, in voxels, 0 to 2.
    #[schemars(range(min = 0.0, max = 2.0))]
    pub same_across: f64,
}

impl Default for LinkParams {
    fn default() -> Self {
        Self { reach: 2.6, angle_deg: 45.0, same_along: 0.5, same_across: 1.2 }
    }
}

/// The index of a point in the tree of positions.
pub type Node = GeomWithData<[f64; 3], usize>;

/// A tree of positions for neighbour queries.
pub fn tree_of<'a>(positions: impl IntoIterator<Item = (usize, &'a Vec3)>) -> RTree<Node> {
    RTree::bulk_load(positions.into_iter().map(|(k, p)| Node::new([p.x, p.y, p.z], k)).collect())
}

/// Indices within `radius` of `p`, ascending.
pub fn within(tree: &RTree<Node>, p: &Vec3, radius: f64) -> Vec<usize> {
    let mut found: Vec<usize> = tree.locate_within_distance([p.x, p.y, p.z], radius * radius).map(|n| n.data).collect();
    found.sort_unstable();
    found
}

/// Sets that grow together.
#[derive(Debug, Clone)]
pub struct Union(Vec<usize>);

impl Union {
    /// `n` sets of one.
    pub fn new(n: usize) -> Self {
        Self((0..n).collect())
    }

    /// The representative of `k`'s set.
    pub fn find(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    /// Joins two sets; false when they were one.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        self.0[a.max(b)] = a.min(b);
        a != b
    }
}

/// Chains of indices into `points`, each in order along its curve, longest first; a point that links to
/// nobody makes no chain.
pub fn link(points: &[RidgePoint], spacing_mm: f64, params: &LinkParams) -> Vec<Vec<usize>> {
    let kept = thin(points, spacing_mm, params);
    let tree = tree_of(kept.iter().map(|&k| (k, &points[k].position_mm)));
    let straight = params.angle_deg.to_radians().cos();
    let mut links = Vec::new();
    for &p in &kept {
        for q in within(&tree, &points[p].position_mm, params.reach * spacing_mm) {
            if q <= p {
                continue;
            }
            let Some(cost) = cost(&points[p], &points[q], straight) else { continue };
            let way = points[q].position_mm - points[p].position_mm;
            let (at_p, at_q) = (points[p].tangent.dot(&way), points[q].tangent.dot(&way));
            // Side 0 lies along the tangent, side 1 against it.
            links.push((cost, p, usize::from(at_p < 0.0), q, usize::from(at_q > 0.0)));
        }
    }
    links.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.3).cmp(&(b.1, b.3))));
    let mut sides = vec![[usize::MAX; 2]; points.len()];
    let mut rings = Union::new(points.len());
    for (_, p, side_p, q, side_q) in links {
        if sides[p][side_p] == usize::MAX && sides[q][side_q] == usize::MAX && rings.join(p, q) {
            sides[p][side_p] = q;
            sides[q][side_q] = p;
        }
    }
    walk(&kept, &sides)
}

/// What a link costs, mm; none where it bends by more than the angle whose cosine is `straight`.
pub fn cost(p: &RidgePoint, q: &RidgePoint, straight: f64) -> Option<f64> {
    let way = q.position_mm - p.position_mm;
    let length = way.norm();
    if length < 1e-9 {
        return None;
    }
    let cosines = [p.tangent.dot(&way) / length, q.tangent.dot(&way) / length, p.tangent.dot(&q.tangent)].map(f64::abs);
    let bends = 3.0 - cosines.iter().sum::<f64>();
    cosines.iter().all(|&c| c >= straight).then_some(length * (1.0 + 8.0 * bends))
}

/// The points that stay after thinning, ascending.
fn thin(points: &[RidgePoint], spacing_mm: f64, params: &LinkParams) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[b].rootness.total_cmp(&points[a].rootness).then(a.cmp(&b)));
    let tree = tree_of(points.iter().map(|p| &p.position_mm).enumerate());
    let alike = (0.5 * params.angle_deg).to_radians().cos();
    let radius = params.same_along.hypot(params.same_across) * spacing_mm;
    let mut gone = vec![false; points.len()];
    for &p in &order {
        if gone[p] {
            continue;
        }
        for q in within(&tree, &points[p].position_mm, radius) {
            if q == p || gone[q] || points[p].tangent.dot(&points[q].tangent).abs() < alike {
                continue;
            }
            let way = points[q].position_mm - points[p].position_mm;
            let along = way.dot(&points[p].tangent).abs();
            let across = (way.norm_squared() - along * along).max(0.0).sqrt();
            gone[q] = along < params.same_along * spacing_mm && across < params.same_across * spacing_mm;
        }
    }
    (0..points.len()).filter(|&k| !gone[k]).collect()
}

/// Follows the links from every loose end; rings cannot occur.
fn walk(kept: &[usize], sides: &[[usize; 2]]) -> Vec<Vec<usize>> {
    let degree = |k: usize| sides[k].iter().filter(|&&s| s != usize::MAX).count();
    let mut seen = vec![false; sides.len()];
    let mut chains = Vec::new();
    for &start in kept {
        if degree(start) != 1 || seen[start] {
            continue;
        }
        let (mut chain, mut from, mut at) = (vec![start], usize::MAX, start);
        seen[start] = true;
        while let Some(&next) = sides[at].iter().find(|&&s| s != usize::MAX && s != from) {
            seen[next] = true;
            chain.push(next);
            (from, at) = (at, next);
        }
        chains.push(chain);
    }
    chains.sort_by(|a, b| b.len().cmp(&a.len()).then(a[0].cmp(&b[0])));
    chains
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(from: Vec3, to: Vec3, spacing: f64) -> Vec<RidgePoint> {
        let n = ((to - from).norm() / spacing) as usize;
        let tangent = (to - from).normalize();
        (0..=n)
            .map(|k| RidgePoint {
                position_mm: from + (to - from) * (k as f64 / n as f64),
                tangent: if k % 3 == 0 { -tangent } else { tangent },
                rootness: 1.0,
                sigma_mm: 1.0,
                strong: true,
            })
            .collect()
    }

    #[test]
    fn crossing_lines_stay_two() {
        let mut points = line(Vec3::new(-10.0, 0.0, 0.0), Vec3::new(10.0, 0.0, 0.0), 0.9);
        points.extend(line(Vec3::new(-10.0, -9.1, 0.1), Vec3::new(10.0, 8.9, 0.1), 0.9));
        let chains = link(&points, 1.0, &LinkParams::default());
        assert!(chains.len() >= 2);
        for chain in &chains[..2] {
            let (a, b) = (points[chain[0]].position_mm, points[*chain.last().unwrap()].position_mm);
            assert!((a - b).norm() > 19.0);
        }
    }

    #[test]
    fn a_lateral_ends_at_its_parent() {
        let mut points = line(Vec3::new(0.0, 0.0, -15.0), Vec3::new(0.0, 0.0, 15.0), 0.8);
        points.extend(line(Vec3::new(0.5, 0.0, 0.2), Vec3::new(12.0, 0.0, 5.0), 0.8));
        let chains = link(&points, 1.0, &LinkParams::default());
        let ends = |c: &Vec<usize>| [points[c[0]].position_mm.z, points[*c.last().unwrap()].position_mm.z];
        let parent = chains.iter().find(|c| ends(c).contains(&-15.0)).unwrap();
        assert!(ends(parent).contains(&15.0));
    }

    #[test]
    fn doubled_points_make_one_chain() {
        let mut points = line(Vec3::new(0.0, 0.0, 0.0), Vec3::new(20.0, 0.0, 0.0), 0.7);
        points.extend(line(Vec3::new(0.1, 0.6, 0.0), Vec3::new(20.1, 0.6, 0.0), 0.7).into_iter().map(|mut p| {
            p.rootness = 0.8;
            p
        }));
        let chains = link(&points, 1.0, &LinkParams::default());
        assert_eq!(chains.len(), 1);
        assert!((points[chains[0][0]].position_mm - points[*chains[0].last().unwrap()].position_mm).norm() > 19.0);
    }
}
