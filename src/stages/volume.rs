//! Writes the volumes as an OME-Zarr 0.5 with a pyramid: merged colours, or the share of root, and rootness as channels.
//! In: merged, rootness. Out: volume.ome.zarr (folder, without its labels: `labels.rs`).
//!
//! Intensities are halved by their mean, rootness by its maximum. Grids finer than `MOST_VOXELS` begin
//! their pyramid at the first level that fits: the store has the full arrays.

use super::{four, slabs, three};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::ome_zarr::{self, Channel};
use crate::store;
use crate::volume::Grid;
use crate::volume::pyramid::{halve_max, halve_mean, levels};
use ndarray::{Array3, ArrayView3, Axis, s};
use serde::Serialize;

/// The OME-Zarr.
#[derive(Debug, Clone, Serialize)]
pub struct Volume {
    /// The grid of the volumes.
    pub grid: Grid,
}

/// Voxels of the finest level at most: what a viewer on a small machine opens without pain.
const MOST_VOXELS: usize = 1 << 26;
/// Longest edge of the coarsest level.
const COARSEST: usize = 64;

const COLOURS: [Channel; 3] = [
    Channel { label: "red", colour: "FF0000", window: [0.0, 1.0] },
    Channel { label: "green", colour: "00FF00", window: [0.0, 1.0] },
    Channel { label: "blue", colour: "0000FF", window: [0.0, 1.0] },
];
const SHARE: [Channel; 1] = [Channel { label: "share of root", colour: "00C0FF", window: [0.0, 1.0] }];
const ROOTNESS: Channel = Channel { label: "rootness", colour: "FFFFFF", window: [0.0, 0.1] };

impl Stage for Volume {
    const NAME: &'static str = "volume";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        self.grid.len().min(MOST_VOXELS) as u64 * 16
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let merged = inputs.one("merged")?.array::<f32>("merged")?;
        let rootness = inputs.one("rootness")?.array::<f32>("rootness")?;
        let Shown { finest, skipped, levels: count } = Shown::new(&self.grid);
        if skipped > 0 {
            output.warn(format!(
                "volume.ome.zarr begins at {} mm: the full grid of {} voxels stays in the store",
                finest.spacing_mm,
                self.grid.len()
            ));
        }
        let folder = output.folder("volume.ome.zarr")?;
        let values: &[Channel] = if merged.shape()[3] == 1 { &SHARE } else { &COLOURS };
        let channels = [values, &[ROOTNESS]].concat();
        store::write_group(&folder, &ome_zarr::image("volume", &finest, count, &channels))?;
        progress.total(channels.len() as u64);

        let mut shapes = vec![finest];
        for l in 1..count {
            shapes.push(coarser(&shapes[l - 1]));
        }
        let mut writers = shapes
            .iter()
            .enumerate()
            .map(|(l, grid)| {
                let shape = [&[channels.len()], &grid.shape[..]].concat();
                store::write_array::<f32>(&folder.join(l.to_string()), &shape, &["c", "z", "y", "x"])
            })
            .collect::<Result<Vec<_>>>()?;
        for channel in 0..channels.len() {
            progress.check()?;
            let is_rootness = channel == values.len();
            let halve = if is_rootness { halve_max } else { halve_mean };
            let read = |planes: std::ops::Range<usize>| -> Result<Array3<f32>> {
                if is_rootness {
                    three(rootness.slab(planes)?)
                } else {
                    Ok(four(merged.slab(planes)?)?.index_axis(Axis(3), channel).to_owned())
                }
            };
            let mut level = self.load(read, skipped, halve)?;
            for writer in &mut writers {
                writer.push(level.view().insert_axis(Axis(0)).into_dyn())?;
                level = halve(level.view());
            }
            progress.advance(1);
        }
        writers.into_iter().try_for_each(|writer| writer.finish())
    }
}

impl Volume {
    /// A volume slab by slab, halved on the way until it has the size of the pyramid's finest level.
    fn load(
        &self,
        read: impl Fn(std::ops::Range<usize>) -> Result<Array3<f32>>,
        skipped: u32,
        halve: fn(ArrayView3<f32>) -> Array3<f32>,
    ) -> Result<Array3<f32>> {
        let mut parts = Vec::new();
        for (own, _) in slabs(self.grid.shape[0], 0, 0) {
            // Slabs are 16 planes deep: up to four halvings never mix two slabs.
            let mut part = read(own)?;
            for _ in 0..skipped {
                part = halve(part.view());
            }
            parts.push(part);
        }
        let views: Vec<_> = parts.iter().map(|p| p.slice(s![.., .., ..])).collect();
        ndarray::concatenate(Axis(0), &views).map_err(|e| Error::failed(format!("slabs do not fit together: {e}")))
    }
}

/// What of a grid is shown.
pub(crate) struct Shown {
    /// Grid of the finest level.
    pub(crate) finest: Grid,
    /// Halvings between the full grid and the finest level.
    pub(crate) skipped: u32,
    /// Number of levels.
    pub(crate) levels: usize,
}

impl Shown {
    pub(crate) fn new(full: &Grid) -> Self {
        let (mut finest, mut skipped) = (*full, 0);
        while finest.len() > MOST_VOXELS {
            finest = coarser(&finest);
            skipped += 1;
        }
        Self { finest, skipped, levels: levels(finest.shape, COARSEST) }
    }
}

/// The grid of the next coarser level: the first voxel covers the first two of each axis.
fn coarser(grid: &Grid) -> Grid {
    Grid {
        origin_mm: grid.origin_mm.map(|o| o + grid.spacing_mm / 2.0),
        spacing_mm: grid.spacing_mm * 2.0,
        shape: grid.shape.map(|n| n.div_ceil(2)),
    }
}
