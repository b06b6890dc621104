//! The roots as a tree that can be cut, joined and hung otherwise.

use super::Done;
use crate::optics::Vec3;
use crate::roots::strand::End;
use crate::roots::{TracedRoot, curve};

/// A root is led from its new parent's line over a gap of this at most, mm; over a wider one it hangs without a tie.
const LEAD_MM: f64 = 5.0;
/// Spacing of new points where the roots do not tell one, mm.
const STEP_MM: f64 = 0.5;

/// The roots while they are corrected.
#[derive(Debug, Clone)]
pub struct Tree {
    /// The roots; a parent may stand behind its laterals.
    pub roots: Vec<TracedRoot>,
    next_id: i64,
    /// Spacing of new points, mm.
    pub step_mm: f64,
}

impl Tree {
    /// The tree of these roots.
    pub fn new(roots: Vec<TracedRoot>) -> Self {
        let mut steps: Vec<f64> = roots
            .iter()
            .flat_map(|r| r.root.points_mm.windows(2))
            .map(|pair| (Vec3::from(pair[1]) - Vec3::from(pair[0])).norm())
            .collect();
        steps.sort_by(f64::total_cmp);
        let step_mm = steps.get(steps.len() / 2).copied().filter(|s| *s > 1e-3).unwrap_or(STEP_MM);
        let next_id = roots.iter().map(|r| r.root.id + 1).max().unwrap_or(0);
        Self { roots, next_id, step_mm }
    }

    /// The roots, parents first, otherwise in their order.
    pub fn finish(self) -> Vec<TracedRoot> {
        let (mut left, mut done) = (self.roots, Vec::<TracedRoot>::new());
        while !left.is_empty() {
            let before = done.len();
            let mut waiting = Vec::new();
            for r in left {
                let is_ready = r.root.parent < 0 || done.iter().any(|d| d.root.id == r.root.parent);
                if is_ready { done.push(r) } else { waiting.push(r) }
            }
            left = waiting;
            // Nobody hangs on himself: each pass places one at least.
            debug_assert!(done.len() > before);
        }
        done
    }

    /// A number that no root has.
    pub fn fresh_id(&mut self) -> i64 {
        self.next_id += 1;
        self.next_id - 1
    }

    /// Length of a root, mm.
    pub fn length_mm(&self, root: usize) -> f64 {
        curve::chord_lengths(&self.roots[root].root.points_mm).last().copied().unwrap_or(0.0)
    }

    /// Place in the list of a root's number.
    pub fn index(&self, id: i64) -> Option<usize> {
        self.roots.iter().position(|r| r.root.id == id)
    }

    /// Whether a root springs from another, over any number of orders, or is it.
    pub fn descends(&self, root: usize, from: usize) -> bool {
        let mut at = Some(root);
        for _ in 0..=self.roots.len() {
            match at {
                Some(n) if n == from => return true,
                Some(n) => at = self.index(self.roots[n].root.parent),
                None => return false,
            }
        }
        true
    }

    /// Takes a root out with all that springs from it; how many went.
    pub fn remove(&mut self, root: usize) -> usize {
        let gone: Vec<bool> = (0..self.roots.len()).map(|n| self.descends(n, root)).collect();
        let mut n = 0;
        self.roots.retain(|_| {
            n += 1;
            !gone[n - 1]
        });
        gone.iter().filter(|g| **g).count()
    }

    /// Cuts a root at a point: the far part becomes a root of the same order without a parent and takes along what springs from it.
    /// Its place in the list; none where nothing lies beyond the point, or before it.
    pub fn split(&mut self, root: usize, point: usize) -> Option<usize> {
        let last = self.roots[root].root.points_mm.len() - 1;
        if point == 0 || point >= last {
            return None;
        }
        let id = self.fresh_id();
        let near = &mut self.roots[root];
        let mut far = near.clone();
        let old = near.root.points_mm.clone();
        keep(near, 0, point);
        keep(&mut far, point, last);
        far.root.id = id;
        far.root.parent = -1;
        let from = near.root.id;
        self.roots.push(far);
        for lateral in self.roots.iter_mut().filter(|r| r.root.parent == from) {
            let first = Vec3::from(lateral.root.points_mm[0]);
            if super::nearest::nearest(&old, &first).0 > point {
                lateral.root.parent = id;
            }
        }
        Some(self.roots.len() - 1)
    }

    /// Cuts a root behind a point, so that the two new ends are a step apart; whether there was something to cut.
    pub fn cut(&mut self, root: usize, point: usize) -> bool {
        let last = self.roots[root].root.points_mm.len() - 1;
        if point + 2 > last {
            return false;
        }
        let Some(far) = self.split(root, point) else { return false };
        let last = self.roots[far].root.points_mm.len() - 1;
        keep(&mut self.roots[far], 1, last);
        true
    }

