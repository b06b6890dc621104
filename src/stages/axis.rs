//! Learns from all photographs the colour axis on which roots differ most from their background.
//! In: contrasts (of every view). Out: axis (JSON).

use super::suppress::triples;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::photo::contrast::axis::Learned;
use serde::Serialize;

/// The colour axis.
#[derive(Debug, Clone, Serialize)]
pub struct Axis {}

impl Stage for Axis {
    const NAME: &'static str = "axis";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let mut samples = Vec::new();
        for contrast in inputs.many("contrasts") {
            samples.append(&mut triples(contrast.array::<f32>("samples")?.read()?)?);
        }
        let learned = Learned::new(samples)?;
        if learned.is_gray() {
            output.warn("nothing in the water stands out from the photographs' noise: gray is used in place of a learned colour axis");
        }
        output.json("axis", &learned.axis)
    }
}
