//! What a pixel knows of roots: their share of it, and how sure that is.
//!
//! The camera stands still and the table turns, so what is behind the roots is known: per pixel the mode of the views
//! ([`room`]), after exposure and white balance are made alike ([`drift`]), for each group of views that see
//! the same still room ([`still`]). Where the room does not stand still, or views are few, the background of a photograph
//! is the median of a window around each pixel ([`window`]). Against either background B, with the roots' colour R
//! learned from the photographs ([`roots`]) and their noise ([`noise`]), a pixel's colour x = a R + (1 - a) B gives
//! the share a of root and its deviation ([`share`]): as in difference matting, a measurement with an error. A pixel where
//! roots and background are alike has no say.
//!
//! Pictures are undistorted photographs, views have their ideal lens. A length at the tank's axis in pixels is
//! `focal_px * length / distance`. Colours are codes 0..255 as encoded: the code's noise hardly depends on its brightness.

pub mod clear;
pub mod drift;
mod fill;
mod median;
mod mode;
pub mod noise;
pub mod room;
pub mod roots;
pub mod share;
mod shorth;
mod smooth;
pub mod still;
#[cfg(test)]
mod tests;
pub mod turn;
pub mod window;

use crate::error::{Error, Result};
use crate::optics::View;
use ndarray::Array3;
use serde::{Deserialize, Serialize};

/// Colours (y, x, rgb) in codes 0..255, with fractions.
pub type Codes = Array3<f32>;

/// Where a photograph's background is taken from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Background {
    /// From the turn where the photographs bear it out, else from the window ([`room`] states the rule).
    #[default]
    Auto,
    /// From the other views of a camera that stands still.
    Turn,
    /// From the surroundings in the same photograph.
    Window,
}

/// `[contrast]`: how roots are told from their background.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContrastParams {
    /// Merge the share of root instead of the photographs' colours. `false` is the paper's way.
    pub enabled: bool,
    /// auto, turn or window.
    pub background: Background,
    /// Edge of the window, mm at the tank's axis, 2..100. Several times the thickest root,
    /// so that no root fills half of it.
    pub window_mm: f64,
    /// Standard deviation of the smoothing, mm at the tank's axis, 0..5; well below the radius of the
    /// thinnest roots (0.25 mm), so that it takes the noise of fine photographs and leaves roots. Coarser
    /// averaging is the rendering's.
    pub blur_mm: f64,
}

impl Default for ContrastParams {
    fn default() -> Self {
        Self { enabled: true, background: Background::Auto, window_mm: 15.0, blur_mm: 0.15 }
    }
}

impl ContrastParams {
    /// Fails where a parameter is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        if !(2.0..=100.0).contains(&self.window_mm) {
            faults.push(
                Error::usage(format!("contrast.window_mm is {}", self.window_mm))
                    .help("give 2 to 100 mm, several times the thickest root"),
            );
        }
        if !(0.0..=5.0).contains(&self.blur_mm) {
            faults.push(
                Error::usage(format!("contrast.blur_mm is {}", self.blur_mm))
                    .help("give 0 to 5 mm, less than the thinnest root's diameter"),
            );
        }
        Error::many(faults)
    }
}

/// Pixels per mm at the tank's axis.
pub fn px_per_mm(view: &View) -> f64 {
    let centre = view.centre_in_tank();
    view.lens.focal_px / centre.x.hypot(centre.y)
}
