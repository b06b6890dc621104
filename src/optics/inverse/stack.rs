//! Stacks of planes: rays solved on a few planes of a stack, pixels interpolated on all others.
//!
//! The map bends slowly along z: over the height H of a stack a pixel's coordinate departs from the polynomial through
//! [`NODES`] Chebyshev-Lobatto planes by a part of the order of (H / 2D)⁵, D the camera's distance. So a stack is solved on these planes by
//! [`March`], and pixels, magnification and the heights at the walls follow for its planes by fixed weights.
//!
//! A row at a column is interpolated where all its rays on these planes meet their points and the last
//! coefficient of the polynomial, which is larger than what is left out, is under [`MOST_REST_PX`] in both coordinates
//! and under [`MOST_REST_SHARE`] of the magnification. It shows nothing where the points on all these planes lie so far beyond the
//! fold that no point between them can be within reach. Everything else (along the fold, close to a camera) is solved plane by plane.

use super::march::MOST_APPROACH;
use super::{LANES, March, Pixels, ViewMap};
use std::f64::consts::FRAC_1_SQRT_2;

/// Planes that are solved in each stack.
const NODES: usize = 5;

/// Their places in a stack, -1 to 1. Written out: a cosine has other last bits on other machines.
const PLACES: [f64; NODES] = [-1.0, -FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2, 1.0];

/// Bound of the last coefficient of pixel coordinates, px.
const MOST_REST_PX: f64 = 1e-3;

/// Bound of the last coefficient of the magnification, of itself.
const MOST_REST_SHARE: f64 = 1e-3;

/// A ray of an exactly solved plane misses its point by less, mm.
const MEETS: f64 = 1e-6;

/// What is interpolated: u, v, magnification, heights at the outer and the inner wall.
type Values = [[f64; LANES]; 5];

/// [`LANES`] neighbouring rows of a grid in a stack of planes; see the module.
#[derive(Debug)]
pub struct Stack<'a> {
    map: &'a ViewMap,
    /// Points on the solved planes farther than this (mm) from every regular ray have no point between them that is seen.
    far: f64,
    folded: bool,
    /// x of the first point and the step along the rows, mm.
    x: f64,
    spacing: f64,
    y: [f64; LANES],
    heights: Vec<f64>,
    /// Marches of the planes to interpolate between; none where every plane is solved.
    nodes: Vec<March<'a>>,
    /// Weights of these planes for each plane of the stack.
    weights: Vec<[f64; NODES]>,
    /// Marches of the planes themselves.
    planes: Vec<March<'a>>,
    /// The current column, and which rows are solved plane by plane there.
    column: usize,
    solved: [bool; LANES],
    /// Which rows are interpolated, and between what.
    between: [bool; LANES],
    values: [Values; NODES],
}

/// Lagrange's weights of the nodes at t, -1 to 1.
fn weights(t: f64) -> [f64; NODES] {
    std::array::from_fn(|n| (0..NODES).filter(|&m| m != n).map(|m| (t - PLACES[m]) / (PLACES[n] - PLACES[m])).product())
}

/// The last Chebyshev coefficient of the polynomial through the nodes' values.
#[inline(always)]
fn last_coefficient(values: &[Values; NODES], q: usize, l: usize) -> f64 {
    let ends = 0.5 * (values[0][q][l] + values[4][q][l]);
    0.25 * (ends - values[1][q][l] + values[2][q][l] - values[3][q][l])
}

