//! Decodes a photograph, turns it upright and undoes the lens distortion.  Paper 2.2.1.
//! In: photo (file), camera. Out: photo (y, x, rgb, sRGB as photographed; u8, or u16 where the photograph has more than 8
//! bits).

use super::photographs::check_size;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::View;
use crate::photo::{self, Photograph, undistort};
use serde::Serialize;

/// The photograph an ideal lens would have taken.
#[derive(Debug, Clone, Serialize)]
pub struct Undistort {}

impl Stage for Undistort {
    const NAME: &'static str = "undistort";
    const VERSION: u32 = 3;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let file = inputs.one("photo")?;
        let name = file.path("file")?.display().to_string();
        let lens = inputs.one("camera")?.json::<View>("view")?.lens;
        let bytes = file.bytes("file")?;
        let photograph = photo::decode(&bytes, &name)?;
        check_size(&name, &bytes, &photograph, &lens)?;
        let axes = ["y", "x", "c"];
        match photograph {
            Photograph::Eight(codes) => output.array("photo", undistort(&codes, &lens).view().into_dyn(), &axes),
            Photograph::Sixteen(steps) => output.array("photo", undistort(&steps, &lens).view().into_dyn(), &axes),
        }
    }
}
