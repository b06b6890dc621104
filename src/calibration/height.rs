//! The tank's height in the photographs: rim and floor, where their print ends.

use super::adjust::Contour;
use super::outline::{self, OutlineParams};
use super::similarity::Similarity;
use super::sparse::SparseModel;
use crate::error::{Error, Result};
use crate::math::robust::median;
use crate::optics::Tank;
use ndarray::ArrayView2;

/// Part of the tank's height within which rim and floor are looked for first.
const WIDE: f64 = 0.08;

/// Moves the start along the axis so that the middle of rim and floor, as seen, lies at half the tank's
/// height; also the distance between them, mm.
pub(super) fn lay_height(
    model: &SparseModel,
    photos: &[ArrayView2<u8>],
    tank: &Tank,
    ends: &[Contour; 2],
    start: Similarity,
    params: &OutlineParams,
) -> (Similarity, Option<f64>) {
    let mut start = start;
    let mut seen_height = None;
    // A median of many coarse places bears weaker steps, such as those against a mottled table.
    let params = &OutlineParams { min_rise: params.min_rise.min(2.0), ..params.clone() };
    // Twice: the second look is taken from the right height.
    for _ in 0..2 {
        let views = start.views(model);
        let seen = |ring: &Contour| {
            let mut heights: Vec<f64> = Vec::new();
            for (k, (photo, view)) in photos.iter().zip(&views).enumerate() {
                let points = outline::measure(photo.view(), view, k, ring, 0, WIDE * tank.height_mm, params);
                heights.extend(points.iter().filter_map(|p| outline::height_mm(view, ring, p)));
            }
            (heights.len() >= photos.len()).then(|| median(&mut heights))
        };
        let (rim, floor) = (seen(&ends[0]), seen(&ends[1]));
        start.translation_mm.z -= match (rim, floor) {
            (Some(rim), Some(floor)) => {
                seen_height = Some(floor - rim);
                0.5 * (rim + floor - tank.height_mm)
            }
            (Some(rim), None) => rim,
            (None, Some(floor)) => floor - tank.height_mm,
            (None, None) => return (start, None),
        };
    }
    (start, seen_height)
}

/// Holds the height that the photographs show against the tank's: warns where they disagree by more than a wrong lens of
/// structure from motion does, a hundredth or so.
///
/// # Errors
/// Where they disagree by a twentieth or more: a size was misread, and nothing that follows could be right.
pub(super) fn check_height(
    tank: &Tank,
    seen_mm: Option<f64>,
    extent_mm: [f64; 2],
    warnings: &mut Vec<String>,
) -> Result<()> {
    let extent = extent_mm[1] - extent_mm[0];
    let (what, shown) = match seen_mm {
        Some(seen) => ("rim and floor", seen),
        // The belts may be lower than the tank, but not higher.
        None if extent > 1.015 * tank.height_mm => ("the ends of the belts", extent),
        None => return Ok(()),
    };
    let apart = (shown / tank.height_mm - 1.0).abs();
    let said = format!(
        "with tank.radius {} mm the photographs show {what} {shown:.1} mm apart, but tank.height is {} mm",
        tank.radius_mm, tank.height_mm
    );
    let cause = "one of the two is wrong, and all lengths of the result with it";
    if apart >= 0.05 {
        return Err(Error::failed(format!("{said}: {cause}")).help(format!(
            "measure the tank again: outer radius (half the diameter) and height; {:.1} mm of radius would fit this height",
            tank.radius_mm * tank.height_mm / shown
        )));
    }
    if apart > 0.015 {
        warnings.push(format!("{said}: {cause}"));
    }
    Ok(())
}
