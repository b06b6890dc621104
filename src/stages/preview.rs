//! A photograph small enough to stand in the report. In: photo (undistorted). Out: preview.jpg.

use super::photographs::picture;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::photo::shrink::shrink;
use serde::Serialize;

/// One small photograph.
#[derive(Debug, Clone, Serialize)]
pub struct Preview {
    /// Its longer side at most, px.
    pub longest_px: usize,
}

/// JPEG quality: all photographs together have to fit into one page.
const QUALITY: u8 = 75;

impl Stage for Preview {
    const NAME: &'static str = "preview";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let photo = picture(inputs.one("photo")?)?;
        output.bytes("preview.jpg", &picture::jpeg(shrink(photo, self.longest_px)?.view(), QUALITY)?)
    }
}
