//! The paper's own way from voxels to pixels, kept for comparison with the exact inverse.  Paper 2.3.2, 2.3.3.
//!
//! 1. [`lattice`]: at every `every`-th voxel (the last ones of the grid included) the pixel whose ray passes
//!    closest, in two steps: first among the centres of the `patch_px` x `patch_px` patches of the picture, then
//!    among all pixels of the best patch. Rays are straight lines without ends, p₂ + t v₂, traced forward
//!    through both walls. A pixel is regular where `det [∂p₃/∂u | ∂p₃/∂v | N(p₃)] >= 0`, the derivatives taken to the
//!    next pixel right and below. Ties go to the first pixel in reading order.
//! 2. [`PatchRbfRenderer`]: between the nodes u and v are interpolated by radial basis functions, φ(r) = r³ with a
//!    linear part, fitted for each lattice cell to the nodes of the cell and one more on either side (up to 4 x 4 x
//!    4), among those that lie within δ of their ray. Where fewer than [`FEWEST_NODES`] remain, or they lie in one
//!    plane (then nothing tells how the pixels change across it), the cell carries no evidence.
//!
//! The ray of the interpolated pixel is traced: voxels over δ away from it carry no evidence, nor do those
//! that [`super::render`] rules out.

use super::Grid;
use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3, View, WaterRay, trace};
use crate::photo::{Picture, Pyramid};
use nalgebra::{DMatrix, Dyn, Matrix, U2, VecStorage};
use ndarray::{Array4, ArrayViewMut4};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Fewest nodes that a cell is interpolated from.
pub const FEWEST_NODES: usize = 8;

/// Sizes of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct PatchRbf {
    /// Side of the picture's patches, px (paper: 64).
    pub patch_px: usize,
    /// Distance of the lattice's nodes, voxels (paper: 10).
    pub every: usize,
    /// Search among regular pixels only.
    pub exclude_irregular: bool,
}

impl Default for PatchRbf {
    fn default() -> Self {
        Self { patch_px: 64, every: 10, exclude_irregular: true }
    }
}

impl PatchRbf {
    /// Fails where a size is zero.
    ///
    /// # Errors
    /// Names the size.
    pub fn check(&self) -> Result<()> {
        for (name, value) in [("render.patch", self.patch_px), ("render.every", self.every)] {
            if value == 0 {
                return Err(
                    Error::usage(format!("{name} is 0")).help("the paper takes patches of 64 px, every 10th voxel")
                );
            }
        }
        Ok(())
    }

    /// Voxel indices of the nodes along an axis of `len` voxels.
    fn nodes(&self, len: usize) -> Vec<usize> {
        let mut nodes: Vec<usize> = (0..len).step_by(self.every).collect();
        if nodes.last() != Some(&(len - 1)) {
            nodes.push(len - 1);
        }
        nodes
    }
}

/// A pixel and its ray in the water.
struct PixelRay {
    u: f64,
    v: f64,
    point: Vec3,
    direction: Vec3,
}

/// Squared distance of a point from a ray, taken as a line without ends; `direction` is a unit vector.
fn squared_distance(ray: &PixelRay, p: &Vec3) -> f64 {
    let to = p - ray.point;
    let along = to.dot(&ray.direction);
    (to.norm_squared() - along * along).max(0.0)
}

/// The picture's rays; pixels are those of the ideal lens.
struct Camera<'a> {
    view: &'a View,
    tank: &'a Tank,
    centre: Vec3,
    regular_only: bool,
}

impl Camera<'_> {
    fn trace(&self, u: f64, v: f64) -> Option<WaterRay> {
        trace(self.tank, &self.centre, &self.view.ray_in_tank(u, v))
    }

    /// The pixel's ray, if it gets into the water and counts.
    fn pixel(&self, u: f64, v: f64) -> Option<PixelRay> {
        let ray = self.trace(u, v)?;
        if self.regular_only {
            let (right, below) = (self.trace(u + 1.0, v)?, self.trace(u, v + 1.0)?);
            let normal = Vec3::new(ray.p3_mm.x, ray.p3_mm.y, 0.0);
            let determinant = (right.p3_mm - ray.p3_mm).cross(&(below.p3_mm - ray.p3_mm)).dot(&normal);
            if determinant < 0.0 {
                return None;
            }
        }
        Some(PixelRay { u, v, point: ray.p2_mm, direction: ray.v2 })
    }
}

