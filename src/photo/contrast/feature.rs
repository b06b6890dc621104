//! The scalar feature of every pixel: contrast along the roots' colour axis, as a gray photograph.
//!
//! Code 24 is no contrast, 16 codes are one deviation of the photographs' noise: -1.5 to +14.4 deviations are
//! told. The lower limit is deliberate: a place that looks darker than its background (a shadow, a
//! reflection, a background taken too high in dense roots) speaks no more against a root than plain
//! background does.

use super::Contrast;
use super::axis::ColourAxis;
use crate::photo::Picture;

/// Code of a pixel without contrast.
pub const ZERO: f32 = 24.0;
/// Codes per noise deviation.
pub const CODES: f32 = 16.0;

/// The feature as a picture of equal channels; [`ZERO`] where the pixel does not look into the water.
pub fn feature(contrast: &Contrast, axis: &ColourAxis) -> Picture {
    let (height, width, _) = contrast.values.dim();
    let weights = axis.weights.map(|w| w as f32);
    let mut out = Picture::zeros((height, width, 3));
    for ((y, x), &clear) in contrast.clear.indexed_iter() {
        let feature = if clear { (0..3).map(|c| weights[c] * contrast.values[[y, x, c]]).sum::<f32>() } else { 0.0 };
        let code = (ZERO + CODES * feature).round().clamp(0.0, 255.0) as u8;
        for c in 0..3 {
            out[[y, x, c]] = code;
        }
    }
    out
}
