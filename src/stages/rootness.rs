//! Measures how much each voxel looks like part of a root.  Paper 2.5, Sato et al. equation 16.
//! In: merged; background, where the scale follows from what it learned of the roots' width. Out: sigma_mm (JSON, the scales),
//! rootness (z, y, x, f32, NaN = unknown), tangent (z, y, x, [x y z] i8, unit times
//! 127), scale (z, y, x, u8, index of the winning sigma).

use super::background::room;
use super::{four, slabs};
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::volume::rootness::{self, Stream, gray, scales_for};
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
    const VERSION: u32 = 4;

    fn peak_bytes(&self) -> u64 {
        // A slab, the planes within the kernels' reach, and three shards.
        1 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let merged = inputs.one("merged")?.array::<f32>("merged")?;
        let shape = merged.shape()[..3].to_vec();
        let mut values = output.slabs::<f32>("rootness", &shape, &["z", "y", "x"])?;
        let mut tangent = output.slabs::<i8>("tangent", &[&shape[..], &[3]].concat(), &["z", "y", "x", "c"])?;
        let mut scale = output.slabs::<u8>("scale", &shape, &["z", "y", "x"])?;
        progress.total(shape[0] as u64);
        let mut params = self.params.clone();
        if params.sigma.is_empty() {
            let width_mm = match inputs.many("background") {
                [background, ..] => room(background)?.root_width_mm,
                [] => None,
            };
            params.sigma.extend(scales_for(width_mm, self.spacing_mm));
        }
        output.json("sigma_mm", &params.sigma)?;
        let mut stream = Stream::new([shape[0], shape[1], shape[2]], self.spacing_mm, &params)?;
        // Colours, gray, and what becomes of them.
        let plane_bytes = shape[1] * shape[2] * 28;
        for (planes, _) in slabs(shape[0], 0, plane_bytes) {
            progress.check()?;
            let result = stream.push(gray(four(merged.slab(planes)?)?.view()).view());
            values.push(result.rootness.view().into_dyn())?;
            tangent.push(result.tangent.view().into_dyn())?;
            scale.push(result.scale.view().into_dyn())?;
            progress.advance(result.scale.dim().0 as u64);
        }
        values.finish()?;
        tangent.finish()?;
        scale.finish()
    }
}