/// u, v (px) and the distance (mm) of the closest pixel's ray at each node: (z, y, x, 3) f32; all NaN where no
/// patch centre's ray gets into the water.
///
/// # Errors
/// Where a size is zero or view or tank are faulty.
pub fn lattice(view: &View, tank: &Tank, grid: &Grid, sizes: &PatchRbf) -> Result<Array4<f32>> {
    sizes.check()?;
    view.check()?;
    tank.check()?;
    let view = view.ideal();
    let camera = Camera { view: &view, tank, centre: view.centre_in_tank(), regular_only: sizes.exclude_irregular };
    let (width, height, side) = (view.lens.width, view.lens.height, sizes.patch_px);
    let span = |first: usize, len: usize| (first, (first + side).min(len));
    let patches: Vec<_> = (0..height)
        .step_by(side)
        .flat_map(|v| (0..width).step_by(side).map(move |u| (u, v)))
        .filter_map(|(u, v)| {
            let ((u0, u1), (v0, v1)) = (span(u, width), span(v, height));
            let centre = camera.pixel(0.5 * (u0 + u1 - 1) as f64, 0.5 * (v0 + v1 - 1) as f64)?;
            Some((centre, u0..u1, v0..v1))
        })
        .collect();
    let [ks, js, is] = grid.shape.map(|len| sizes.nodes(len));
    let shape = (ks.len(), js.len(), is.len());
    let points: Vec<Vec3> = ks
        .iter()
        .flat_map(|&k| js.iter().map(move |&j| (k, j)))
        .flat_map(|(k, j)| is.iter().map(move |&i| grid.point_mm(k as f64, j as f64, i as f64)))
        .collect();
    let closest = |rays: &mut dyn Iterator<Item = &PixelRay>, point: &Vec3| {
        let mut best = (f64::INFINITY, 0);
        for (index, ray) in rays.enumerate() {
            let distance = squared_distance(ray, point);
            if distance < best.0 {
                best = (distance, index);
            }
        }
        best
    };
    let best_patch: Vec<usize> =
        points.par_iter().map(|p| closest(&mut patches.iter().map(|patch| &patch.0), p).1).collect();
    // Each patch's pixels are traced once, for all nodes that chose it.
    let mut nodes_of_patch = vec![Vec::new(); patches.len()];
    if !patches.is_empty() {
        best_patch.iter().enumerate().for_each(|(node, &patch)| nodes_of_patch[patch].push(node));
    }
    let found: Vec<Vec<(usize, [f32; 3])>> = patches
        .par_iter()
        .zip(&nodes_of_patch)
        .map(|((_, us, vs), nodes)| {
            if nodes.is_empty() {
                return Vec::new();
            }
            let pixels = vs.clone().flat_map(|v| us.clone().map(move |u| (u, v)));
            let rays: Vec<PixelRay> = pixels.filter_map(|(u, v)| camera.pixel(u as f64, v as f64)).collect();
            let of_node = |&node: &usize| {
                let (squared, index) = closest(&mut rays.iter(), &points[node]);
                let ray = rays.get(index)?;
                Some((node, [ray.u as f32, ray.v as f32, squared.sqrt() as f32]))
            };
            nodes.iter().filter_map(of_node).collect()
        })
        .collect();
    let mut out = Array4::from_elem((shape.0, shape.1, shape.2, 3), f32::NAN);
    let values = out.as_slice_mut().expect("a new array is contiguous");
    for (node, value) in found.into_iter().flatten() {
        values[3 * node..3 * node + 3].copy_from_slice(&value);
    }
    Ok(out)
}

/// Where one view sees the voxels, from its lattice.
#[derive(Debug, Clone)]
pub struct PatchMap {
    view: View,
    tank: Tank,
    grid: Grid,
    sizes: PatchRbf,
    lattice: Array4<f32>,
}

/// One view ready to be mapped onto voxels.
#[derive(Debug, Clone)]
pub struct PatchRbfRenderer {
    map: PatchMap,
    pyramid: Pyramid,
}

/// The fitted interpolant of one cell: its nodes and, per node and for 1, z, y, x, the weights of u and v.
struct Fit {
    nodes: Vec<[f64; 3]>,
    weights: Matrix<f64, Dyn, U2, VecStorage<f64, Dyn, U2>>,
}

