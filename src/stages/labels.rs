//! Writes the extracted roots as the label image of the OME-Zarr: each connected piece has its number,
//! from 1; 0 is water.
//! In: roots. Out: labels (folder).

use super::extract;
use super::volume::Shown;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::ome_zarr;
use crate::store;
use crate::volume::Grid;
use crate::volume::pyramid::halve_labels;
use ndarray::Array3;
use serde::Serialize;

/// The label image.
#[derive(Debug, Clone, Serialize)]
pub struct Labels {
    /// The grid of the volumes.
    pub grid: Grid,
}

impl Stage for Labels {
    const NAME: &'static str = "labels";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        self.grid.len() as u64 * 5
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let Shown { finest, skipped, levels } = Shown::new(&self.grid);
        let mut labels = Array3::<u32>::zeros(self.grid.shape);
        let flat = labels.as_slice_mut().ok_or_else(|| Error::failed("labels are not contiguous"))?;
        for root in extract::read(inputs.one("roots")?)? {
            if let Some(label) = flat.get_mut(root.index as usize) {
                *label = root.component + 1;
            }
        }
        for _ in 0..skipped {
            labels = halve_labels(labels.view());
        }
        let group = output.folder("labels")?;
        store::write_group(&group, &ome_zarr::labels(&["roots"]))?;
        let image = group.join("roots");
        store::write_group(&image, &ome_zarr::label_image("roots", &finest, levels))?;
        progress.total(levels as u64);
        for level in 0..levels {
            progress.check()?;
            let mut writer =
                store::write_array::<u32>(&image.join(level.to_string()), labels.shape(), &["z", "y", "x"])?;
            writer.push(labels.view().into_dyn())?;
            writer.finish()?;
            labels = halve_labels(labels.view());
            progress.advance(1);
        }
        Ok(())
    }
}
