//! Where strands touch each other, and the segments between these places.

use crate::roots::bridge::Workshop;
use crate::roots::curve;
use crate::roots::link::{Node, Union, within};
use crate::roots::strand::{End, Strand, knot_tree};
use rstar::RTree;
use std::collections::BTreeMap;

/// A segment and its end.
pub type SegmentEnd = (usize, End);
/// A segment's end at a crossing, and how far from it the segment touches others, mm.
pub type Meeting = (SegmentEnd, f64);
/// Per segment and end what it goes on in.
pub type Links = Vec<[Option<SegmentEnd>; 2]>;

/// The knots of all strands, for neighbour queries.
struct Touches<'a> {
    strands: &'a [Strand],
    arcs: Vec<Vec<f64>>,
    places: Vec<(usize, usize)>,
    tree: RTree<Node>,
    link_mm: f64,
}

/// Knots of one strand at a crossing.
type Stretch = (usize, std::ops::RangeInclusive<usize>);

impl<'a> Touches<'a> {
    fn new(strands: &'a [Strand], link_mm: f64) -> Self {
        let (places, tree) = knot_tree(strands);
        let arcs = strands.iter().map(|s| curve::chord_lengths(&s.knots)).collect();
        Self { strands, arcs, places, tree, link_mm }
    }

    /// Touching knots no farther apart along a strand belong to one stretch, mm.
    fn apart(&self) -> f64 {
        2.0 * self.link_mm
    }

    /// Per crossing the stretches of strands that touch there.
    fn crossings(&self) -> Vec<Vec<Stretch>> {
        let reach = 1.5 * self.link_mm;
        let touching: Vec<Vec<usize>> = self
            .places
            .iter()
            .map(|&(s, k)| {
                let p = self.strands[s].at(k);
                let near = within(&self.tree, &p, reach).into_iter().filter(|&n| {
                    let (other, knot) = self.places[n];
                    let radius = self.strands[s].radius_mm(k).max(self.strands[other].radius_mm(knot));
                    let touch = self.link_mm + radius.min(0.5 * self.link_mm);
                    other != s && (self.strands[other].at(knot) - p).norm() <= touch
                });
                near.collect()
            })
            .collect();
        let mut groups = Union::new(self.places.len());
        let mut last: Option<usize> = None;
        for (n, near) in touching.iter().enumerate().filter(|(_, near)| !near.is_empty()) {
            near.iter().for_each(|&m| _ = groups.join(n, m));
            let (s, k) = self.places[n];
            let way = |b: usize| self.arcs[s][k] - self.arcs[s][self.places[b].1];
            if let Some(before) = last.filter(|&b| self.places[b].0 == s && way(b) <= self.apart()) {
                groups.join(n, before);
            }
            last = Some(n);
        }
        let mut crossings: BTreeMap<usize, Vec<Stretch>> = BTreeMap::new();
        for n in (0..self.places.len()).filter(|&n| !touching[n].is_empty()) {
            let (s, k) = self.places[n];
            let stretches = crossings.entry(groups.find(n)).or_default();
            // A strand that comes by twice has two stretches.
            match stretches.last_mut() {
                Some((last, knots)) if *last == s && self.arcs[s][k] - self.arcs[s][*knots.end()] <= self.apart() => {
                    *knots = *knots.start()..=k;
                }
                _ => stretches.push((s, k..=k)),
            }
        }
        crossings.into_values().collect()
    }
}

/// Strands cut at crossings.
pub struct Cut {
    /// The pieces between crossings.
    pub segments: Vec<Strand>,
    /// What goes on in what as the strands stood.
    pub taken: Links,
    /// Per crossing the ends of segments that meet there.
    pub crossings: Vec<Vec<Meeting>>,
}

/// Cuts the strands in the middle of their stretches; where an end is within two links, the strand ends there.
pub fn cut(strands: &[Strand], workshop: &Workshop<'_>) -> Cut {
    let touches = Touches::new(strands, workshop.link_mm);
    let crossings = touches.crossings();
    let near = touches.apart();
    let mut meeting: Vec<Vec<Meeting>> = vec![Vec::new(); crossings.len()];
    let mut cuts: Vec<Vec<(usize, usize, f64)>> = vec![Vec::new(); strands.len()];
    let mut ending: Vec<Vec<(End, usize, f64)>> = vec![Vec::new(); strands.len()];
    for (c, stretches) in crossings.iter().enumerate() {
        for (s, knots) in stretches {
            let (strand, arcs) = (&strands[*s], &touches.arcs[*s]);
            let (from, to) = (arcs[*knots.start()], arcs[arcs.len() - 1] - arcs[*knots.end()]);
            let stretch = arcs[*knots.end()] - arcs[*knots.start()];
            match (from <= near, to <= near) {
                // All of it lies at the crossing.
                (true, true) => {}
                (true, false) => ending[*s].push((End::First, c, from + stretch)),
                (false, true) => ending[*s].push((End::Last, c, to + stretch)),
                (false, false) => {
                    let middle = 0.5 * (arcs[*knots.start()] + arcs[*knots.end()]);
                    let at = strand.at(arcs.partition_point(|a| *a < middle));
                    let distance = |&n: &usize| (workshop.points[strand.points[n]].position_mm - at).norm_squared();
                    let nearest = (0..strand.points.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
                    cuts[*s].extend(nearest.map(|n| (n, c, 0.5 * stretch)));
                }
            }
        }
    }
    let (mut segments, mut taken) = (Vec::new(), Links::new());
    for (s, strand) in strands.iter().enumerate() {
        cuts[s].sort_by_key(|&(n, c, _)| (n, c));
        let first = segments.len();
        let mut from = 0;
        for &(n, c, half) in &cuts[s] {
            // A segment of one point would have no direction.
            if n < from + 2 || n + 2 > strand.points.len() {
                continue;
            }
            let number = segments.len();
            segments.push(workshop.strand(strand.points[from..n].to_vec()));
            meeting[c].extend([((number, End::Last), half), ((number + 1, End::First), half)]);
            from = n;
        }
        segments.push(if from == 0 { strand.clone() } else { workshop.strand(strand.points[from..].to_vec()) });
        for n in first..segments.len() {
            taken
                .push([(n > first).then(|| (n - 1, End::Last)), (n + 1 < segments.len()).then(|| (n + 1, End::First))]);
        }
        for &(end, c, shared) in &ending[s] {
            meeting[c].push(((if end == End::First { first } else { segments.len() - 1 }, end), shared));
        }
    }
    Cut { segments, taken, crossings: meeting }
}