impl PatchRbfRenderer {
    /// `undistorted` is the view's photograph as its ideal lens would have taken it. Sampling is the paper's, at one
    /// point.
    pub fn new(map: PatchMap, undistorted: &Picture) -> Self {
        Self { map, pyramid: Pyramid::flat(undistorted) }
    }

    /// Renders the planes `planes` of the grid into `out`, (z, y, x, 4) u8: red, green, blue, mask (255 where
    /// the view has evidence, else 0).
    ///
    /// # Panics
    /// Where `out` does not have the shape of the slab or `planes` reaches beyond the grid.
    pub fn render_slab(&self, planes: Range<usize>, mut out: ArrayViewMut4<u8>) {
        let (map, grid) = (&self.map, &self.map.grid);
        let [depth, rows, columns] = grid.shape;
        assert!(planes.end <= depth && out.dim() == (planes.len(), rows, columns, 4), "slab and array must agree");
        out.fill(0);
        let centre = map.view.centre_in_tank();
        let found: Vec<_> = map
            .cells(&planes)
            .into_par_iter()
            .map(|cell| {
                let fit = map.fit(&cell.node)?;
                let mut voxels = Vec::new();
                for k in cell.voxels[0].clone() {
                    for j in cell.voxels[1].clone() {
                        for i in cell.voxels[2].clone() {
                            let point = grid.point_mm(k as f64, j as f64, i as f64);
                            if let Some((u, v)) = map.evidence(&centre, &point, fit.at([k, j, i]))
                                && let Some(rgb) = self.pyramid.sample(u, v, 1.0)
                            {
                                voxels.push((k - planes.start, j, i, rgb));
                            }
                        }
                    }
                }
                Some(voxels)
            })
            .collect();
        for (k, j, i, [red, green, blue]) in found.into_iter().flatten().flatten() {
            for (c, value) in [red, green, blue, 255].into_iter().enumerate() {
                out[[k, j, i, c]] = value;
            }
        }
    }
}

impl PatchMap {
    /// `lattice` comes from [`lattice`] with the same view, tank, grid and sizes.
    pub fn new(view: &View, tank: &Tank, grid: &Grid, sizes: PatchRbf, lattice: Array4<f32>) -> Self {
        Self { view: view.ideal(), tank: tank.clone(), grid: *grid, sizes, lattice }
    }

    /// The pixel that a voxel takes its colour from, px; `None` where it carries no evidence.
    pub fn pixel(&self, voxel: [usize; 3]) -> Option<(f64, f64)> {
        let grid = &self.grid;
        let mut node = [0; 3];
        for axis in 0..3 {
            let last = self.sizes.nodes(grid.shape[axis]).len().saturating_sub(2);
            node[axis] = (voxel[axis] / self.sizes.every).min(last);
        }
        let point = grid.point_mm(voxel[0] as f64, voxel[1] as f64, voxel[2] as f64);
        self.evidence(&self.view.centre_in_tank(), &point, self.fit(&node)?.at(voxel))
    }

    /// The pixel, if its ray is unhindered and passes the point within δ.
    fn evidence(&self, centre: &Vec3, point: &Vec3, (u, v): (f64, f64)) -> Option<(f64, f64)> {
        if point.x.hypot(point.y) > self.tank.inner_radius_mm() * (1.0 + 1e-12) {
            return None;
        }
        let ray = trace(&self.tank, centre, &self.view.ray_in_tank(u, v))?;
        let clear = self.tank.is_clear(ray.p1_mm.z) && self.in_water(ray.p2_mm.z) && self.in_water(point.z);
        let ray = PixelRay { u, v, point: ray.p2_mm, direction: ray.v2 };
        let near = squared_distance(&ray, point) <= self.grid.spacing_mm * self.grid.spacing_mm;
        (clear && near && self.view.holds(u, v)).then_some((u, v))
    }

    fn in_water(&self, z: f64) -> bool {
        z > self.tank.water_level_mm && z < self.tank.floor_mm()
    }

