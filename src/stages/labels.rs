//! Writes the roots as the label image of the OME-Zarr: the tube of each root has its number plus one; 0 is water.
//! In: system. Out: labels (folder).

use super::volume::Shown;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::ome_zarr;
use crate::roots::{RootSystem, paint};
use crate::store;
use crate::volume::Grid;
use crate::volume::pyramid::halve_labels;
use serde::Serialize;

/// The label image.
#[derive(Debug, Clone, Serialize)]
pub struct Labels {
    /// The grid of the volumes.
    pub grid: Grid,
}

impl Stage for Labels {
    const NAME: &'static str = "labels";
    const VERSION: u32 = 2;

    fn peak_bytes(&self) -> u64 {
        // The finest level with the nearness of each voxel, and a shard.
        Shown::new(&self.grid).finest.len() as u64 * 9 + (128 << 20)
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let Shown { finest, levels, .. } = Shown::new(&self.grid);
        let system: RootSystem = inputs.one("system")?.json("system.json")?;
        let mut labels = paint::labels(&system.plain(), &finest);
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
