//! Views mapped onto voxels: I_ijkl of the paper, one view at a time, slab by slab.  Paper 2.3.
//!
//! Every voxel takes the colour of the undistorted photograph at the pixel whose regular ray goes through its
//! centre ([`ViewMap`]). A voxel carries no evidence (mask 0, colour 0) where
//!
//! - it lies outside the inner wall (ρ > rᵢ), at or above the water surface, or at or below the inner floor;
//! - no regular ray comes within δ (one grid spacing) of its centre (paper 2.3.3);
//! - the closest ray passes over the rim, through a belt, into the water above its surface or below its
//!   floor;
//! - the pixel lies outside the picture (beyond the outermost pixels' edges).
//!
//! With `exclude_irregular` off the folded rays count too: the closest ray wins, whatever its branch; where a
//! regular and a folded ray both go through the voxel's centre the regular one is taken.
//!
//! **Footprint.** A voxel of side δ covers L = δ m pixels a side, m (px/mm) being the root of the map's local
//! magnification of areas across the ray. Where L is large, a point sample sees one pixel in L² and its noise,
//! and roots thinner than the sampling alias; the footprint sample averages over the voxel's own share of the picture
//! ([`Pyramid`], texel L/√3) and equals the point sample where L <= √3.

use super::Grid;
use crate::error::{Error, Result};
use crate::optics::inverse::{LANES, Stack};
use crate::optics::{Tank, View, ViewMap};
use crate::photo::{Picture, Pyramid};
use ndarray::{ArrayViewMut4, Axis};
use pulp::Arch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Planes of a stack: the map is solved on few of them ([`Stack`]). As many as stages hold at once, for a stack that is asked
/// for in parts is solved for each part.
const STACK: usize = 16;

/// Planes of more voxels than this are held in such small numbers that each is solved itself.
const LARGE_PLANE: usize = 1 << 18;

/// One view ready to be mapped onto voxels; slabs may be asked for in any order, increasing z being usual.
#[derive(Debug, Clone)]
pub struct ViewRenderer {
    map: ViewMap,
    pyramid: Pyramid,
    options: RenderOptions,
}

/// How a voxel's colour is taken from the photograph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// The mean over the voxel's footprint on the picture.
    #[default]
    Footprint,
    /// The picture's (bilinear) value at one point, as in the paper.
    Point,
}

/// What counts as evidence, and how it is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct RenderOptions {
    /// Leave out the rays beyond the fold (paper 2.3.3).
    pub exclude_irregular: bool,
    /// How colours are taken.
    pub sampling: Sampling,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { exclude_irregular: true, sampling: Sampling::Footprint }
    }
}

impl ViewRenderer {
    /// `undistorted` is the view's photograph as its ideal lens would have taken it.
    ///
    /// # Errors
    /// Where view or tank are faulty (see [`ViewMap::new`]) or the picture's size is not the lens's.
    pub fn new(view: &View, tank: &Tank, undistorted: &Picture, options: RenderOptions) -> Result<Self> {
        let (height, width, channels) = undistorted.dim();
        let lens = view.lens.ideal();
        if (height, width, channels) != (lens.height, lens.width, 3) {
            return Err(Error::failed(format!(
                "the photograph has {width} x {height} px, its camera {} x {} px",
                lens.width, lens.height
            ))
            .help("give the camera that took this photograph, or photographs of the size it was calibrated with"));
        }
        let pyramid = match options.sampling {
            Sampling::Point => Pyramid::flat(undistorted),
            Sampling::Footprint => Pyramid::new(undistorted, 64.0),
        };
        Ok(Self { map: ViewMap::new(&view.ideal(), tank)?, pyramid, options })
    }

    /// Renders the planes `planes` of `grid` into `out`, (z, y, x, 4) u8, which holds zeros: red, green, blue, mask (255
    /// where the view has evidence, else 0).
    ///
    /// # Panics
    /// Where `out` does not have the shape of the slab or `planes` reaches beyond the grid.
    pub fn render_slab(&self, grid: &Grid, planes: Range<usize>, out: ArrayViewMut4<u8>) {
        self.render_on(Arch::new(), grid, planes, out);
    }

