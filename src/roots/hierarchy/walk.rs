//! Follows the roots from the base through all junctions.

use super::attach::{Hang, free_base};
use super::base::upper;
use super::part::Part;
use super::{HierarchyParams, Line};
use crate::optics::Vec3;
use crate::roots::strand::End;
use crate::roots::trace::Pieces;
use std::collections::VecDeque;

/// A bend or a change of thickness counts at most as much as one of this many standard deviations.
const MOST: f64 = 4.0;
/// A way's thickness is that of its last so many windows: where roots part, widths are measured of both together or of
/// what shows between them.
const THICKNESS_WINDOWS: f64 = 4.0;
/// What the ridge itself says for the branch that it was traced into.
const SAME_PIECE: f64 = 0.5;

/// A root before it is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Grown {
    /// Its way.
    pub parts: Vec<Part>,
    /// Index of its parent in the list; parents stand first.
    pub parent: Option<usize>,
    /// Where it springs.
    pub place: Vec3,
    /// Whether the tie to the parent is visible.
    pub tied: bool,
    /// Branching order.
    pub order: u32,
}

/// The way from a point of a piece to one of its ends.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Branch {
    piece: usize,
    from: usize,
    towards: End,
}

impl Branch {
    /// Whether a point of the piece lies on it.
    fn leads_over(self, point: usize) -> bool {
        if self.towards == End::Last { point >= self.from } else { point <= self.from }
    }
}

/// A root that is still to be followed.
struct Seed {
    branch: Branch,
    parent: Option<usize>,
    place: Vec3,
    tied: bool,
    order: u32,
}

/// What hangs on a piece: (point there, hanging piece, its own point).
type Hanging = Vec<Vec<(usize, usize, usize)>>;

struct Walker<'a> {
    lines: &'a [Line<'a>],
    hanging: Hanging,
    params: &'a HierarchyParams,
    window_mm: f64,
    stub_mm: f64,
}

/// All roots, each after its parent.
pub fn walk(lines: &[Line<'_>], base: usize, hangs: &[Hang], pieces: &Pieces, params: &HierarchyParams) -> Vec<Grown> {
    let mut hanging: Hanging = vec![Vec::new(); lines.len()];
    for (piece, hang) in hangs.iter().enumerate() {
        if let Hang::On { parent, parent_point, point } = *hang {
            hanging[parent].push((parent_point, piece, point));
        }
    }
    hanging.iter_mut().for_each(|h| h.sort_unstable());
    let walker = Walker { lines, hanging, params, window_mm: pieces.smooth_mm, stub_mm: pieces.link_mm };
    let from_end = |piece: usize, end: End| Branch { piece, from: walker.end(piece, end), towards: end.other() };
    let start = from_end(base, upper(&lines[base]));
    let top = lines[base].at(start.from);
    let mut seeds = VecDeque::from([Seed { branch: start, parent: None, place: top, tied: false, order: 0 }]);
    for (piece, hang) in hangs.iter().enumerate() {
        let (end, parent) = match *hang {
            Hang::Crown(end) => (end, Some(0)),
            Hang::Free if piece != base => (free_base(&lines[piece]), None),
            _ => continue,
        };
        let branch = from_end(piece, end);
        seeds.push_back(Seed { branch, parent, place: lines[piece].at(branch.from), tied: false, order: 1 });
    }
    let mut roots: Vec<Grown> = Vec::new();
    let mut used = vec![false; lines.len()];
    while let Some(seed) = seeds.pop_front() {
        let (parts, laterals) = walker.follow(seed.branch, seed.order == 0, &mut used);
        let own = roots.len();
        seeds.extend(laterals.into_iter().map(|(branch, place)| Seed {
            branch,
            parent: Some(own),
            place,
            tied: true,
            order: seed.order + 1,
        }));
        roots.push(Grown { parts, parent: seed.parent, place: seed.place, tied: seed.tied, order: seed.order });
    }
    roots
}

/// The points of a way with their radii, mm.
pub fn places<'a>(lines: &[Line<'_>], parts: impl IntoIterator<Item = &'a Part>) -> Vec<(Vec3, f64)> {
    let of = |part: &'a Part| {
        let line = &lines[part.piece];
        part.points().map(|k| (line.at(k), line.radius_mm(k)))
    };
    parts.into_iter().flat_map(of).collect()
}

