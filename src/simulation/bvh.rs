//! Roots as tapered tubes, and where a ray first meets them.
//!
//! A root is a chain of segments; a segment's surface is the set of points at distance r(s) from its axis,
//! r linear from end to end, with round ends. The radius is taken where ray and axis come nearest: exact
//! for a tube of constant radius, and wrong by the taper squared otherwise (under 1e-5 of the radius for
//! real roots). Segments lie in a tree of boxes, split at the median of the longest side; ties keep the
//! order of the roots, so the tree is the same on every machine.

use crate::optics::Vec3;
use crate::roots::Root;

/// Segments per leaf of the tree.
const LEAF: usize = 4;
/// A chain of segments within this of a straight one is made one, mm: a hundredth of a pixel of a usual capture.
const STRAIGHT_MM: f64 = 0.005;

/// One segment of a root.
#[derive(Debug, Clone, Copy)]
struct Tube {
    from: Vec3,
    along: Vec3,
    radius: [f64; 2],
    root: u32,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    low: [f64; 3],
    high: [f64; 3],
    /// Leaf: first tube. Branch: index of the far child; the near one follows the node.
    start: u32,
    /// Leaf: number of tubes. Branch: 0.
    count: u32,
    /// Branch: side by which the children were split.
    axis: u32,
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Distance along the unit direction, mm.
    pub t_mm: f64,
    /// Outward unit normal.
    pub normal: Vec3,
    /// Position of the root in the list.
    pub root: usize,
}

/// All segments of a root system, ready for rays.
#[derive(Debug, Clone)]
pub struct Tubes {
    nodes: Vec<Node>,
    tubes: Vec<Tube>,
}

impl Tubes {
    /// Builds the tree.
    pub fn new(roots: &[Root]) -> Self {
        let mut tubes = Vec::new();
        for (k, root) in roots.iter().enumerate() {
            let mut start = 0;
            while start + 1 < root.points_mm.len() {
                let end = straight_to(root, start);
                let from = Vec3::from(root.points_mm[start]);
                let along = Vec3::from(root.points_mm[end]) - from;
                if along.norm_squared() > 0.0 {
                    let radius = [root.radii_mm[start], root.radii_mm[end]];
                    tubes.push(Tube { from, along, radius, root: k as u32 });
                }
                start = end;
            }
        }
        let mut nodes = Vec::new();
        if !tubes.is_empty() {
            let count = tubes.len();
            build(&mut nodes, &mut tubes, 0, count);
        }
        Self { nodes, tubes }
    }

    /// The first surface within `limit_mm`; `near` is set where the ray meets a surface or passes one within
    /// `reach_mm` on its way there.
    pub fn first_hit(
        &self,
        origin: &Vec3,
        direction: &Vec3,
        limit_mm: f64,
        reach_mm: f64,
        near: &mut bool,
    ) -> Option<Hit> {
        if self.nodes.is_empty() {
            return None;
        }
        let slopes = [1.0 / direction.x, 1.0 / direction.y, 1.0 / direction.z];
        let mut best = limit_mm;
        let mut hit = None;
        let mut stack = [0u32; 64];
        let mut top = 1;
        while top > 0 {
            top -= 1;
            let index = stack[top];
            let node = &self.nodes[index as usize];
            if !meets(node, origin, &slopes, best, reach_mm) {
                continue;
            }
            if node.count > 0 {
                for tube in &self.tubes[node.start as usize..(node.start + node.count) as usize] {
                    if let Some((t, normal)) = tube.hit(origin, direction, reach_mm, best, near) {
                        best = t;
                        hit = Some(Hit { t_mm: t, normal, root: tube.root as usize });
                    }
                }
            } else {
                let (near_child, far_child) = (index + 1, node.start);
                let forward = direction[node.axis as usize] >= 0.0;
                let (first, second) = if forward { (near_child, far_child) } else { (far_child, near_child) };
                stack[top] = second;
                stack[top + 1] = first;
                top += 2;
            }
        }
        hit
    }
}

