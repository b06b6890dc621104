//! Hysteresis over ridges: which belong to roots, and which to one piece.  Paper 2.5.
//!
//! Ridge voxels of rootness above `low` that touch (26 neighbours) form pieces; the pieces that hold a
//! voxel above `high` are root, unless they are shorter than `min_length_mm`. [`Links`] finds the touching
//! pairs once; then any pair of thresholds is a pass of union-find over them.

use super::level::level;
use super::ridges::Ridges;
use crate::error::{Error, Result};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// What the thresholds are given in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// Multiples of the volume's own level between noise and roots, [`level`](super::level).
    Level,
    /// Rootness as it is, as in the paper.
    Rootness,
}

/// Which ridges are roots.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Hysteresis {
    /// Voxels above it may be root.
    #[schemars(range(min = 0.0))]
    pub low: f32,
    /// Voxels above it are root, and all that is linked to them above `low`.
    #[schemars(range(min = 0.0))]
    pub high: f32,
    /// level (half a typical root's rootness is 1) or rootness (the paper's; its [0.01, 0.02]).
    pub unit: Unit,
    /// Pieces whose voxels' bounding box has a shorter diagonal are dropped, mm; 0 keeps all, as the paper.
    #[schemars(range(min = 0.0))]
    pub min_length_mm: f32,
}

impl Default for Hysteresis {
    /// A root begins where it is a little over half as strong as the typical one and goes on to a third.
    fn default() -> Self {
        Self { low: 0.7, high: 1.1, unit: Unit::Level, min_length_mm: 3.0 }
    }
}

impl Hysteresis {
    /// Fails where a parameter of `section` is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self, section: &str) -> Result<()> {
        let mut faults = Vec::new();
        if self.low > self.high || self.low.is_nan() || self.high.is_nan() {
            faults.push(
                Error::usage(format!("{section}.low ({}) is not at most {section}.high ({})", self.low, self.high))
                    .help("voxels above `high` start a root, voxels above `low` continue it"),
            );
        }
        if !(self.min_length_mm >= 0.0 && self.min_length_mm.is_finite()) {
            faults.push(
                Error::usage(format!("{section}.min_length_mm is {}", self.min_length_mm)).help("give 0 or more mm"),
            );
        }
        Error::many(faults)
    }

    /// The thresholds (low, high) in the unit of rootness, for a volume of these ridges.
    pub fn thresholds(&self, ridges: &Ridges) -> (f32, f32) {
        let unit = match self.unit {
            Unit::Level => level(&ridges.rootness),
            Unit::Rootness => 1.0,
        };
        (self.low * unit, self.high * unit)
    }

    /// The pieces of these ridges that are root, on a grid of that spacing.
    pub fn pieces(&self, ridges: &Ridges, spacing_mm: f64) -> Pieces {
        let thresholds = self.thresholds(ridges);
        Links::new(ridges, thresholds.0).pieces(ridges, thresholds, self.min_length_mm / spacing_mm as f32)
    }
}

/// Pairs of ridge voxels that touch, by their places in the list.
#[derive(Debug, Clone, PartialEq)]
pub struct Links {
    pairs: Vec<[u32; 2]>,
}

/// Which ridge voxels are root.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pieces {
    /// Per ridge voxel: 0 = not root, else the number of its piece, from 1 in the order of first voxels.
    pub label: Vec<u32>,
    /// Number of pieces.
    pub count: u32,
}

impl Links {
    /// Finds all pairs among ridges of rootness above `floor`; thresholds under it find nothing more.
    pub fn new(ridges: &Ridges, floor: f32) -> Self {
        let [_, ny, nx] = ridges.shape;
        let kept: Vec<u32> = (0..ridges.len() as u32).filter(|&n| ridges.rootness[n as usize] > floor).collect();
        let mut pairs = Vec::new();
        // The 13 neighbours that come later in the list; for each one a sweep with two fingers, since
        // the index of the neighbour rises with the index.
        for [x, y, z] in (14..27i64).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]) {
            let shift = (z * ny as i64 + y) * nx as i64 + x;
            let mut ahead = 0;
            for &n in &kept {
                let index = i64::from(ridges.index[n as usize]);
                let wanted = index + shift;
                while ahead < kept.len() && i64::from(ridges.index[kept[ahead] as usize]) < wanted {
                    ahead += 1;
                }
                let Some(&other) = kept.get(ahead) else { break };
                if i64::from(ridges.index[other as usize]) == wanted {
                    // Not around the end of a row or a plane.
                    let (i, j) = (index % nx as i64, index / nx as i64 % ny as i64);
                    if (0..nx as i64).contains(&(i + x)) && (0..ny as i64).contains(&(j + y)) {
                        pairs.push([n, other]);
                    }
                }
            }
        }
        Self { pairs }
    }

    /// The touching pairs.
    pub fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs
    }

    /// The pieces of rootness above `low` that hold a voxel above `high` and whose bounding box's diagonal is
    /// at least `min_length` voxels.
    pub fn pieces(&self, ridges: &Ridges, (low, high): (f32, f32), min_length: f32) -> Pieces {
        let mut parent: Vec<u32> = (0..ridges.len() as u32).collect();
        for &[a, b] in &self.pairs {
            if ridges.rootness[a as usize] > low && ridges.rootness[b as usize] > low {
                join(&mut parent, a, b);
            }
        }
        // A representative is the first of its piece, so one pass forward has seen it before its members.
        let mut strong = vec![false; ridges.len()];
        for n in 0..ridges.len() {
            if ridges.rootness[n] > high {
                strong[find(&mut parent, n as u32) as usize] = true;
            }
        }
        if min_length > 0.0 {
            let mut boxes = HashMap::new();
            for n in (0..ridges.len()).filter(|&n| ridges.rootness[n] > low) {
                let first = find(&mut parent, n as u32);
                if strong[first as usize] {
                    let voxel = ridges.voxel(n);
                    let (least, most) = boxes.entry(first).or_insert((voxel, voxel));
                    for c in 0..3 {
                        least[c] = least[c].min(voxel[c]);
                        most[c] = most[c].max(voxel[c]);
                    }
                }
            }
            for (n, strong) in strong.iter_mut().enumerate().filter(|(_, strong)| **strong) {
                let (least, most) = boxes[&(n as u32)];
                let diagonal2: usize = (0..3).map(|c| (most[c] - least[c]).pow(2)).sum();
                *strong = (diagonal2 as f32).sqrt() >= min_length;
            }
        }
        let mut label = vec![0; ridges.len()];
        let mut count = 0;
        for n in 0..ridges.len() {
            if ridges.rootness[n] > low {
                let first = find(&mut parent, n as u32) as usize;
                if strong[first] {
                    if first == n {
                        count += 1;
                        label[n] = count;
                    } else {
                        label[n] = label[first];
                    }
                }
            }
        }
        Pieces { label, count }
    }
}

