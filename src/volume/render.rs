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

use super::Grid;
use crate::error::{Error, Result};
use crate::optics::inverse::{LANES, Lanes};
use crate::optics::{Tank, View, ViewMap};
use crate::photo::Picture;
use ndarray::{ArrayViewMut2, ArrayViewMut4, Axis};
use rayon::prelude::*;
use std::ops::Range;

/// One view ready to be mapped onto voxels; slabs may be asked for in any order, increasing z being usual.
#[derive(Debug, Clone)]
pub struct ViewRenderer {
    map: ViewMap,
    picture: Picture,
}

impl ViewRenderer {
    /// `undistorted` is the view's photograph as its ideal lens would have taken it.
    ///
    /// # Errors
    /// Where view or tank are faulty (see [`ViewMap::new`]) or the picture's size is not the lens's.
    pub fn new(view: &View, tank: &Tank, undistorted: Picture) -> Result<Self> {
        let (height, width, channels) = undistorted.dim();
        let lens = &view.lens;
        if (height, width, channels) != (lens.height, lens.width, 3) {
            return Err(Error::failed(format!(
                "the photograph has {width} x {height} px, its camera {} x {} px",
                lens.width, lens.height
            ))
            .help("give the camera that took this photograph, or photographs of the size it was calibrated with"));
        }
        let picture =
            if undistorted.is_standard_layout() { undistorted } else { undistorted.as_standard_layout().into_owned() };
        Ok(Self { map: ViewMap::new(&view.ideal(), tank)?, picture })
    }

    /// Renders the planes `planes` of `grid` into `out`, (z, y, x, 4) u8: red, green, blue, mask (255 where
    /// the view has evidence, else 0).
    ///
    /// # Panics
    /// Where `out` does not have the shape of the slab or `planes` reaches beyond the grid.
    pub fn render_slab(&self, grid: &Grid, planes: Range<usize>, mut out: ArrayViewMut4<u8>) {
        let [depth, rows, columns] = grid.shape;
        assert!(planes.end <= depth && out.dim() == (planes.len(), rows, columns, 4), "slab and array must agree");
        let mut blocks = Vec::with_capacity(planes.len() * rows.div_ceil(LANES));
        for (k, plane) in planes.zip(out.axis_iter_mut(Axis(0))) {
            let plane = plane.into_shape_with_order((rows, columns * 4)).expect("voxels of a row are contiguous");
            let mut rest = plane;
            let mut j = 0;
            while j < rows {
                let (block, below) = rest.split_at(Axis(0), LANES.min(rows - j));
                blocks.push((k, j, block));
                rest = below;
                j += LANES;
            }
        }
        blocks.into_par_iter().for_each(|(k, j, block)| self.render_block(grid, k, j, block));
    }

    /// Renders up to [`LANES`] rows of plane k from row j on; the lanes run along y, the solutions are carried
    /// along x.
    fn render_block(&self, grid: &Grid, k: usize, j: usize, mut out: ArrayViewMut2<u8>) {
        out.fill(0);
        let tank = self.map.tank();
        let height = grid.point_mm(k as f64, 0.0, 0.0).z;
        if height <= tank.water_level_mm || height >= tank.floor_mm() {
            return;
        }
        let inner_squared = tank.inner_radius_mm().powi(2) * (1.0 + 1e-12);
        let rows = out.nrows();
        let z = [height; LANES];
        let y: [f64; LANES] = std::array::from_fn(|l| grid.point_mm(0.0, (j + l) as f64, 0.0).y);
        let mut lanes = self.map.first_guess();
        for i in 0..grid.shape[2] {
            let x = [grid.point_mm(0.0, 0.0, i as f64).x; LANES];
            let wanted: [bool; LANES] = std::array::from_fn(|l| l < rows && x[l] * x[l] + y[l] * y[l] <= inner_squared);
            if !wanted.contains(&true) {
                continue;
            }
            self.map.solve_lanes(&x, &y, &z, &wanted, &mut lanes);
            for (l, mut row) in out.rows_mut().into_iter().enumerate() {
                let near = lanes.distance[l] <= grid.spacing_mm;
                if !(wanted[l] && near) {
                    continue;
                }
                if let Some([red, green, blue]) = self.colour(&lanes, l) {
                    for (c, value) in [red, green, blue, 255].into_iter().enumerate() {
                        row[4 * i + c] = value;
                    }
                }
            }
        }
    }

    /// Colour along the ray of lane l, where it carries evidence.
    fn colour(&self, lanes: &Lanes, l: usize) -> Option<[u8; 3]> {
        let (u, v) = self.map.clear_pixel(lanes.b[l], lanes.s[l])?;
        bilinear(&self.picture, u, v)
    }
}

/// Bilinear value, rounded; `None` beyond the outermost pixels' edges, their centres' values within.
fn bilinear(picture: &Picture, u: f64, v: f64) -> Option<[u8; 3]> {
    let (height, width, _) = picture.dim();
    let (right, bottom) = ((width - 1) as f64, (height - 1) as f64);
    if !(u >= -0.5 && v >= -0.5 && u <= right + 0.5 && v <= bottom + 0.5) {
        return None;
    }
    let (u, v) = (u.clamp(0.0, right), v.clamp(0.0, bottom));
    let (u0, v0) = ((u as usize).min(width.saturating_sub(2)), (v as usize).min(height.saturating_sub(2)));
    let (u1, v1) = ((u0 + 1).min(width - 1), (v0 + 1).min(height - 1));
    let (fu, fv) = ((u - u0 as f64) as f32, (v - v0 as f64) as f32);
    let pixels = picture.as_slice()?;
    let at = |row: usize, column: usize, c: usize| f32::from(pixels[3 * (row * width + column) + c]);
    Some(std::array::from_fn(|c| {
        let top = at(v0, u0, c) + fu * (at(v0, u1, c) - at(v0, u0, c));
        let low = at(v1, u0, c) + fu * (at(v1, u1, c) - at(v1, u0, c));
        (top + fv * (low - top) + 0.5) as u8
    }))
}
