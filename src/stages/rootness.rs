//! Measures how much each voxel looks like part of a root.  Paper 2.5, Sato et al. equation 16.
//! In: merged. Out: rootness (z, y, x, f32, NaN = unknown), tangent (z, y, x, [x y z] i8, unit times
//! 127), scale (z, y, x, u8, index of the winning sigma).

use super::{four, slabs};
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::volume::rootness::{self, gray, rootness};
use serde::Serialize;

/// Rootness with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Rootness {
    /// Edge of a voxel, mm.
    pub spacing_mm: f64,
    /// Scales and exponents.
    #[serde(flatten)]
    pub params: rootness::Rootness,
}

impl Stage for Rootness {
    const NAME: &'static str = "rootness";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let merged = inputs.one("merged")?.array::<f32>("merged")?;
        let shape = merged.shape()[..3].to_vec();
        let mut values = output.slabs::<f32>("rootness", &shape, &["z", "y", "x"])?;
        let mut tangent = output.slabs::<i8>("tangent", &[&shape[..], &[3]].concat(), &["z", "y", "x", "c"])?;
        let mut scale = output.slabs::<u8>("scale", &shape, &["z", "y", "x"])?;
        progress.total(shape[0] as u64);
        for (own, with_halo) in slabs(shape[0], self.params.halo(self.spacing_mm)) {
            progress.check()?;
            let slab = gray(four(merged.slab(with_halo.clone())?)?.view());
            let inner = own.start - with_halo.start..own.end - with_halo.start;
            let result = rootness(slab.view(), inner, self.spacing_mm, &self.params)?;
            values.push(result.rootness.view().into_dyn())?;
            tangent.push(result.tangent.view().into_dyn())?;
            scale.push(result.scale.view().into_dyn())?;
            progress.advance(own.len() as u64);
        }
        values.finish()?;
        tangent.finish()?;
        scale.finish()
    }
}
