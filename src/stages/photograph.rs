//! Takes one photograph of a simulated plant, by forward ray tracing.
//! In: capture. Out: file (JPEG or PNG, with the focal length as EXIF).

use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{self, NamedView};
use crate::optics::{Tank, View};
use crate::roots::Root;
use crate::simulation::{CaptureParams, Scene};
use serde::Serialize;

/// One photograph of a simulated capture.
#[derive(Debug, Clone, Serialize)]
pub struct Photograph {
    /// The tank.
    pub tank: Tank,
    /// Light, lens and noise.
    pub capture: CaptureParams,
    /// Seed of noise and belts.
    pub seed: u64,
    /// Which of the views.
    pub view: usize,
}

impl Stage for Photograph {
    const NAME: &'static str = "photograph";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let capture = inputs.one("capture")?;
        let views: Vec<View> = capture.json::<Vec<NamedView>>("cameras")?.into_iter().map(|v| v.view).collect();
        let roots: Vec<Root> = capture.json("roots")?;
        let scene = Scene::new(&self.tank, &roots, &views, &self.capture, self.seed)?;
        progress.total(self.capture.height as u64);
        let photo = scene.photograph(self.view, &|rows| progress.advance(rows));
        let CaptureParams { format, jpeg_quality, focal_35mm, .. } = self.capture;
        let bytes = formats::photograph::photograph(photo.view(), format, jpeg_quality, focal_35mm)?;
        output.bytes("file", &bytes)
    }
}
