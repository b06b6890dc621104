//! Holds the cameras and the tank that a reconstruction went by against those of the simulated capture.
//! In: cameras, truth (a capture). Out: errors (JSON).

use crate::error::Result;
use crate::evaluation::camera_errors;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::formats::cameras_json::in_pairs;
use crate::optics::Tank;
use serde::Serialize;

/// The comparison of cameras.
#[derive(Debug, Clone, Serialize)]
pub struct EvaluateCameras {
    /// The tank that was photographed.
    pub true_tank: Tank,
    /// The tank that the reconstruction went by.
    pub tank: Tank,
}

impl Stage for EvaluateCameras {
    const NAME: &'static str = "evaluate-cameras";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let found: Vec<NamedView> = inputs.one("cameras")?.json("cameras")?;
        let truth: Vec<NamedView> = inputs.one("truth")?.json("cameras")?;
        output.json("errors", &camera_errors(&in_pairs(&truth, &found), &self.true_tank, &self.tank)?)
    }
}
