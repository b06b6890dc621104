//! Writes the roots as the label image of the OME-Zarr: the tube of each root has its number plus one; 0 is water.
//! In: system. Out: labels (folder).

use super::slabs;
use super::volume::Shown;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::ome_zarr;
use crate::roots::{RootSystem, paint};
use crate::store;
use crate::volume::Grid;
use crate::volume::pyramid::halve_labels;
use ndarray::{Array3, Axis};
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
        // The finest level, and a slab with its distances at full resolution.
        Shown::new(&self.grid).finest.len() as u64 * 9 + (128 << 20)
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let Shown { finest, skipped, levels } = Shown::new(&self.grid);
        let system: RootSystem = inputs.one("system")?.json("system.json")?;
        let roots = system.plain();
        let [depth, rows, columns] = self.grid.shape;
        // Slabs are 16 planes deep: up to four halvings never mix two slabs.
        let parts: Vec<Array3<u32>> = slabs(depth, 0, 0)
            .map(|(planes, _)| {
                let [x, y, z] = self.grid.origin_mm;
                let slab = Grid {
                    origin_mm: [x, y, z + self.grid.spacing_mm * planes.start as f64],
                    shape: [planes.len(), rows, columns],
                    ..self.grid
                };
                (0..skipped).fold(paint::labels(&roots, &slab), |fine, _| halve_labels(fine.view()))
            })
            .collect();
        let views: Vec<_> = parts.iter().map(|part| part.view()).collect();
        let mut labels = ndarray::concatenate(Axis(0), &views)
            .map_err(|e| Error::failed(format!("slabs do not fit together: {e}")))?;
        drop(parts);
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
