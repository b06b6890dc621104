//! Grows a root system and stands a camera before its tank: the truth of a simulated capture.
//! In: nothing. Out: cameras, roots (JSON).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::optics::Tank;
use crate::simulation::{CaptureParams, GrowthParams, PictureFormat, capture, grow};
use serde::Serialize;

/// Plant, tank and cameras of a simulated capture.
#[derive(Debug, Clone, Serialize)]
pub struct Capture {
    /// The tank the plant grows in.
    pub tank: Tank,
    /// How the roots grow.
    pub growth: GrowthParams,
    /// How they are photographed.
    pub capture: CaptureParams,
    /// Seed of growth and rotation.
    pub seed: u64,
}

/// File name of the `n`-th photograph.
pub fn photo_name(params: &CaptureParams, n: usize) -> String {
    let ending = match params.format {
        PictureFormat::Jpeg => "jpg",
        PictureFormat::Png => "png",
    };
    format!("{n:03}.{ending}")
}

impl Stage for Capture {
    const NAME: &'static str = "capture";
    const VERSION: u32 = 3;

    fn run(&self, _: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let roots = grow(&self.growth, &self.tank, self.seed)?;
        let views: Vec<NamedView> = capture(&self.capture, &self.tank, self.seed)?
            .into_iter()
            .enumerate()
            .map(|(n, view)| NamedView { file: format!("images/{}", photo_name(&self.capture, n)), view })
            .collect();
        output.json("cameras", &views)?;
        output.json("roots", &roots)
    }
}