impl<'a> Stack<'a> {
    /// Rows whose first points are `(x, y[l], z)`, z being the equally spaced `heights` of the stack's planes, and whose points lie `spacing`
    /// apart along x; tank frame, mm. A point is seen where a ray comes within `spacing` of it; regular rays alone are asked, or,
    /// where `folded`, all, and then every plane is solved.
    pub fn new(map: &'a ViewMap, x: f64, y: &[f64; LANES], heights: Vec<f64>, spacing: f64, folded: bool) -> Self {
        let (first, last) = (heights[0], heights[heights.len() - 1]);
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        // A march costs the same on any plane.
        let is_solved = folded || heights.len() <= NODES;
        let nodes = if is_solved { 0 } else { NODES };
        // Between two of these planes a point's distance from the fold changes by no more than this.
        let approach = MOST_APPROACH * half * 0.5 * FRAC_1_SQRT_2;
        let node_reach = spacing + approach;
        let marches = PLACES[..nodes].iter().map(|at| March::new(map, x, y, middle + half * at, spacing, node_reach));
        let reach = if folded { f64::INFINITY } else { spacing };
        Self {
            map,
            far: node_reach,
            folded,
            x,
            spacing,
            y: *y,
            nodes: marches.collect(),
            weights: heights.iter().filter(|_| !is_solved).map(|z| weights((z - middle) / half)).collect(),
            planes: heights.iter().map(|&z| March::new(map, x, y, z, spacing, reach)).collect(),
            heights,
            column: 0,
            solved: [false; LANES],
            between: [false; LANES],
            values: [[[0.0; LANES]; 5]; NODES],
        }
    }

    /// Goes on to column `i`, in which the rows are `wanted`. Columns follow each other.
    #[inline(always)]
    pub fn go_to(&mut self, i: usize, wanted: &[bool; LANES]) {
        self.column = i;
        if self.nodes.is_empty() {
            self.solved = *wanted;
            return;
        }
        let (mut meets, mut far) = ([true; LANES], [true; LANES]);
        for n in 0..NODES {
            let lanes = self.nodes[n].column(i, wanted);
            let Pixels { u, v, px_per_mm } = self.map.pixels(&lanes);
            for l in 0..LANES {
                meets[l] &= lanes.distance[l] < MEETS;
                far[l] &= lanes.distance[l] > self.far;
            }
            self.values[n] = [u, v, px_per_mm, lanes.wall_z, lanes.water_z];
        }
        let mut smooth = [false; LANES];
        for (l, smooth) in smooth.iter_mut().enumerate() {
            let rest = |q: usize| last_coefficient(&self.values, q, l).abs();
            let (u, v, scale) = (rest(0), rest(1), rest(2));
            // NaN is not smooth.
            *smooth = (u < MOST_REST_PX) & (v < MOST_REST_PX) & (scale < MOST_REST_SHARE * self.values[2][2][l]);
        }
        for l in 0..LANES {
            self.between[l] = wanted[l] & meets[l] & smooth[l];
            self.solved[l] = wanted[l] & !self.between[l] & !far[l];
        }
        if self.solved == [false; LANES] {
            self.planes.iter_mut().for_each(March::rest);
        }
    }

    /// Pixels of the current column in plane `k` of the stack; u is NaN where nothing is seen or wanted.
    #[inline(always)]
    pub fn pixels(&mut self, k: usize) -> Pixels {
        let mut out = Pixels { u: [f64::NAN; LANES], v: [0.0; LANES], px_per_mm: [0.0; LANES] };
        if self.between != [false; LANES] {
            let (weights, between) = (self.weights[k], self.between);
            let mut at = [[0.0; LANES]; 5];
            for (weight, values) in weights.iter().zip(&self.values) {
                for (at, values) in at.iter_mut().zip(values) {
                    for (at, value) in at.iter_mut().zip(values) {
                        *at += weight * value;
                    }
                }
            }
            let [u, v, px_per_mm, wall_z, water_z] = at;
            let clear = self.map.are_clear(&wall_z, &water_z);
            for l in 0..LANES {
                out.u[l] = if between[l] & clear[l] { u[l] } else { f64::NAN };
            }
            (out.v, out.px_per_mm) = (v, px_per_mm);
        }
        if self.solved != [false; LANES] {
            let solved = self.solved;
            let mut lanes = self.planes[k].column(self.column, &solved);
            if self.folded {
                let x = self.x + self.spacing * self.column as f64;
                self.map.admit_irregular(x, &self.y, self.heights[k], &solved, &mut lanes);
            }
            let exact = self.map.clear_pixels(&lanes);
            for l in (0..LANES).filter(|&l| solved[l]) {
                out.u[l] = if lanes.distance[l] <= self.spacing { exact.u[l] } else { f64::NAN };
                (out.v[l], out.px_per_mm[l]) = (exact.v[l], exact.px_per_mm[l]);
            }
        }
        out
    }
}