impl Walker<'_> {
    fn end(&self, piece: usize, end: End) -> usize {
        if end == End::First { 0 } else { self.lines[piece].last() }
    }

    /// What hangs on the branch and is not in use, nearest first.
    fn next_on(&self, b: Branch, used: &[bool]) -> Vec<(usize, usize, usize)> {
        let mut found: Vec<_> =
            self.hanging[b.piece].iter().filter(|h| b.leads_over(h.0) && !used[h.1]).copied().collect();
        if b.towards == End::First {
            found.reverse();
        }
        found
    }

    /// The branches of a piece from a point on; stubs no longer than a link are none.
    fn branches(&self, piece: usize, from: usize) -> Vec<Branch> {
        let arc = &self.lines[piece].arc_mm;
        let mut both: Vec<Branch> = End::BOTH.into_iter().map(|towards| Branch { piece, from, towards }).collect();
        let left = |b: &Branch| (arc[self.end(piece, b.towards)] - arc[from]).abs();
        both.retain(|b| left(b) > self.stub_mm || left(b) >= 0.5 * self.lines[piece].length_mm());
        both
    }

    /// The way of one root, and what springs from it with the places.
    fn follow(&self, start: Branch, is_base: bool, used: &mut [bool]) -> (Vec<Part>, Vec<(Branch, Vec3)>) {
        let (mut parts, mut laterals) = (Vec::new(), Vec::new());
        let (mut at, mut entered) = (start, start.from);
        used[start.piece] = true;
        loop {
            let hanging = self.next_on(at, used);
            let line = &self.lines[at.piece];
            let Some(&(knot, ..)) = hanging.first() else {
                parts.push(Part { piece: at.piece, from: entered, to: self.end(at.piece, at.towards) });
                return (parts, laterals);
            };
            // What springs within a radius springs from one place, and so does what hangs on it there: where several
            // ridges meet, which one touches which is chance. A stub at the piece's end is no way of its own, so what hangs
            // on it springs here too.
            let width = line.radius_mm(knot).max(0.5 * self.stub_mm);
            let end = self.end(at.piece, at.towards);
            let goes_on = |from: usize| (line.arc_mm[end] - line.arc_mm[from]).abs() > self.stub_mm;
            let mut count = hanging.partition_point(|h| (line.arc_mm[h.0] - line.arc_mm[knot]).abs() <= width);
            if !goes_on(hanging[count - 1].0) {
                count = hanging.len();
            }
            let near = &hanging[..count];
            let far = near[count - 1].0;
            near.iter().for_each(|h| used[h.1] = true);
            let mut here: Vec<(Vec3, usize, usize)> = near.iter().map(|h| (line.at(h.0), h.1, h.2)).collect();
            let mut n = 0;
            while let Some(&(_, piece, point)) = here.get(n) {
                let child = &self.lines[piece];
                let ways = self.branches(piece, point);
                let close = |h: &&(usize, usize, usize)| {
                    let on_stub = !ways.iter().any(|way| way.leads_over(h.0));
                    let beside = n < count && (child.arc_mm[h.0] - child.arc_mm[point]).abs() <= width + self.stub_mm;
                    !used[h.1] && (beside || on_stub)
                };
                let found: Vec<_> =
                    self.hanging[piece].iter().filter(close).map(|h| (child.at(h.0), h.1, h.2)).collect();
                found.iter().for_each(|h| used[h.1] = true);
                here.extend(found);
                n += 1;
            }
            let mut ways: Vec<(Branch, Vec3)> =
                here.iter().flat_map(|h| self.branches(h.1, h.2).into_iter().map(|b| (b, h.0))).collect();
            let own = Branch { from: far, ..at };
            if goes_on(far) {
                ways.push((own, line.at(far)));
            }
            let incoming = self.incoming(&parts, Part { piece: at.piece, from: entered, to: knot });
            let score = |b: &Branch| {
                self.score(&incoming, b, is_base, used) + if b.piece == at.piece { SAME_PIECE } else { 0.0 }
            };
            let scores: Vec<f64> = ways.iter().map(|(b, _)| score(b)).collect();
            let best = (0..ways.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(b.cmp(&a)));
            let Some(best) = best else {
                // Only stubs hang here: the way ends with the piece.
                parts.push(Part { piece: at.piece, from: entered, to: end });
                return (parts, laterals);
            };
            let (next, _) = ways.swap_remove(best);
            laterals.extend(ways);
            if next.piece != at.piece {
                parts.push(Part { piece: at.piece, from: entered, to: knot });
                entered = next.from;
            }
            at = next;
        }
    }

    /// Direction over the last stretch of a way (none where it is too short to tell), and radius over a longer one.
    fn incoming(&self, parts: &[Part], last: Part) -> (Option<Vec3>, f64) {
        let points = places(self.lines, parts.iter().chain([&last]));
        let (end, radius) = points[points.len() - 1];
        let (mut way, mut before) = (0.0, end);
        let (mut stretch, mut radii): (Vec<Vec3>, Vec<f64>) = (Vec::new(), Vec::new());
        for &(p, r) in points.iter().rev() {
            way += (p - before).norm();
            before = p;
            if way >= radius && way <= radius + self.window_mm {
                stretch.push(p);
            }
            if way >= radius {
                radii.push(r);
            }
            if way >= radius + THICKNESS_WINDOWS * self.window_mm {
                break;
            }
        }
        radii.sort_by(f64::total_cmp);
        let typical = radii.get(radii.len() / 2).copied().unwrap_or(radius);
        let chord = match (stretch.first(), stretch.last()) {
            (Some(a), Some(b)) if (a - b).norm() > 0.3 * self.window_mm => (a - b).try_normalize(1e-9),
            _ => None,
        };
        (chord, typical)
    }

    /// How well a branch goes on.
    fn score(&self, (direction, radius): &(Option<Vec3>, f64), b: &Branch, is_base: bool, used: &[bool]) -> f64 {
        let line = &self.lines[b.piece];
        let from = line.beyond(b.from, b.towards, *radius);
        let to = line.beyond(from, b.towards, self.window_mm);
        let leaves = (line.at(to) - line.at(from)).try_normalize(1e-9);
        let bend = match (direction, leaves) {
            (Some(a), Some(c)) => a.dot(&c).clamp(-1.0, 1.0).acos().to_degrees() / self.params.bend_deg,
            _ => 0.0,
        };
        let far = line.beyond(from, b.towards, 2.0 * self.window_mm);
        let ratio = (line.typical_radius_mm(from, far) / radius).ln() / self.params.thinner;
        let down = leaves.filter(|_| is_base).map_or(0.0, |c| c.z.clamp(-1.0, 1.0).acos().to_degrees());
        let limited = |z: f64| if z.is_finite() { -0.5 * z.abs().min(MOST).powi(2) } else { -0.5 * MOST * MOST };
        limited(bend) + limited(ratio) + limited(down / self.params.down_deg) + 0.5 * self.reach(*b, used).max(1.0).ln()
    }

    /// Longest way from the branch's start to a tip, mm.
    fn reach(&self, b: Branch, used: &[bool]) -> f64 {
        let arc = &self.lines[b.piece].arc_mm;
        let mut longest = (arc[self.end(b.piece, b.towards)] - arc[b.from]).abs();
        for (knot, piece, from) in self.next_on(b, used) {
            let to_there = (arc[knot] - arc[b.from]).abs();
            for branch in self.branches(piece, from) {
                longest = longest.max(to_there + self.reach(branch, used));
            }
        }
        longest
    }
}
