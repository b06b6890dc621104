//! Where pieces pass each other: within the other's radius and a share of a link of its axis, once per pair, where they are nearest.

use super::Line;
use crate::roots::link::{tree_of, within};
use std::collections::BTreeMap;

/// A piece that passes another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passing {
    /// The piece.
    pub piece: usize,
    /// Its point that is nearest.
    pub point: usize,
    /// The other piece.
    pub other: usize,
    /// That one's point.
    pub other_point: usize,
    /// Distance of the points, mm.
    pub distance_mm: f64,
}

/// All passings, by piece and other.
pub fn passings(lines: &[Line<'_>], link_mm: f64) -> Vec<Passing> {
    let places: Vec<(usize, usize)> =
        lines.iter().enumerate().flat_map(|(n, line)| (0..=line.last()).map(move |k| (n, k))).collect();
    let positions: Vec<_> = places.iter().map(|&(n, k)| lines[n].at(k)).collect();
    let thickest = lines.iter().flat_map(|l| &l.piece.root.radii_mm).copied().fold(0.0, f64::max);
    let tree = tree_of(positions.iter().enumerate());
    let touch = 0.5 * link_mm;
    let mut best: BTreeMap<(usize, usize), Passing> = BTreeMap::new();
    for (&(piece, point), p) in places.iter().zip(&positions) {
        for n in within(&tree, p, thickest + touch) {
            let (other, other_point) = places[n];
            let distance_mm = (positions[n] - p).norm();
            if other == piece || distance_mm > lines[other].radius_mm(other_point) + touch {
                continue;
            }
            let passing = Passing { piece, point, other, other_point, distance_mm };
            let entry = best.entry((piece, other)).or_insert(passing);
            if distance_mm < entry.distance_mm {
                *entry = passing;
            }
        }
    }
    best.into_values().collect()
}
