//! Grows a root system and stands a camera before its tank: the truth of a simulated capture.
//! In: nothing. Out: cameras, roots (JSON).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::optics::{Tank, View, turn_about_z};
use crate::simulation::{AgeParams, CaptureParams, GrowthParams, PictureFormat, aged, capture, grow};
use serde::{Deserialize, Serialize};

/// The day of a capture: the same plant in the same tank is put before the camera anew.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DayParams {
    /// By how much the tank is turned when it is put on the table, degrees.
    pub start_deg: f64,
    /// Seed of how it is put there, of the turns, the room and the noise; that of the plant when absent.
    pub seed: Option<u64>,
}

/// Plant, tank and cameras of a simulated capture.
#[derive(Debug, Clone, Serialize)]
pub struct Capture {
    /// The tank the plant grows in.
    pub tank: Tank,
    /// How the roots grow.
    pub growth: GrowthParams,
    /// How old the plant is.
    pub age: AgeParams,
    /// How the tank was put before the camera.
    pub day: DayParams,
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
    const VERSION: u32 = 4;

    fn run(&self, _: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let roots = aged(grow(&self.growth, &self.tank, self.seed)?, &self.age, self.seed);
        if roots.is_empty() {
            return Err(Error::usage("no root has set out yet").help("raise simulate.age.days"));
        }
        let start = turn_about_z(self.day.start_deg.to_radians());
        let views: Vec<NamedView> = capture(&self.capture, &self.tank, self.day.seed.unwrap_or(self.seed))?
            .into_iter()
            .map(|view| View { rotation: view.rotation * start, ..view })
            .enumerate()
            .map(|(n, view)| NamedView { file: format!("images/{}", photo_name(&self.capture, n)), view })
            .collect();
        output.json("cameras", &views)?;
        output.json("roots", &roots)
    }
}