    /// The lattice cells that meet the planes, each with its voxels among them.
    fn cells(&self, planes: &Range<usize>) -> Vec<Cell> {
        let grid = &self.grid;
        let spans = |axis: usize| -> Vec<(usize, Range<usize>)> {
            let nodes = self.sizes.nodes(grid.shape[axis]);
            let last = nodes.len().saturating_sub(2);
            (0..=last)
                .map(|n| {
                    let end = if n == last { grid.shape[axis] } else { nodes[n + 1] };
                    (n, nodes[n]..end)
                })
                .collect()
        };
        let mut cells = Vec::new();
        for (kn, k) in spans(0) {
            let k = k.start.max(planes.start)..k.end.min(planes.end);
            if k.is_empty() {
                continue;
            }
            for (jn, j) in spans(1) {
                cells.extend(
                    spans(2).into_iter().map(|(n, i)| Cell { node: [kn, jn, n], voxels: [k.clone(), j.clone(), i] }),
                );
            }
        }
        cells
    }

    /// The interpolant of the cell whose first node is `node`.
    fn fit(&self, node: &[usize; 3]) -> Option<Fit> {
        let grid = &self.grid;
        let (depth, rows, columns, _) = self.lattice.dim();
        let around = |n: usize, len: usize| n.saturating_sub(1)..(n + 3).min(len);
        let axes = grid.shape.map(|len| self.sizes.nodes(len));
        let (mut nodes, mut values) = (Vec::new(), Vec::new());
        for k in around(node[0], depth) {
            for j in around(node[1], rows) {
                for i in around(node[2], columns) {
                    // A NaN fails the comparison.
                    if self.lattice[[k, j, i, 2]] <= grid.spacing_mm as f32 {
                        nodes.push([axes[0][k] as f64, axes[1][j] as f64, axes[2][i] as f64]);
                        values.push([f64::from(self.lattice[[k, j, i, 0]]), f64::from(self.lattice[[k, j, i, 1]])]);
                    }
                }
            }
        }
        let n = nodes.len();
        if n < FEWEST_NODES || lie_in_a_plane(&nodes) {
            return None;
        }
        let system = DMatrix::from_fn(n + 4, n + 4, |row, column| match (row < n, column < n) {
            (true, true) => basis(&nodes[row], &nodes[column]),
            (true, false) => linear(&nodes[row], column - n),
            (false, true) => linear(&nodes[column], row - n),
            (false, false) => 0.0,
        });
        let right = Matrix::<f64, Dyn, U2, _>::from_fn(n + 4, |row, c| values.get(row).map_or(0.0, |value| value[c]));
        let weights = system.lu().solve(&right)?;
        weights.iter().all(|w| w.is_finite()).then_some(Fit { nodes, weights })
    }
}

struct Cell {
    /// Lattice index of the cell's first node.
    node: [usize; 3],
    /// Its voxels.
    voxels: [Range<usize>; 3],
}

impl Fit {
    fn at(&self, voxel: [usize; 3]) -> (f64, f64) {
        let point = voxel.map(|index| index as f64);
        let n = self.nodes.len();
        let (mut u, mut v) = (0.0, 0.0);
        for row in 0..n + 4 {
            let basis = if row < n { basis(&self.nodes[row], &point) } else { linear(&point, row - n) };
            u += basis * self.weights[(row, 0)];
            v += basis * self.weights[(row, 1)];
        }
        (u, v)
    }
}

/// Whether whole-numbered points lie in one plane: no two steps from the first one span a volume with a third.
fn lie_in_a_plane(points: &[[f64; 3]]) -> bool {
    let from_first = |p: &[f64; 3]| Vec3::new(p[0] - points[0][0], p[1] - points[0][1], p[2] - points[0][2]);
    let steps: Vec<Vec3> = points[1..].iter().map(from_first).collect();
    let Some(a) = steps.iter().find(|a| a.norm_squared() > 0.0) else { return true };
    let Some(normal) = steps.iter().map(|b| a.cross(b)).find(|n| n.norm_squared() > 0.0) else { return true };
    steps.iter().all(|c| normal.dot(c) == 0.0)
}

/// φ = r³ between two points, in voxels.
fn basis(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let squared = (0..3).map(|i| (a[i] - b[i]) * (a[i] - b[i])).sum::<f64>();
    squared * squared.sqrt()
}

/// 1, z, y, x.
fn linear(point: &[f64; 3], term: usize) -> f64 {
    if term == 0 { 1.0 } else { point[term - 1] }
}