/// Slab test of a node's box, widened by `reach`, against the ray up to `limit`.
#[inline]
fn meets(node: &Node, origin: &Vec3, slopes: &[f64; 3], limit: f64, reach: f64) -> bool {
    // Plain comparisons: the NaN of a ray within a slab's plane falls through to "meets".
    let (mut enter, mut leave) = (0.0f64, limit);
    for k in 0..3 {
        let a = (node.low[k] - reach - origin[k]) * slopes[k];
        let b = (node.high[k] + reach - origin[k]) * slopes[k];
        let (first, last) = if a < b { (a, b) } else { (b, a) };
        if first > enter {
            enter = first;
        }
        if last < leave {
            leave = last;
        }
    }
    enter <= leave
}

/// Last point up to which the root is straight from point `start` on: within [`STRAIGHT_MM`] of the chord, the radius
/// too.
fn straight_to(root: &Root, start: usize) -> usize {
    let from = Vec3::from(root.points_mm[start]);
    let mut end = start + 1;
    while end + 1 < root.points_mm.len() && end - start < 8 {
        let along = Vec3::from(root.points_mm[end + 1]) - from;
        let squared = along.norm_squared();
        let straight = squared > 0.0
            && (start + 1..=end).all(|i| {
                let w = Vec3::from(root.points_mm[i]) - from;
                let s = w.dot(&along) / squared;
                let r = root.radii_mm[start] + (root.radii_mm[end + 1] - root.radii_mm[start]) * s;
                (0.0..=1.0).contains(&s)
                    && (w - along * s).norm() <= STRAIGHT_MM
                    && (r - root.radii_mm[i]).abs() <= STRAIGHT_MM
            });
        if !straight {
            break;
        }
        end += 1;
    }
    end
}

fn build(nodes: &mut Vec<Node>, tubes: &mut [Tube], start: usize, count: usize) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    let (mut low_middle, mut high_middle) = (low, high);
    for tube in tubes.iter() {
        let margin = tube.radius[0].max(tube.radius[1]);
        let to = tube.from + tube.along;
        for k in 0..3 {
            low[k] = low[k].min(tube.from[k].min(to[k]) - margin);
            high[k] = high[k].max(tube.from[k].max(to[k]) + margin);
            let middle = tube.middle(k);
            low_middle[k] = low_middle[k].min(middle);
            high_middle[k] = high_middle[k].max(middle);
        }
    }
    let axis =
        (0..3).fold(
            0,
            |best, k| {
                if high_middle[k] - low_middle[k] > high_middle[best] - low_middle[best] { k } else { best }
            },
        );
    let here = nodes.len();
    nodes.push(Node { low, high, start: start as u32, count: count as u32, axis: axis as u32 });
    if count <= LEAF {
        return;
    }
    tubes.sort_by(|a, b| a.middle(axis).total_cmp(&b.middle(axis)));
    let half = count / 2;
    let (left, right) = tubes.split_at_mut(half);
    build(nodes, left, start, half);
    nodes[here].start = nodes.len() as u32;
    nodes[here].count = 0;
    build(nodes, right, start + half, count - half);
}

impl Tube {
    fn middle(&self, k: usize) -> f64 {
        self.from[k] + 0.5 * self.along[k]
    }

