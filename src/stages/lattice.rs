//! Searches the pixel of every n-th voxel in two steps.  Paper 2.3.2.
//! In: camera. Out: lattice (z, y, x, c f32: see [`crate::volume::patch_rbf::lattice`]).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View};
use crate::volume::patch_rbf::lattice;
use crate::volume::{Grid, PatchRbf};
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
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let view: View = inputs.one("camera")?.json("view")?;
        let pixels = lattice(&view, &self.tank, &self.grid, &self.sizes)?;
        output.array("lattice", pixels.view().into_dyn(), &["z", "y", "x", "c"])
    }
}
