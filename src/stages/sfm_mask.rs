//! Finds the printed belts in what changes from photograph to photograph.  Paper 2.2.1.
//! In: photos (files), given (at most one file: a mask by hand). Out: mask (y, x; 255 where features may be taken), mask.png, deviation.png (spread over the photographs).

use super::photographs::{check_one_size, decoded};
use crate::calibration::masks::{MaskParams, Spread, belts};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::photo;
use crate::store::Artefact;
use ndarray::{Array2, ArrayView2, Axis, stack};
use serde::Serialize;

/// The mask for structure from motion.
#[derive(Debug, Clone, Serialize)]
pub struct SfmMask {
    /// How belts are told from the rest.
    pub params: MaskParams,
}

impl Stage for SfmMask {
    const NAME: &'static str = "sfm-mask";
    const VERSION: u32 = 3;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let photos = inputs.many("photos");
        progress.total(photos.len() as u64);
        let mut spread: Option<Spread> = None;
        let mut sizes = Vec::new();
        for file in photos {
            progress.check()?;
            let gray = photo::gray(&decoded(file)?.into_picture());
            let (h, w) = gray.dim();
            sizes.push((file.path("file")?.display().to_string(), (w, h)));
            // All that differ are named below.
            if (w, h) == sizes[0].1 {
                spread.get_or_insert_with(|| Spread::new(h, w)).add(gray.view())?;
            }
            progress.advance(1);
        }
        check_one_size(&sizes)?;
        let deviation = spread.ok_or_else(|| Error::failed("there are no photographs"))?.deviation();
        // Twice the spread, so that a random print of full contrast is white.
        let shown = deviation.mapv(|d| (2.0 * d).min(255.0) as u8);
        output.bytes("deviation.png", &rgb_png(shown.view())?)?;
        let mask = match inputs.many("given") {
            [] => belts(deviation.view(), &self.params)?,
            [file, ..] => given(file, deviation.dim())?,
        };
        let mask = mask.mapv(|m| if m { 255_u8 } else { 0 });
        output.bytes("mask.png", &rgb_png(mask.view())?)?;
        output.array("mask", mask.view().into_dyn(), &["y", "x"])
    }

    fn peak_bytes(&self) -> u64 {
        1 << 30
    }
}

/// The mask that a picture shows: what is lighter than middle gray.
fn given(file: &Artefact, size: (usize, usize)) -> Result<Array2<bool>> {
    let name = file.path("file")?.display().to_string();
    let mask = photo::gray(&decoded(file)?.into_picture()).mapv(|x| x > 127);
    let ((h, w), (height, width)) = (mask.dim(), size);
    if mask.dim() != size {
        return Err(Error::failed(format!("the mask `{name}` has {w} x {h} px, the photographs {width} x {height}"))
            .help("give photos.mask the size of the photographs"));
    }
    if !mask.iter().any(|m| *m) {
        return Err(Error::failed(format!("the mask `{name}` hides all of the photographs"))
            .help("the printed belts must be white in it"));
    }
    Ok(mask)
}

fn rgb_png(gray: ArrayView2<u8>) -> Result<Vec<u8>> {
    let gray: Array2<u8> = gray.to_owned();
    let rgb = stack(Axis(2), &[gray.view(), gray.view(), gray.view()])
        .map_err(|e| Error::failed(format!("cannot write a mask: {e}")))?;
    picture::png(rgb.view())
}
