//! Pictures of what a view tells: its background, the share of root, and how sure that is.
//! In: photo (undistorted), camera, background, evidence. Out: background.png, share.png (black = none, white = full),
//! confidence.png (black = no say, white = sure); black where the view does not look into the water.

use super::evidence::{Before, Seen};
use super::read3;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::photo::Picture;
use crate::photo::evidence::share::ZERO;
use serde::Serialize;

/// Names of the pictures, without their ending.
pub const KINDS: [&str; 3] = ["background", "share", "confidence"];

/// The pictures of one view.
#[derive(Debug, Clone, Serialize)]
pub struct EvidencePictures {
    /// Which view, before which background.
    pub before: Before,
}

impl Stage for EvidencePictures {
    const NAME: &'static str = "evidence-pictures";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let Seen { clear, still, .. } = self.before.look(inputs)?;
        let evidence = read3::<u8>(inputs.one("evidence")?, "photo")?;
        let (height, width) = clear.dim();
        let of = |value: &dyn Fn(usize, usize, usize) -> f32| {
            Picture::from_shape_fn((height, width, 3), |(y, x, c)| {
                if clear[[y, x]] { value(y, x, c).round().clamp(0.0, 255.0) as u8 } else { 0 }
            })
        };
        let pictures = [
            of(&|y, x, c| still.background[[y, x, c]]),
            of(&|y, x, _| (f32::from(evidence[[y, x, 0]]) - ZERO) * 255.0 / (255.0 - ZERO)),
            of(&|y, x, _| f32::from(evidence[[y, x, 1]])),
        ];
        for (kind, shown) in KINDS.iter().zip(pictures) {
            output.bytes(&format!("{kind}.png"), &picture::png(shown.view())?)?;
        }
        Ok(())
    }
}
