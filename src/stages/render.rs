//! Maps a photograph onto the voxels through air, wall and water.  Paper 2.3.
//! In: photo (undistorted), camera. Out: view (z, y, x, rgb + mask u8), I_ijkl of the paper; mask 255 where
//! the view has evidence, else 0.

use super::photographs::picture;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage, Streamed, store_streamed};
use crate::optics::{Tank, View};
use crate::store::{ArraySpec, Slab, SlabSource};
use crate::volume::{Grid, RenderOptions, ViewRenderer};
use ndarray::{Array4, ArrayViewMut4};
use serde::Serialize;
use std::ops::Range;

/// One view's volume.
#[derive(Debug, Clone, Serialize)]
pub struct Render {
    /// The tank between voxels and camera.
    pub tank: Tank,
    /// The voxels.
    pub grid: Grid,
    /// What counts as evidence and how it is taken.
    #[serde(flatten)]
    pub options: RenderOptions,
}

impl Stage for Render {
    const NAME: &'static str = "render";
    const VERSION: u32 = 8;

    fn peak_bytes(&self) -> u64 {
        // A slab, and a shard being written.
        128 << 20
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        store_streamed(self, inputs, output, progress)
    }
}

impl Streamed for Render {
    fn open(&self, inputs: &Inputs) -> Result<Box<dyn SlabSource>> {
        Ok(Box::new(self.planes(inputs)?))
    }
}

impl Render {
    /// The view's volume, ready to be rendered plane by plane.
    ///
    /// # Errors
    /// As the run of the stage.
    pub fn planes(&self, inputs: &Inputs) -> Result<ViewPlanes> {
        let photo = picture(inputs.one("photo")?)?;
        let view: View = inputs.one("camera")?.json("view")?;
        let (renderer, grid) = (ViewRenderer::new(&view, &self.tank, &photo, self.options)?, self.grid);
        Ok(ViewPlanes { grid, render: Box::new(move |planes, out| renderer.render_slab(&grid, planes, out)) })
    }
}

/// Renders planes of the grid into an array (z, y, x, rgb + mask).
type RenderSlab = Box<dyn Fn(Range<usize>, ArrayViewMut4<u8>) + Send + Sync>;

/// A view's volume while it is rendered.
pub struct ViewPlanes {
    pub(crate) grid: Grid,
    pub(crate) render: RenderSlab,
}

impl ViewPlanes {
    /// Some planes (z, y, x, rgb + mask).
    pub fn get(&self, planes: Range<usize>) -> Array4<u8> {
        let [_, rows, columns] = self.grid.shape;
        let mut slab = Array4::zeros((planes.len(), rows, columns, 4));
        (self.render)(planes, slab.view_mut());
        slab
    }
}

impl SlabSource for ViewPlanes {
    fn arrays(&self) -> Vec<ArraySpec> {
        let [depth, rows, columns] = self.grid.shape;
        vec![ArraySpec::new::<u8>("view", &[depth, rows, columns, 4], &["z", "y", "x", "c"])]
    }

    fn slab(&self, _: &str, planes: Range<usize>) -> Result<Slab> {
        Ok(self.get(planes).into_dyn().into())
    }
}
