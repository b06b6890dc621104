//! The tank's height in the photographs: rim and floor, where their print ends.

use super::adjust::Ring;
use super::outline::{self, OutlineParams};
use super::similarity::Similarity;
use super::sparse::SparseModel;
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
    ends: &[Ring; 2],
    start: Similarity,
    params: &OutlineParams,
) -> (Similarity, Option<f64>) {
    let mut start = start;
    let mut seen_height = None;
    // Twice: the second look is taken from the right height.
    for _ in 0..2 {
        let views = start.views(model);
        let seen = |ring: &Ring| {
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

/// Warns where the height that the photographs show disagrees with the tank's.
pub(super) fn check_height(tank: &Tank, seen_mm: Option<f64>, extent_mm: [f64; 2], warnings: &mut Vec<String>) {
    let extent = extent_mm[1] - extent_mm[0];
    if let Some(seen) = seen_mm.filter(|s| (s / tank.height_mm - 1.0).abs() > 0.015) {
        warnings.push(format!(
            "with a radius of {} mm the photographs show rim and floor {seen:.1} mm apart, but tank.height is {} mm: \
             one of the two is wrong, and all lengths of the result with it",
            tank.radius_mm, tank.height_mm
        ));
    } else if extent > 1.03 * tank.height_mm {
        warnings.push(format!(
            "with a radius of {} mm the belts' points reach over {extent:.1} mm, more than tank.height ({} mm): \
             one of the two is wrong, and all lengths of the result with it",
            tank.radius_mm, tank.height_mm
        ));
    }
}
