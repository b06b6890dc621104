//! Decodes a photograph and undoes the lens distortion.  Paper 2.2.1.
//! In: photo (file), lens. Out: photo (y, x, rgb u8, sRGB as photographed).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::Lens;
use crate::photo;
use serde::Serialize;

/// The photograph an ideal lens would have taken.
#[derive(Debug, Clone, Serialize)]
pub struct Undistort {}

impl Stage for Undistort {
    const NAME: &'static str = "undistort";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let file = inputs.one("photo")?;
        let name = file.path("file")?.display().to_string();
        let lens: Lens = inputs.one("lens")?.json("lens")?;
        let photograph = photo::decode(&file.bytes("file")?, &name)?;
        let (height, width, _) = photograph.dim();
        if (width, height) != (lens.width, lens.height) {
            return Err(Error::failed(format!(
                "photograph `{name}` has {width} x {height} px, but the cameras are for {} x {} px",
                lens.width, lens.height
            ))
            .help("all photographs of a study come from one camera at one size; do not crop, scale or turn them"));
        }
        output.array("photo", photo::undistort(&photograph, &lens).view().into_dyn(), &["y", "x", "c"])
    }
}
