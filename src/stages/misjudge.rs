//! Gives the cameras of a simulated capture errors, as if they were known badly.
//! In: cameras. Out: cameras (JSON, one entry per photograph).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::optics::View;
use crate::simulation::{MisjudgeParams, misjudged};
use serde::Serialize;

/// Cameras with errors.
#[derive(Debug, Clone, Serialize)]
pub struct Misjudge {
    /// Size of the errors.
    pub params: MisjudgeParams,
    /// Seed of the errors.
    pub seed: u64,
}

impl Stage for Misjudge {
    const NAME: &'static str = "misjudge";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let mut cameras: Vec<NamedView> = inputs.one("cameras")?.json("cameras")?;
        let views: Vec<View> = cameras.iter().map(|c| c.view.clone()).collect();
        for (camera, view) in cameras.iter_mut().zip(misjudged(&views, &self.params, self.seed)) {
            camera.view = view;
        }
        output.json("cameras", &cameras)
    }
}
