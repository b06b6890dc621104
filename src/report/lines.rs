//! The traced roots as lines on a photograph, and how well the photograph shows each of them.
//!
//! A root shows well where its line is long and clear: a stretch is clear where no other root's line, both as wide as
//! the roots are, comes within a pixel. The photographs with the longest clear line are the ones to look at.

use crate::optics::Vec3;
use crate::roots::Root;
use imageproc::geometry::approximate_polygon_dp;
use imageproc::point::Point;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Gap between two roots' edges that tells them apart, px.
const APART_PX: f64 = 1.0;
/// Lines are drawn within this of their points, px.
const TOLERANCE_PX: f64 = 0.25;
/// Steps of the drawn coordinates per px.
const STEPS_PER_PX: f64 = 10.0;
/// Width of the cells in which neighbours are sought, px; wider where a root is.
const CELL_PX: f64 = 8.0;

/// Where a photograph sees a point of a root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dot {
    /// Pixel, right and down.
    pub pixel: [f64; 2],
    /// Pixels that a millimetre across the line of sight takes there.
    pub px_per_mm: f64,
}

/// A root on a photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RootLine {
    /// Number of the root.
    pub id: i64,
    /// Its stretches in sight as (u, v, u, v, ...), tenths of a pixel.
    pub strokes: Vec<Vec<i32>>,
    /// Length of its stretches that no other root crosses, px.
    pub clear_px: f64,
}

/// A point in sight with its radius, px.
struct Seen {
    root: usize,
    pixel: [f64; 2],
    radius_px: f64,
}

/// The lines of all roots that `see` sees some of.
pub fn root_lines(roots: &[Root], see: impl Fn(&Vec3) -> Option<Dot>) -> Vec<RootLine> {
    let mut stretches: Vec<(usize, Vec<Seen>)> = Vec::new();
    for (n, root) in roots.iter().enumerate() {
        let mut open = Vec::new();
        for (p, r) in root.points_mm.iter().zip(&root.radii_mm) {
            match see(&Vec3::from(*p)) {
                Some(dot) => open.push(Seen { root: n, pixel: dot.pixel, radius_px: r * dot.px_per_mm }),
                None => stretches.push((n, std::mem::take(&mut open))),
            }
        }
        stretches.push((n, open));
    }
    stretches.retain(|(_, points)| points.len() > 1);
    let near = Near::new(stretches.iter().flat_map(|(_, points)| points));
    let mut lines: Vec<RootLine> = Vec::new();
    for (n, points) in &stretches {
        let clear: Vec<bool> = points.iter().map(|p| near.is_clear(p)).collect();
        let length: f64 = points
            .windows(2)
            .zip(clear.windows(2))
            .filter(|(_, clear)| clear[0] && clear[1])
            .map(|(p, _)| (p[1].pixel[0] - p[0].pixel[0]).hypot(p[1].pixel[1] - p[0].pixel[1]))
            .sum();
        let id = roots[*n].id;
        if lines.last().is_none_or(|line| line.id != id) {
            lines.push(RootLine { id, strokes: Vec::new(), clear_px: 0.0 });
        }
        if let Some(line) = lines.last_mut() {
            line.strokes.push(stroke(points));
            line.clear_px += length;
        }
    }
    for line in &mut lines {
        line.clear_px = (line.clear_px * STEPS_PER_PX).round() / STEPS_PER_PX;
    }
    lines
}

/// The points that a line needs.
fn stroke(points: &[Seen]) -> Vec<i32> {
    let step = |x: f64| (x * STEPS_PER_PX).round() as i32;
    let curve: Vec<Point<i32>> = points.iter().map(|p| Point::new(step(p.pixel[0]), step(p.pixel[1]))).collect();
    approximate_polygon_dp(&curve, TOLERANCE_PX * STEPS_PER_PX, false).into_iter().flat_map(|p| [p.x, p.y]).collect()
}

/// Points in sight by the cells of a grid.
struct Near<'a> {
    cell_px: f64,
    cells: BTreeMap<(i64, i64), Vec<&'a Seen>>,
    widest_px: f64,
}

