//! One horizontal slice of the volumes as pictures.  Paper figures 4 and 8.
//! In: merged, rootness. Out: merged.png (colours), coverage.png (views used: black none, white all of the most seen
//! voxel), rootness.png (black 0, white the slice's greatest). Unknown voxels are dark blue.

use super::{four, three};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use ndarray::{Array3, Axis};
use serde::Serialize;

/// The pictures of one plane.
#[derive(Debug, Clone, Serialize)]
pub struct Slices {
    /// Which plane of the grid.
    pub plane: usize,
}

/// Pixels per voxel.
const ZOOM: usize = 3;
/// Colour of what is unknown.
const UNKNOWN: [u8; 3] = [0, 0, 60];

impl Stage for Slices {
    const NAME: &'static str = "slices";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let merged = inputs.one("merged")?;
        let planes = self.plane..self.plane + 1;
        let colour = four(merged.array::<f32>("merged")?.slab(planes.clone())?)?.index_axis_move(Axis(0), 0);
        let coverage = three(merged.array::<u8>("coverage")?.slab(planes.clone())?)?.index_axis_move(Axis(0), 0);
        let rootness =
            three(inputs.one("rootness")?.array::<f32>("rootness")?.slab(planes)?)?.index_axis_move(Axis(0), 0);
        let (rows, columns) = coverage.dim();
        let most_seen = coverage.iter().copied().max().unwrap_or(0).max(1);
        let greatest = rootness.iter().copied().fold(f32::MIN_POSITIVE, f32::max);
        let mut put = |name: &str, at: &dyn Fn(usize, usize) -> [f32; 3]| {
            let mut png = Array3::zeros((rows * ZOOM, columns * ZOOM, 3));
            for ((y, x, c), pixel) in png.indexed_iter_mut() {
                let value = at(y / ZOOM, x / ZOOM)[c];
                *pixel = if value.is_nan() { UNKNOWN[c] } else { (value.clamp(0.0, 1.0) * 255.0).round() as u8 };
            }
            output.bytes(name, &picture::png(png.view())?)
        };
        let last = colour.dim().2 - 1;
        put("merged.png", &|j, i| [0, 1, 2].map(|c| colour[[j, i, last.min(c)]]))?;
        put("coverage.png", &|j, i| match coverage[[j, i]] {
            0 => [f32::NAN; 3],
            n => [f32::from(n) / f32::from(most_seen); 3],
        })?;
        put("rootness.png", &|j, i| [rootness[[j, i]] / greatest; 3])
    }
}

impl Slices {
    /// The plane nearest to a depth.
    ///
    /// # Errors
    /// Where the depth lies outside the grid.
    pub fn at(depth_mm: f64, grid: &crate::volume::Grid) -> Result<Self> {
        let plane = ((depth_mm - grid.origin_mm[2]) / grid.spacing_mm).round();
        if plane >= 0.0 && plane < grid.shape[0] as f64 {
            return Ok(Self { plane: plane as usize });
        }
        let deepest = grid.origin_mm[2] + grid.spacing_mm * (grid.shape[0] - 1) as f64;
        Err(Error::usage(format!("report.slice ({depth_mm} mm) lies outside the grid"))
            .help(format!("the grid reaches from {} to {deepest} mm", grid.origin_mm[2])))
    }
}