    /// [`Self::render_slab`] with the instructions of `arch`; the bits do not depend on it, for nothing fuses a
    /// product with a sum.
    fn render_on(&self, arch: Arch, grid: &Grid, planes: Range<usize>, mut out: ArrayViewMut4<u8>) {
        let [depth, rows, columns] = grid.shape;
        assert!(planes.end <= depth && out.dim() == (planes.len(), rows, columns, 4), "slab and array must agree");
        let Some(wet) = self.wet_planes(grid) else { return };
        let height = if rows * columns > LARGE_PLANE { 1 } else { STACK };
        let mut blocks = Vec::new();
        for (n, mut rest) in out.axis_chunks_iter_mut(Axis(1), LANES).enumerate() {
            let mut k = planes.start;
            while k < planes.end {
                // Stacks are cut the same way whatever slabs are asked for.
                let stack = (k / height * height).max(wet.start)..((k / height + 1) * height).min(wet.end);
                let end = ((k / height + 1) * height).min(planes.end);
                let (block, below) = rest.split_at(Axis(0), end - k);
                if !stack.is_empty() {
                    blocks.push((stack, k, n * LANES, block));
                }
                (rest, k) = (below, end);
            }
        }
        blocks
            .into_par_iter()
            .for_each(|(stack, k, j, out)| arch.dispatch(Block { renderer: self, grid, stack, k, j, out }));
    }

    /// The planes of the grid between water surface and floor.
    fn wet_planes(&self, grid: &Grid) -> Option<Range<usize>> {
        let tank = self.map.tank();
        let is_wet = |&k: &usize| {
            let z = grid.point_mm(k as f64, 0.0, 0.0).z;
            z > tank.water_level_mm && z < tank.floor_mm()
        };
        let (first, last) = ((0..grid.shape[0]).find(is_wet)?, (0..grid.shape[0]).rfind(is_wet)?);
        Some(first..last + 1)
    }

    /// Renders up to [`LANES`] rows from row j on of the planes from k on, that belong to `stack`; the lanes run along y, the
    /// solutions are carried along x.
    #[inline(always)]
    fn render_block(&self, grid: &Grid, stack: &Range<usize>, k: usize, j: usize, out: ArrayViewMut4<u8>) {
        let inner_squared = self.map.tank().inner_radius_mm().powi(2) * (1.0 + 1e-12);
        let (planes, rows, columns, _) = out.dim();
        let y: [f64; LANES] = std::array::from_fn(|l| grid.point_mm(0.0, (j + l) as f64, 0.0).y);
        let heights = stack.clone().map(|k| grid.point_mm(k as f64, 0.0, 0.0).z).collect();
        let folded = !self.options.exclude_irregular;
        let mut pixels = Stack::new(&self.map, grid.origin_mm[0], &y, heights, grid.spacing_mm, folded);
        let texel_mm = match self.options.sampling {
            Sampling::Point => 0.0,
            Sampling::Footprint => Pyramid::texel_of_box(grid.spacing_mm),
        };
        let mut voxels = rows_of(out);
        for i in 0..columns {
            let x = grid.point_mm(0.0, 0.0, i as f64).x;
            let mut wanted = [false; LANES];
            for l in 0..rows {
                wanted[l] = x * x + y[l] * y[l] <= inner_squared;
            }
            if !wanted.contains(&true) {
                continue;
            }
            pixels.go_to(i, &wanted);
            for plane in (k..k + planes).filter(|plane| stack.contains(plane)) {
                let pixels = pixels.pixels(plane - stack.start);
                if pixels.u.iter().all(|u| u.is_nan()) {
                    continue;
                }
                let mut texel = pixels.px_per_mm;
                for scale in &mut texel {
                    *scale *= texel_mm;
                }
                let values = self.pyramid.samples(&pixels.u, &pixels.v, &texel, &wanted);
                for (row, value) in voxels[(plane - k) * rows..][..rows].iter_mut().zip(values) {
                    row[i] = value;
                }
            }
        }
    }
}

/// The voxels of all rows of a slab, plane by plane.
fn rows_of(mut slab: ArrayViewMut4<'_, u8>) -> Vec<&mut [[u8; 4]]> {
    let (planes, rows, _, _) = slab.dim();
    let mut all = Vec::with_capacity(planes * rows);
    for _ in 0..planes {
        let (mut plane, below) = slab.split_at(Axis(0), 1);
        for _ in 0..rows {
            let (row, rest) = plane.split_at(Axis(1), 1);
            all.push(row.into_slice().expect("voxels of a row are contiguous").as_chunks_mut().0);
            plane = rest;
        }
        slab = below;
    }
    all
}

/// [`ViewRenderer::render_block`] as a task for [`Arch::dispatch`]; a closure would not be inlined into it.
struct Block<'a> {
    renderer: &'a ViewRenderer,
    grid: &'a Grid,
    stack: Range<usize>,
    k: usize,
    j: usize,
    out: ArrayViewMut4<'a, u8>,
}

