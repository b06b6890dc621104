//! Tells how much of the water too few views see, and what of the true roots lies there.
//! In: merged, truth (optional). Out: sight (JSON).

use super::evaluate::truth;
use super::read3;
use crate::error::Result;
use crate::evaluation::sight;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::Tank;
use crate::volume::Grid;
use serde::Serialize;

/// What is seen of the water.
#[derive(Debug, Clone, Serialize)]
pub struct Sight {
    /// The grid of the volumes.
    pub grid: Grid,
    /// The tank.
    pub tank: Tank,
    /// Voxels seen by fewer views are unknown.
    pub min_views: usize,
}

impl Stage for Sight {
    const NAME: &'static str = "sight";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let coverage = read3::<u8>(inputs.one("merged")?, "coverage")?;
        let truth = inputs.many("truth").first().map(truth).transpose()?;
        output.json("sight", &sight(coverage.view(), self.min_views, &self.grid, &self.tank, truth.as_deref()))
    }
}