impl<'a> Near<'a> {
    fn new(points: impl Iterator<Item = &'a Seen> + Clone) -> Self {
        let widest_px = points.clone().map(|p| p.radius_px).fold(0.0, f64::max);
        let mut near = Self { cell_px: CELL_PX.max(2.0 * widest_px + APART_PX), cells: BTreeMap::new(), widest_px };
        for point in points {
            near.cells.entry(near.cell(point.pixel)).or_default().push(point);
        }
        near
    }

    fn cell(&self, [u, v]: [f64; 2]) -> (i64, i64) {
        ((u / self.cell_px).floor() as i64, (v / self.cell_px).floor() as i64)
    }

    fn is_clear(&self, point: &Seen) -> bool {
        debug_assert!(self.cell_px >= point.radius_px + self.widest_px + APART_PX);
        let (a, b) = self.cell(point.pixel);
        let cells = (a - 1..=a + 1).flat_map(|a| (b - 1..=b + 1).map(move |b| (a, b)));
        !cells.filter_map(|cell| self.cells.get(&cell)).flatten().any(|other| {
            let apart = (other.pixel[0] - point.pixel[0]).hypot(other.pixel[1] - point.pixel[1]);
            other.root != point.root && apart < other.radius_px + point.radius_px + APART_PX
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn straight(id: i64, at: impl Fn(f64) -> [f64; 3]) -> Root {
        let points_mm: Vec<[f64; 3]> = (0..=40).map(|k| at(f64::from(k))).collect();
        Root { id, parent: -1, order: 0, radii_mm: vec![0.5; points_mm.len()], points_mm }
    }

    /// From the side: x goes right, z down, a millimetre is a pixel.
    fn side(p: &Vec3) -> Option<Dot> {
        Some(Dot { pixel: [p.x, p.z], px_per_mm: 1.0 })
    }

    #[test]
    fn a_crossing_takes_from_both() {
        let (down, across) = (straight(3, |t| [20.0, 0.0, t]), straight(7, |t| [t, 5.0, 20.0]));
        let lines = root_lines(&[down.clone(), across], side);
        assert_eq!(lines.iter().map(|l| l.id).collect::<Vec<_>>(), [3, 7]);
        assert_eq!(lines[0].strokes, [[200, 0, 200, 400]], "a straight line needs its ends");
        // Dots within 2 px of the crossing (1 px between edges of roots 1 px wide) are hindered: 3 of 41, 4 steps.
        assert_eq!((lines[0].clear_px, lines[1].clear_px), (36.0, 36.0));
        assert_eq!(root_lines(&[down], side)[0].clear_px, 40.0);
    }

    #[test]
    fn lines_are_cut_where_unseen() {
        let root = straight(1, |t| [t, 0.0, 0.0]);
        let see = |p: &Vec3| if p.x == 10.0 || p.x == 12.0 { None } else { side(p) };
        let lines = root_lines(std::slice::from_ref(&root), see);
        assert_eq!(lines[0].strokes, [[0, 0, 90, 0], [130, 0, 400, 0]]);
        assert!(root_lines(&[root], |_| None).is_empty());
    }

    proptest! {
        #[test]
        fn cells_find_what_a_search_of_all_pairs_finds(
            points in prop::collection::vec((0..3usize, -30.0..30.0f64, -30.0..30.0f64, 0.1..9.0f64), 2..40)
        ) {
            let points: Vec<Seen> =
                points.into_iter().map(|(root, u, v, radius_px)| Seen { root, pixel: [u, v], radius_px }).collect();
            let near = Near::new(points.iter());
            for p in &points {
                let slow = !points.iter().any(|o| {
                    o.root != p.root
                        && (o.pixel[0] - p.pixel[0]).hypot(o.pixel[1] - p.pixel[1]) < o.radius_px + p.radius_px + APART_PX
                });
                prop_assert_eq!(near.is_clear(p), slow);
            }
        }
    }
}