    /// Distance and outward normal where the ray first meets the tube in (0, limit).
    #[inline]
    fn hit(&self, o: &Vec3, d: &Vec3, reach: f64, limit: f64, near: &mut bool) -> Option<(f64, Vec3)> {
        let w = o - self.from;
        let (ee, ed, we, wd) = (self.along.norm_squared(), self.along.dot(d), w.dot(&self.along), w.dot(d));
        // Where on the axis (0..1) the ray comes nearest.
        let across = ee - ed * ed;
        let s = if across > 1e-12 * ee { ((we - wd * ed) / across).clamp(0.0, 1.0) } else { 0.0 };
        let nearest = w - self.along * s;
        let t = -nearest.dot(d);
        let miss_squared = nearest.norm_squared() - t * t;
        let r = self.radius[0] + (self.radius[1] - self.radius[0]) * s;
        if miss_squared > (r + reach) * (r + reach) {
            return None;
        }
        if t > 0.0 && t < limit {
            *near = true;
        }
        if miss_squared > r * r {
            return None;
        }
        // The side of the tube, else the round end towards which the ray leaves the side.
        let a = across / ee;
        let b = wd - we * ed / ee;
        let c = w.norm_squared() - we * we / ee - r * r;
        let (mut t_hit, mut on_axis) = (f64::NAN, 0.0);
        if a > 1e-12 {
            let disc = b * b - a * c;
            if disc < 0.0 {
                return None;
            }
            t_hit = (-b - disc.sqrt()) / a;
            on_axis = (we + t_hit * ed) / ee;
        } else if ed < 0.0 {
            on_axis = 1.0;
        }
        if !(0.0..=1.0).contains(&on_axis) || t_hit.is_nan() {
            on_axis = if on_axis > 0.5 { 1.0 } else { 0.0 };
            let v = w - self.along * on_axis;
            let half = v.dot(d);
            let disc = half * half - v.norm_squared() + r * r;
            if disc < 0.0 {
                return None;
            }
            t_hit = -half - disc.sqrt();
        }
        if !(t_hit > 0.0 && t_hit < limit) {
            return None;
        }
        let normal = (o + d * t_hit - (self.from + self.along * on_axis)) / r;
        Some((t_hit, normal.normalize()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::noise;

    fn random_roots(count: usize) -> Vec<Root> {
        let value = |i: u64, j: u64| noise::uniform(noise::hash(11, &[i, j])) * 2.0 - 1.0;
        (0..count as u64)
            .map(|i| {
                let mut p = [20.0 * value(i, 0), 20.0 * value(i, 1), 20.0 * value(i, 2)];
                let points_mm: Vec<[f64; 3]> = (0..12)
                    .map(|j| {
                        for (k, x) in p.iter_mut().enumerate() {
                            *x += value(i, 10 + 3 * j + k as u64);
                        }
                        p
                    })
                    .collect();
                let radii_mm = (0..12).map(|j| 0.8 - 0.05 * f64::from(j)).collect();
                Root { id: i as i64, parent: -1, order: 0, points_mm, radii_mm }
            })
            .collect()
    }

    #[test]
    fn the_tree_finds_what_a_search_of_all_segments_finds() {
        let tubes = Tubes::new(&random_roots(60));
        let mut hits = 0;
        for i in 0..3000u64 {
            let value = |j: u64| noise::uniform(noise::hash(5, &[i, j])) * 2.0 - 1.0;
            let origin = Vec3::new(40.0 * value(0), 40.0 * value(1), 40.0 * value(2));
            let aim = Vec3::new(15.0 * value(3), 15.0 * value(4), 15.0 * value(5));
            let direction = (aim - origin).normalize();
            let (mut near, mut near_slow) = (false, false);
            let fast = tubes.first_hit(&origin, &direction, 100.0, 0.3, &mut near);
            let mut best = 100.0;
            let mut slow = None;
            for tube in &tubes.tubes {
                if let Some((t, _)) = tube.hit(&origin, &direction, 0.3, best, &mut near_slow) {
                    best = t;
                    slow = Some((t, tube.root as usize));
                }
            }
            assert_eq!(fast.map(|h| (h.t_mm, h.root)), slow);
            if slow.is_none() {
                assert_eq!(near, near_slow);
            }
            hits += usize::from(slow.is_some());
        }
        assert!(hits > 300, "{hits}");
    }

    #[test]
    fn a_hit_lies_on_the_surface() {
        let root = Root {
            id: 0,
            parent: -1,
            order: 0,
            points_mm: vec![[0.0, 0.0, 0.0], [0.0, 0.0, 10.0]],
            radii_mm: vec![1.0, 1.0],
        };
        let tubes = Tubes::new(&[root]);
        let mut near = false;
        let side = tubes.first_hit(&Vec3::new(5.0, 0.5, 4.0), &-Vec3::x(), 100.0, 0.1, &mut near).unwrap();
        assert!((side.t_mm - (5.0 - 0.75f64.sqrt())).abs() < 1e-12 && near);
        let end = tubes.first_hit(&Vec3::new(0.0, 0.0, -5.0), &Vec3::z(), 100.0, 0.1, &mut near).unwrap();
        assert!((end.t_mm - 4.0).abs() < 1e-12 && (end.normal + Vec3::z()).norm() < 1e-12);
        let mut near = false;
        assert!(tubes.first_hit(&Vec3::new(5.0, 1.05, 4.0), &-Vec3::x(), 100.0, 0.1, &mut near).is_none() && near);
        let mut near = false;
        assert!(tubes.first_hit(&Vec3::new(5.0, 1.2, 4.0), &-Vec3::x(), 100.0, 0.1, &mut near).is_none() && !near);
    }
}