/// Representative of a piece: its first member. Halves paths on the way.
pub(crate) fn find(parent: &mut [u32], mut n: u32) -> u32 {
    while parent[n as usize] != n {
        parent[n as usize] = parent[parent[n as usize] as usize];
        n = parent[n as usize];
    }
    n
}

/// Joins two pieces under the earlier representative.
pub(crate) fn join(parent: &mut [u32], a: u32, b: u32) {
    let (a, b) = (find(parent, a), find(parent, b));
    parent[a.max(b) as usize] = a.min(b);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ridges(shape: [usize; 3], value: &[f32]) -> Ridges {
        let kept: Vec<usize> = (0..value.len()).filter(|&n| value[n] > 0.0).collect();
        Ridges {
            shape,
            index: kept.iter().map(|&n| n as u32).collect(),
            rootness: kept.iter().map(|&n| value[n]).collect(),
            tangent: vec![[0.0; 3]; kept.len()],
            offset: vec![[0.0; 3]; kept.len()],
            scale: vec![0; kept.len()],
        }
    }

    /// Flood fill on the dense volume.
    fn reference([nz, ny, nx]: [usize; 3], value: &[f32], low: f32, high: f32) -> Vec<bool> {
        let mut root = vec![false; value.len()];
        let mut queue: Vec<usize> = (0..value.len()).filter(|&n| value[n] > high && value[n] > low).collect();
        while let Some(n) = queue.pop() {
            if std::mem::replace(&mut root[n], true) {
                continue;
            }
            let (k, j, i) = (n / (ny * nx), n / nx % ny, n % nx);
            for z in k.saturating_sub(1)..(k + 2).min(nz) {
                for y in j.saturating_sub(1)..(j + 2).min(ny) {
                    for x in i.saturating_sub(1)..(i + 2).min(nx) {
                        let m = (z * ny + y) * nx + x;
                        if value[m] > low && !root[m] {
                            queue.push(m);
                        }
                    }
                }
            }
        }
        root
    }

    proptest! {
        #[test]
        fn equals_flood_fill(cells in prop::collection::vec(0u8..12, 4 * 5 * 6), low in 0u8..8, step in 0u8..5) {
            let shape = [4, 5, 6];
            // Most cells empty, so that pieces stay apart.
            let value: Vec<f32> = cells.iter().map(|&c| if c < 7 { 0.0 } else { f32::from(c) }).collect();
            let (low, high) = (f32::from(low), f32::from(low + step));
            let ridges = ridges(shape, &value);
            let pieces = Links::new(&ridges, 0.0).pieces(&ridges, (low, high), 0.0);
            let expected = reference(shape, &value, low, high);
            for (n, &index) in ridges.index.iter().enumerate() {
                prop_assert_eq!(pieces.label[n] > 0, expected[index as usize]);
            }
            let touching = Links::new(&ridges, low);
            for &[a, b] in touching.pairs() {
                prop_assert_eq!(pieces.label[a as usize], pieces.label[b as usize]);
            }
            let mut seen: Vec<u32> = pieces.label.iter().copied().filter(|&l| l > 0).collect();
            seen.sort_unstable();
            seen.dedup();
            prop_assert_eq!(seen, (1..=pieces.count).collect::<Vec<_>>());
        }
    }

    #[test]
    fn rows_do_not_touch_around_their_ends() {
        let mut value = vec![0.0; 2 * 3 * 4];
        value[3] = 1.0;
        value[4] = 1.0;
        let ridges = ridges([2, 3, 4], &value);
        assert!(Links::new(&ridges, 0.0).pairs().is_empty());
    }

    #[test]
    fn crossed_thresholds_are_refused() {
        let crossed = Hysteresis { low: 0.2, high: 0.1, min_length_mm: -1.0, ..Hysteresis::default() };
        let error = crossed.check("extract").unwrap_err();
        assert!(error.message.contains("extract.low") && error.others.len() == 1);
    }

    #[test]
    fn short_pieces_are_dropped() {
        let mut value = vec![0.0; 5 * 4 * 9];
        value[..6].fill(1.0);
        value[4 * 36..4 * 36 + 3].fill(1.0);
        let ridges = ridges([5, 4, 9], &value);
        let links = Links::new(&ridges, 0.0);
        assert_eq!(links.pieces(&ridges, (0.5, 0.5), 0.0).count, 2);
        let long = links.pieces(&ridges, (0.5, 0.5), 2.5);
        assert_eq!((long.count, long.label.iter().sum::<u32>()), (1, 6));
    }
}
