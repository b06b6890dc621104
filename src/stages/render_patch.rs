//! Maps a photograph onto the voxels by the paper's two-step search and interpolation, for comparison with
//! the exact inverse of `render.rs`.  Paper 2.3.2.
//! In: photo (undistorted), camera, lattice. Out: view, as of `render.rs`.

use super::four;
use super::photographs::picture;
use super::render::ViewPlanes;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage, Streamed, store_streamed};
use crate::optics::{Tank, View};
use crate::store::SlabSource;
use crate::volume::{Grid, PatchMap, PatchRbf, PatchRbfRenderer};
use serde::Serialize;

/// One view's volume, the paper's way.
#[derive(Debug, Clone, Serialize)]
pub struct RenderPatch {
    /// The tank between voxels and camera.
    pub tank: Tank,
    /// The voxels.
    pub grid: Grid,
    /// Sizes of the search.
    #[serde(flatten)]
    pub sizes: PatchRbf,
}

impl Stage for RenderPatch {
    const NAME: &'static str = "render-patch";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        store_streamed(self, inputs, output, progress)
    }
}

impl Streamed for RenderPatch {
    fn open(&self, inputs: &Inputs) -> Result<Box<dyn SlabSource>> {
        Ok(Box::new(self.planes(inputs)?))
    }
}

impl RenderPatch {
    /// The view's volume, ready to be rendered plane by plane.
    ///
    /// # Errors
    /// As the run of the stage.
    pub fn planes(&self, inputs: &Inputs) -> Result<ViewPlanes> {
        let photo = picture(inputs.one("photo")?)?;
        let view: View = inputs.one("camera")?.json("view")?;
        let lattice = four(inputs.one("lattice")?.array::<f32>("lattice")?.read()?)?;
        let grid = self.grid;
        let renderer = PatchRbfRenderer::new(PatchMap::new(&view, &self.tank, &grid, self.sizes, lattice), &photo);
        Ok(ViewPlanes { grid, render: Box::new(move |planes, out| renderer.render_slab(planes, out)) })
    }
}
