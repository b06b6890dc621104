//! Maps a photograph onto the voxels through air, wall and water.  Paper 2.3.
//! In: photo (undistorted), camera. Out: view (z, y, x, rgb + mask u8), I_ijkl of the paper; mask 255 where
//! the view has evidence, else 0.

use super::{SLAB_PLANES, read3, slabs};
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View};
use crate::volume::{Grid, ViewRenderer};
use ndarray::Array4;
use serde::Serialize;

/// One view's volume.
#[derive(Debug, Clone, Serialize)]
pub struct Render {
    /// The tank between voxels and camera.
    pub tank: Tank,
    /// The voxels.
    pub grid: Grid,
}

impl Stage for Render {
    const NAME: &'static str = "render";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        let [_, rows, columns] = self.grid.shape;
        // Picture, slab, and a shard being written.
        (64 << 20) + (64 << 20) + (SLAB_PLANES * rows * columns * 4) as u64
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let photo = read3::<u8>(inputs.one("photo")?, "photo")?;
        let view: View = inputs.one("camera")?.json("view")?;
        let renderer = ViewRenderer::new(&view, &self.tank, photo)?;
        let [depth, rows, columns] = self.grid.shape;
        let mut volume = output.slabs::<u8>("view", &[depth, rows, columns, 4], &["z", "y", "x", "c"])?;
        progress.total(depth as u64);
        for (own, _) in slabs(depth, 0) {
            progress.check()?;
            let planes = own.len();
            let mut slab = Array4::zeros((planes, rows, columns, 4));
            renderer.render_slab(&self.grid, own, slab.view_mut());
            volume.push(slab.view().into_dyn())?;
            progress.advance(planes as u64);
        }
        volume.finish()
    }
}
