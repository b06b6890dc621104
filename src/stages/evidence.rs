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
use crate::photo::evidence::room::Room;
use crate::photo::evidence::turn::Still;
use crate::photo::evidence::{Codes, px_per_mm, share::share, window};
use ndarray::Array2;
use serde::Serialize;

/// The evidence with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Evidence {
    /// Which view, before which background.
    pub before: Before,
    /// Deviation of the smoothing, mm at the tank's axis.
    pub blur_mm: f64,
}

/// A view before its background.
#[derive(Debug, Clone, Serialize)]
pub struct Before {
    /// The tank between water and camera.
    pub tank: Tank,
    /// Which of the study's views this is, from 0.
    pub view: usize,
    /// Edge of the window, mm at the tank's axis.
    pub window_mm: f64,
}

/// What is known of a view before its share of root is.
pub(super) struct Seen {
    pub room: Room,
    pub px_per_mm: f64,
    pub clear: Array2<bool>,
    /// Codes without the view's drift.
    pub codes: Codes,
    pub still: Still,
}

impl Before {
    /// Takes the background of the view from `background`, or from the view itself.
    pub(super) fn look(&self, inputs: &Inputs) -> Result<Seen> {
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
        let px_per_mm = px_per_mm(&view);
        let still = match number {
            Some(n) => still(behind, n)?,
            None => {
                let background = window::background(&codes, &clear, self.window_mm * px_per_mm);
                let variance = background.mapv(|code| room.noise.variance(code));
                Still { background, variance }
            }
        };
        Ok(Seen { room, px_per_mm, clear, codes, still })
    }
}

impl Stage for Evidence {
    const NAME: &'static str = "evidence";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let Seen { room, px_per_mm, clear, codes, still } = self.before.look(inputs)?;
        let blur_px = self.blur_mm * px_per_mm;
        let picture = share(&codes, &clear, &still.background, &still.variance, &room.roots, blur_px);
        output.array("photo", picture.view().into_dyn(), &["y", "x", "c"])
    }
}