    /// Turns a root round: its tip becomes its base.
    pub fn reverse(&mut self, root: usize) {
        let r = &mut self.roots[root];
        r.root.points_mm.reverse();
        r.root.radii_mm.reverse();
        r.radius_sd_mm.reverse();
        r.views.reverse();
        r.confidence.reverse();
    }

    /// Gives a root an order; what springs from it follows.
    pub fn set_order(&mut self, root: usize, order: u32) {
        let by = i64::from(order) - i64::from(self.roots[root].root.order);
        let moved: Vec<usize> = (0..self.roots.len()).filter(|&n| self.descends(n, root)).collect();
        for n in moved {
            let own = &mut self.roots[n].root.order;
            *own = u32::try_from(i64::from(*own) + by).unwrap_or(0);
        }
    }

    /// Hangs a root on another with the end that is nearer to `place`; it is led from there.
    ///
    /// # Errors
    /// Where the new parent springs from the root itself.
    pub fn adopt(&mut self, child: usize, parent: usize, place: &Vec3) -> std::result::Result<(), String> {
        if self.descends(parent, child) {
            return Err("the new parent is the root itself, or springs from it".into());
        }
        let distance = |p: &[f64; 3]| (Vec3::from(*p) - place).norm();
        let points = &self.roots[child].root.points_mm;
        if distance(&points[points.len() - 1]) < distance(&points[0]) {
            self.reverse(child);
        } else if let Some(old) = self.index(self.roots[child].root.parent) {
            self.leave(child, old);
        }
        let order = self.roots[parent].root.order + 1;
        self.roots[child].root.parent = self.roots[parent].root.id;
        self.set_order(child, order);
        let line = &self.roots[parent].root;
        let start = super::nearest::nearest(&line.points_mm, place).0;
        let (from, radius_mm) = (line.points_mm[start], line.radii_mm[start]);
        self.trim(child, &Vec3::from(from), radius_mm);
        let gap = self.bridge(&self.joint(child, End::First), from);
        if let Some(mut gap) = gap.filter(|gap| gap.mm <= LEAD_MM) {
            gap.points.reverse();
            gap.points.insert(0, from);
            self.prepend(child, &gap.points);
        }
        Ok(())
    }

    /// Takes from a root's start what lies within its parent.
    fn leave(&mut self, child: usize, parent: usize) {
        let first = Vec3::from(self.roots[child].root.points_mm[0]);
        let line = &self.roots[parent].root;
        let (k, _) = super::nearest::nearest(&line.points_mm, &first);
        let (at, radius_mm) = (Vec3::from(line.points_mm[k]), line.radii_mm[k]);
        self.trim(child, &at, radius_mm);
    }

    /// Takes from a root's start what lies within a ball; two points stay.
    fn trim(&mut self, root: usize, centre: &Vec3, radius_mm: f64) {
        let points = &self.roots[root].root.points_mm;
        let inside = points.iter().take_while(|p| (Vec3::from(**p) - centre).norm() < radius_mm).count();
        let (from, last) = (inside.min(points.len().saturating_sub(2)), points.len() - 1);
        keep(&mut self.roots[root], from, last);
    }

    fn joint(&self, root: usize, end: End) -> [f64; 3] {
        let points = &self.roots[root].root.points_mm;
        if end == End::First { points[0] } else { points[points.len() - 1] }
    }

    /// Points between two, both left out; none where they are one.
    fn bridge(&self, from: &[f64; 3], to: [f64; 3]) -> Option<Gap> {
        let (a, b) = (Vec3::from(*from), Vec3::from(to));
        let mm = (b - a).norm();
        let n = (mm / self.step_mm).round() as usize;
        let points = (1..n).map(|k| <[f64; 3]>::from(a + (b - a) * (k as f64 / n as f64))).collect();
        (mm > 1e-9).then_some(Gap { points, mm })
    }

    /// Puts points before a root's first one, as thick as it is there; no photograph shows them.
    fn prepend(&mut self, root: usize, points: &[[f64; 3]]) {
        let r = &mut self.roots[root];
        let n = points.len();
        r.root.points_mm.splice(0..0, points.iter().copied());
        r.root.radii_mm.splice(0..0, vec![r.root.radii_mm[0]; n]);
        r.radius_sd_mm.splice(0..0, vec![r.radius_sd_mm[0]; n]);
        r.views.splice(0..0, vec![0; n]);
        r.confidence.splice(0..0, vec![0.0; n]);
    }

