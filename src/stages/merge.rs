//! Merges the views of each voxel.  Paper 2.4.
//! In: view volumes (z, y, x, rgb + mask u8). Out: merged (z, y, x, rgb or one share of root f32, 0..1, NaN = unseen),
//! coverage (z, y, x, u8, views used), residual (z, y, x, f32, mean distance of the views to the estimate).

use super::{SLAB_BYTES, four, slabs};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::volume::merge::{self, merge, merge_evidence};
use rayon::prelude::*;
use serde::Serialize;

/// The merge with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Merge {
    /// Whether the views hold shares of root with their confidence, not colours.
    pub evidence: bool,
    /// Estimator, metric and limits.
    #[serde(flatten)]
    pub params: merge::Merge,
}

impl Stage for Merge {
    const NAME: &'static str = "merge";
    const VERSION: u32 = 4;

    fn peak_bytes(&self) -> u64 {
        // A slab of all views, and three shards being filled and written.
        SLAB_BYTES as u64 + (512 << 20)
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let views = inputs.many("views").iter().map(|v| v.array::<u8>("view")).collect::<Result<Vec<_>>>()?;
        let shape = views.first().ok_or_else(|| Error::failed("there is no view to merge"))?.shape()[..3].to_vec();
        let channels = [&shape[..], &[if self.evidence { 1 } else { 3 }]].concat();
        let mut merged = output.slabs::<f32>("merged", &channels, &["z", "y", "x", "c"])?;
        let mut coverage = output.slabs::<u8>("coverage", &shape, &["z", "y", "x"])?;
        let mut residual = output.slabs::<f32>("residual", &shape, &["z", "y", "x"])?;
        progress.total(shape[0] as u64);
        // Four bytes a view, then colour, residual and coverage.
        let plane_bytes = shape[1] * shape[2] * (4 * views.len() + 17);
        for (own, _) in slabs(shape[0], 0, plane_bytes) {
            progress.check()?;
            let planes = own.len() as u64;
            let slabs = views.par_iter().map(|v| four(v.slab(own.clone())?)).collect::<Result<Vec<_>>>()?;
            let slabs: Vec<_> = slabs.iter().map(|s| s.view()).collect();
            let slab = if self.evidence { merge_evidence(&slabs, &self.params) } else { merge(&slabs, &self.params) }?;
            merged.push(slab.colour.view().into_dyn())?;
            coverage.push(slab.coverage.view().into_dyn())?;
            residual.push(slab.residual.view().into_dyn())?;
            progress.advance(planes);
        }
        merged.finish()?;
        coverage.finish()?;
        residual.finish()
    }
}
