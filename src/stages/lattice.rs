//! Searches the pixel of every n-th voxel in two steps.  Paper 2.3.2.
//! In: camera. Out: lattice (z, y, x, c f32: see [`crate::volume::patch_rbf::lattice`]). Warns of what the search costs
//! in accuracy.

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View, ViewMap};
use crate::volume::map_error::{MapError, NEAR_WALL_MM, deviations};
use crate::volume::patch_rbf::lattice;
use crate::volume::{Grid, PatchMap, PatchRbf};
use serde::Serialize;

/// The coarse lattice of one view.
#[derive(Debug, Clone, Serialize)]
pub struct Lattice {
    /// The tank between voxels and camera.
    pub tank: Tank,
    /// The voxels.
    pub grid: Grid,
    /// Sizes of the search.
    #[serde(flatten)]
    pub sizes: PatchRbf,
}

impl Stage for Lattice {
    const NAME: &'static str = "lattice";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let view: View = inputs.one("camera")?.json("view")?;
        let pixels = lattice(&view, &self.tank, &self.grid, &self.sizes)?;
        output.array("lattice", pixels.view().into_dyn(), &["z", "y", "x", "c"])?;
        let map = ViewMap::new(&view.ideal(), &self.tank)?;
        let search = PatchMap::new(&view, &self.tank, &self.grid, self.sizes, pixels);
        // Some ten thousand voxels, not at the nodes.
        let step = (self.grid.len() as f64 / 3e4).cbrt().ceil() as usize | 1;
        let [inside, wall] = MapError::inside_and_near_wall(&deviations(&search, &map, &self.grid, step));
        output.warn(format!(
            "render.method = patch-rbf is an approximation: it misses the exact pixel by {:.2} px in the median, {:.2} px in \
             95 of 100 voxels, {:.1} px at most ({:.2}, {:.2}, {:.1} px within {NEAR_WALL_MM} mm of the wall), and loses \
             {} of {} voxels that are seen; render.method = exact has no such error and takes less time",
            inside.median_px,
            inside.p95_px,
            inside.max_px,
            wall.median_px,
            wall.p95_px,
            wall.max_px,
            inside.lost + wall.lost,
            inside.lost + wall.lost + inside.voxels + wall.voxels
        ));
        Ok(())
    }
}
