//! A photograph's contrast along the roots' colour axis, as a gray photograph.
//! In: contrast, axis. Out: photo (y, x, rgb u8, equal channels; code 24 = background, 16 codes = one deviation of
//! the photographs' noise).

use super::contrast;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::photo::contrast::axis::ColourAxis;
use crate::photo::contrast::feature::feature;
use serde::Serialize;

/// The feature of every pixel.
#[derive(Debug, Clone, Serialize)]
pub struct Feature {}

impl Stage for Feature {
    const NAME: &'static str = "feature";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let axis: ColourAxis = inputs.one("axis")?.json("axis")?;
        let picture = feature(&contrast::read(inputs.one("contrast")?)?, &axis);
        output.array("photo", picture.view().into_dyn(), &["y", "x", "c"])
    }
}