impl pulp::WithSimd for Block<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        self.renderer.render_block(self.grid, &self.stack, self.k, self.j, self.out);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Distortion, Index, Lens, Mat3, Vec3};

    fn scene() -> (View, Tank, Grid, Picture) {
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 100.0,
            wall_mm: 3.0,
            water_level_mm: 8.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 20.0]],
        };
        let forward = Vec3::new(-1.0, 0.05, 0.1).normalize();
        let right = forward.cross(&Vec3::z()).normalize();
        let rotation = Mat3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
        let lens =
            Lens { width: 240, height: 200, focal_px: 400.0, cx: 120.0, cy: 90.0, distortion: Distortion::default() };
        let view = View { lens, rotation, translation_mm: -(rotation * Vec3::new(200.0, 3.0, 30.0)) };
        let grid = Grid::of_tank(&tank, 1.0, 60.0).unwrap();
        let picture = Picture::from_shape_fn((200, 240, 3), |(y, x, c)| (x * 7 + y * 13 + c * 31) as u8);
        (view, tank, grid, picture)
    }

    fn rendered(arch: Arch, options: RenderOptions, planes: Range<usize>) -> ndarray::Array4<u8> {
        let (view, tank, grid, picture) = scene();
        let renderer = ViewRenderer::new(&view, &tank, &picture, options).unwrap();
        let mut out = ndarray::Array4::zeros((planes.len(), grid.shape[1], grid.shape[2], 4));
        renderer.render_on(arch, &grid, planes, out.view_mut());
        out
    }

    #[test]
    fn every_processor_renders_the_same_bits() {
        for sampling in [Sampling::Point, Sampling::Footprint] {
            let options = RenderOptions { sampling, ..RenderOptions::default() };
            assert_eq!(rendered(Arch::new(), options, 0..60), rendered(Arch::Scalar, options, 0..60));
        }
    }

    #[test]
    fn slabs_are_cut_from_the_whole() {
        let options = RenderOptions::default();
        let whole = rendered(Arch::new(), options, 0..60);
        let slab = rendered(Arch::new(), options, 33..38);
        assert_eq!(slab, whole.slice_axis(Axis(0), (33..38).into()));
    }

    #[test]
    fn voxels_take_the_colour_of_their_pixel() {
        let (view, tank, grid, picture) = scene();
        let map = ViewMap::new(&view, &tank).unwrap();
        let options = RenderOptions { sampling: Sampling::Point, ..RenderOptions::default() };
        let out = rendered(Arch::new(), options, 0..60);
        let pyramid = Pyramid::flat(&picture);
        let mut seen = 0;
        for ((k, j, i), &mask) in out.index_axis(Axis(3), 3).indexed_iter() {
            let point = grid.point_mm(k as f64, j as f64, i as f64);
            let in_water = point.z > tank.water_level_mm && point.z < tank.floor_mm();
            let near = map.project(&point).filter(|p| in_water && p.clear && p.distance_mm <= 1.0);
            let want = near.and_then(|p| pyramid.sample(p.u, p.v, 1.0));
            assert_eq!(mask == 255, want.is_some(), "({k}, {j}, {i})");
            for (c, value) in want.unwrap_or_default().into_iter().enumerate() {
                assert!(out[[k, j, i, c]].abs_diff(value) <= 1, "({k}, {j}, {i})");
            }
            seen += usize::from(mask == 255);
        }
        assert!(seen > 60_000, "{seen}");
    }

    #[test]
    fn folded_rays_only_add_voxels() {
        let with = RenderOptions { exclude_irregular: false, ..RenderOptions::default() };
        let (less, more) =
            (rendered(Arch::new(), RenderOptions::default(), 30..34), rendered(Arch::new(), with, 30..34));
        let count = |volume: &ndarray::Array4<u8>| volume.index_axis(Axis(3), 3).iter().filter(|&&m| m > 0).count();
        assert!(count(&more) > count(&less) + 100);
        for (a, b) in less.index_axis(Axis(3), 3).iter().zip(more.index_axis(Axis(3), 3)) {
            assert!(a <= b);
        }
    }

    #[test]
    fn a_picture_of_another_size_is_refused() {
        let (view, tank, _, _) = scene();
        let error =
            ViewRenderer::new(&view, &tank, &Picture::zeros((10, 10, 3)), RenderOptions::default()).unwrap_err();
        assert!(error.message.contains("10 x 10 px") && error.help.is_some());
    }
}