    /// Takes out the stretch of one root between two places.
    pub fn stretch(&mut self, from: &Vec3, to: &Vec3, within_mm: f64) -> Done {
        let (a, b) = (self.on(from, within_mm)?, self.on(to, within_mm)?);
        let found = self.told(&a);
        if a.root != b.root {
            return Err((Some(*from), format!("the places lie on two roots: {found}; {}", self.told(&b))));
        }
        let last = self.roots[a.root].root.points_mm.len() - 1;
        let (low, high) = (a.point.min(b.point), a.point.max(b.point));
        if low == high || (low == 0 && high == last) {
            let why =
                if low == high { "nothing lies between the places" } else { "that is the whole root; use remove" };
            return Err((Some(*from), format!("{found}: {why}")));
        }
        let beyond = self.split(a.root, high);
        let gone = if low == 0 { Some(a.root) } else { self.split(a.root, low) };
        if low == 0
            && let Some(beyond) = beyond
        {
            // The rest keeps the root's number, so that only what went is gone.
            let (old, new) = (self.roots[a.root].root.id, self.roots[beyond].root.id);
            self.swap_ids(old, new);
        }
        let Some(gone) = gone else { return Ok((*from, found)) };
        let (id, mm) = (self.roots[gone].root.id, self.length_mm(gone));
        self.roots.iter_mut().filter(|r| r.root.parent == id).for_each(|r| r.root.parent = -1);
        self.roots.remove(gone);
        Ok((*from, format!("{found}; {mm:.1} mm of it taken out")))
    }

    /// Two roots change their numbers.
    fn swap_ids(&mut self, a: i64, b: i64) {
        let swap = |id: &mut i64| {
            *id = if *id == a {
                b
            } else if *id == b {
                a
            } else {
                *id
            }
        };
        for r in &mut self.roots {
            swap(&mut r.root.id);
            swap(&mut r.root.parent);
        }
    }

    /// Joins the ends of two roots to one root; it starts with the one that is joined at its tip and keeps its order. The order of a
    /// start without a parent is a guess: there the lower one counts.
    pub fn join(&mut self, from: &Vec3, to: &Vec3, within_mm: f64) -> Done {
        let ((a, end_a), (b, end_b)) = (self.end_at(from, within_mm)?, self.end_at(to, within_mm)?);
        let found = format!("{}; {}", self.told(&a), self.told(&b));
        if a.root == b.root {
            return Err((Some(*from), format!("both are ends of one {}", self.told(&a))));
        }
        let (head, head_end, tail, tail_end) = match (end_a, end_b) {
            (End::First, End::Last) => (b.root, end_b, a.root, end_a),
            _ => (a.root, end_a, b.root, end_b),
        };
        if self.descends(head, tail) {
            return Err((Some(*from), format!("{found}: the one springs from the other's far side")));
        }
        if head_end == End::First {
            self.reverse(head);
            self.roots[head].root.parent = -1;
        }
        if tail_end == End::Last {
            self.reverse(tail);
        } else if self.roots[tail].root.parent == self.roots[head].root.id {
            // It was led here through the other's tip.
            self.leave(tail, head);
        }
        let (first, second) = (&self.roots[head].root, &self.roots[tail].root);
        let order = if first.parent < 0 { first.order.min(second.order) } else { first.order };
        self.set_order(head, order);
        self.set_order(tail, order);
        let gap = self.bridge(&self.joint(head, End::Last), self.joint(tail, End::First));
        if let Some(gap) = &gap {
            self.prepend(tail, &gap.points);
        }
        let skip = usize::from(gap.is_none());
        let (id, head_id) = (self.roots[tail].root.id, self.roots[head].root.id);
        let far = self.roots[tail].clone();
        let near = &mut self.roots[head];
        near.root.points_mm.extend(&far.root.points_mm[skip..]);
        near.root.radii_mm.extend(&far.root.radii_mm[skip..]);
        near.radius_sd_mm.extend(&far.radius_sd_mm[skip..]);
        near.views.extend(&far.views[skip..]);
        near.confidence.extend(&far.confidence[skip..]);
        self.roots.iter_mut().filter(|r| r.root.parent == id).for_each(|r| r.root.parent = head_id);
        self.roots.remove(tail);
        Ok((*from, format!("{found}; {:.1} mm between them closed", gap.map_or(0.0, |gap| gap.mm))))
    }
}

/// New points between two old ones.
struct Gap {
    points: Vec<[f64; 3]>,
    mm: f64,
}

/// Keeps the points of a range, both ends included.
fn keep(r: &mut TracedRoot, from: usize, to: usize) {
    fn part<T: Copy>(list: &mut Vec<T>, from: usize, to: usize) {
        *list = list[from..=to].to_vec();
    }
    part(&mut r.root.points_mm, from, to);
    part(&mut r.root.radii_mm, from, to);
    part(&mut r.radius_sd_mm, from, to);
    part(&mut r.views, from, to);
    part(&mut r.confidence, from, to);
}
