//! The share of root in every pixel of a photograph, and how sure it is.
//! In: photo (undistorted), camera, background. Out: photo (y, x, [share, confidence, 0] u8; share 40 = none, 255 = full;
//! confidence 255 = sure, 0 = no say).

use super::background::{room, still};
use super::photographs::undistorted;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View};
use crate::photo::evidence::clear::clear_pixels;
use crate::photo::evidence::drift::Even;
use crate::photo::evidence::{px_per_mm, share::share, window};
use serde::Serialize;

/// The evidence with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Evidence {
    /// The tank between water and camera.
    pub tank: Tank,
    /// Which of the study's views this is, from 0.
    pub view: usize,
    /// Edge of the window, mm at the tank's axis.
    pub window_mm: f64,
    /// Deviation of the smoothing, mm at the tank's axis.
    pub blur_mm: f64,
}

impl Stage for Evidence {
    const NAME: &'static str = "evidence";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let mut codes = undistorted(inputs.one("photo")?)?.codes();
        let view = inputs.one("camera")?.json::<View>("view")?.ideal();
        let behind = inputs.one("background")?;
        let room = room(behind)?;
        let (Some(&gains), Some(&number)) = (room.gains.get(self.view), room.stills.get(self.view)) else {
            return Err(Error::failed(format!("the background knows no view {}", self.view)));
        };
        let clear = clear_pixels(&view, &self.tank);
        let even = Even::new(gains);
        codes.indexed_iter_mut().for_each(|((_, _, c), code)| *code = even.code(c, *code));
        let (background, variance) = match number {
            Some(n) => {
                let still = still(behind, n)?;
                (still.background, still.variance)
            }
            None => {
                let background = window::background(&codes, &clear, self.window_mm * px_per_mm(&view));
                let variance = background.mapv(|code| room.noise.variance(code));
                (background, variance)
            }
        };
        let picture = share(&codes, &clear, &background, &variance, &room.roots, self.blur_mm * px_per_mm(&view));
        output.array("photo", picture.view().into_dyn(), &["y", "x", "c"])
    }
}
