//! A strand: one piece of a root, its ridge points in order and the smooth curve through them.

use super::curve;
use super::link::{Node, tree_of};
use super::ridge::RidgePoint;
use crate::optics::Vec3;
use rstar::RTree;
use serde::{Deserialize, Serialize};

/// x, y, z (mm), rootness, scale σ (mm).
pub type Knot = [f64; 5];

/// One piece of a root.
#[derive(Debug, Clone, PartialEq)]
pub struct Strand {
    /// Indices of its ridge points, in order along it.
    pub points: Vec<usize>,
    /// Knots of the smooth curve at equal spacing.
    pub knots: Vec<Knot>,
}

/// An end of a strand: its first knot or its last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum End {
    /// The first knot.
    First,
    /// The last knot.
    Last,
}

impl End {
    /// Both ends.
    pub const BOTH: [Self; 2] = [Self::First, Self::Last];

    /// The opposite end.
    pub fn other(self) -> Self {
        match self {
            Self::First => Self::Last,
            Self::Last => Self::First,
        }
    }
}

/// Every knot of every strand as (strand, knot), and the tree of their positions, whose nodes are places in that list.
pub fn knot_tree(strands: &[Strand]) -> (Vec<(usize, usize)>, RTree<Node>) {
    let places: Vec<(usize, usize)> =
        strands.iter().enumerate().flat_map(|(s, strand)| (0..strand.knots.len()).map(move |k| (s, k))).collect();
    let positions: Vec<Vec3> = places.iter().map(|&(s, k)| strands[s].at(k)).collect();
    let tree = tree_of(positions.iter().enumerate());
    (places, tree)
}

impl Strand {
    /// The strand through `points` in their order.
    pub fn new(points: Vec<usize>, all: &[RidgePoint], step_mm: f64, wavelength_mm: f64) -> Self {
        let values: Vec<Knot> = points
            .iter()
            .map(|&k| {
                let p = &all[k];
                [p.position_mm.x, p.position_mm.y, p.position_mm.z, p.rootness, p.sigma_mm]
            })
            .collect();
        Self { points, knots: curve::smooth(&values, step_mm, wavelength_mm) }
    }

    /// Length of the curve, mm.
    pub fn length_mm(&self) -> f64 {
        curve::chord_lengths(&self.knots).last().copied().unwrap_or(0.0)
    }

    /// Position of knot `k`, mm.
    pub fn at(&self, k: usize) -> Vec3 {
        curve::position(&self.knots[k])
    }

    /// Index of the knot at an end.
    pub fn end(&self, end: End) -> usize {
        match end {
            End::First => 0,
            End::Last => self.knots.len() - 1,
        }
    }

    /// Unit direction in which the strand leaves through an end: the chord over its last `over_mm`.
    pub fn outward(&self, end: End, over_mm: f64) -> Vec3 {
        let tip = self.end(end);
        self.direction_into(tip, end.other(), over_mm).map_or_else(Vec3::zeros, |inward| -inward)
    }

    /// Unit chord from knot `k` over `over_mm` towards an end; none where no way is left.
    pub fn direction_into(&self, k: usize, towards: End, over_mm: f64) -> Option<Vec3> {
        let from = self.at(k);
        let (mut at, mut gone, mut here) = (k, 0.0, from);
        while gone < over_mm {
            let next = match towards {
                End::First if at > 0 => at - 1,
                End::Last if at + 1 < self.knots.len() => at + 1,
                _ => break,
            };
            let there = self.at(next);
            gone += (there - here).norm();
            (at, here) = (next, there);
        }
        (here - from).try_normalize(1e-9)
    }

    /// Unit tangent at knot `k`, over one step to either side; zero for a strand of one knot.
    pub fn tangent(&self, k: usize) -> Vec3 {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(self.knots.len() - 1));
        (self.at(b) - self.at(a)).try_normalize(1e-9).unwrap_or_else(Vec3::zeros)
    }

    /// Mean of a knot value: 3 for rootness, 4 for the scale.
    pub fn mean(&self, column: usize) -> f64 {
        self.knots.iter().map(|k| k[column]).sum::<f64>() / self.knots.len().max(1) as f64
    }

    /// Knot nearest to `p` and its distance, mm.
    pub fn nearest(&self, p: &Vec3) -> (usize, f64) {
        (0..self.knots.len())
            .map(|k| (k, (self.at(k) - p).norm_squared()))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or((0, f64::INFINITY), |(k, d)| (k, d.sqrt()))
    }

    /// Radius of a round root whose response peaks at the scale of knot `k`, mm (a disc's Laplacian
    /// peaks at σ = r / √2; Lindeberg 1998).
    pub fn radius_mm(&self, k: usize) -> f64 {
        std::f64::consts::SQRT_2 * self.knots[k][4]
    }
}
