//! Takes a photograph's background away.
//! In: photo (undistorted), camera. Out: contrast (y, x, rgb i16, sixteenths of a code), clear (y, x, u8, 1 =
//! looks into the water), samples (n, rgb f32, codes).

use super::photographs::undistorted;
use super::three;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View};
use crate::photo::contrast::axis::samples;
use crate::photo::contrast::{Contrast as Pixels, ContrastParams, contrast};
use crate::store::Artefact;
use ndarray::Array2;
use serde::Serialize;

/// The contrast with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Contrast {
    /// The tank between water and camera.
    pub tank: Tank,
    /// Window and smoothing.
    #[serde(flatten)]
    pub params: ContrastParams,
}

/// Stored steps per code.
const STEPS: f32 = 16.0;

impl Stage for Contrast {
    const NAME: &'static str = "contrast";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let photo = undistorted(inputs.one("photo")?)?;
        let view: View = inputs.one("camera")?.json("view")?;
        let pixels = contrast(&photo, &view, &self.tank, &self.params)?;
        let stored = pixels.values.mapv(|v| (v * STEPS).round() as i16);
        output.array("contrast", stored.view().into_dyn(), &["y", "x", "c"])?;
        output.array("clear", pixels.clear.mapv(u8::from).view().into_dyn(), &["y", "x"])?;
        output.array("samples", Array2::from(samples(&pixels)).view().into_dyn(), &["n", "c"])
    }
}

/// Reads what [`Contrast`] wrote.
pub(crate) fn read(artefact: &Artefact) -> Result<Pixels> {
    let values = three(artefact.array::<i16>("contrast")?.read()?)?.mapv(|v| f32::from(v) / STEPS);
    let (height, width, _) = values.dim();
    let clear = artefact.array::<u8>("clear")?.read()?;
    let clear = Array2::from_shape_fn((height, width), |(y, x)| clear[[y, x]] != 0);
    Ok(Pixels { values, clear })
}
