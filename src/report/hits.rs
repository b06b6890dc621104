//! Truth and reconstruction in one picture: side view, front view and top view, orthographic.
//!
//! What was found of the truth is light grey, what was missed red, what was found but is not there blue: told apart
//! also by readers who do not see red against green. The inner wall is outlined; later kinds lie over earlier ones.

use crate::evaluation::Hits;
use crate::optics::Tank;
use ndarray::Array3;

/// True and found.
pub const HIT: [u8; 3] = [200, 200, 200];
/// True and missed.
pub const MISSED: [u8; 3] = [255, 80, 50];
/// Found and not true.
pub const SPURIOUS: [u8; 3] = [70, 160, 255];
const GROUND: [u8; 3] = [18, 20, 24];
const OUTLINE: [u8; 3] = [70, 75, 85];
const MARGIN_MM: f64 = 4.0;

/// Draws (x, z), (y, z) and (x, y) side by side at that scale, px per mm: a picture (y, x, rgb).
pub fn hits_picture(hits: &Hits, tank: &Tank, px_per_mm: f64) -> Array3<u8> {
    let radius = tank.inner_radius_mm();
    let panel_mm = 2.0 * (radius + MARGIN_MM);
    let height_mm = (tank.height_mm + 2.0 * MARGIN_MM).max(panel_mm);
    let size = |mm: f64| (mm * px_per_mm).ceil().max(1.0) as usize;
    let mut picture = Array3::from_shape_fn((size(height_mm), size(3.0 * panel_mm), 3), |(_, _, c)| GROUND[c]);
    let mut dot = |x_mm: f64, y_mm: f64, colour: [u8; 3]| {
        let (x, y) = ((x_mm * px_per_mm).round(), (y_mm * px_per_mm).round());
        if x >= 0.0 && y >= 0.0 {
            for (c, value) in colour.into_iter().enumerate() {
                if let Some(pixel) = picture.get_mut((y as usize, x as usize, c)) {
                    *pixel = value;
                }
            }
        }
    };
    let middle = |panel: usize| panel_mm * (panel as f64 + 0.5);
    // Outlines: walls and floor in the side views, the inner circle in the top view.
    let steps = (4.0 * height_mm.max(panel_mm) * px_per_mm).ceil() as usize;
    for i in 0..=steps {
        let f = i as f64 / steps as f64;
        for panel in 0..2 {
            let z = MARGIN_MM + f * tank.floor_mm();
            dot(middle(panel) - radius, z, OUTLINE);
            dot(middle(panel) + radius, z, OUTLINE);
            dot(middle(panel) + (2.0 * f - 1.0) * radius, MARGIN_MM + tank.floor_mm(), OUTLINE);
        }
        let angle = f * std::f64::consts::TAU;
        dot(middle(2) + radius * angle.cos(), panel_mm / 2.0 + radius * angle.sin(), OUTLINE);
    }
    // Faults are few and often single voxels: marks of 3 x 3 px.
    for (points, colour, reach) in [(&hits.hit, HIT, 0), (&hits.missed, MISSED, 1), (&hits.spurious, SPURIOUS, 1)] {
        for [x, y, z] in points {
            for step in 0..(2 * reach + 1) * (2 * reach + 1) {
                let shift = |k: i32| f64::from(k - reach) / px_per_mm;
                let (dx, dy) = (shift(step % (2 * reach + 1)), shift(step / (2 * reach + 1)));
                dot(middle(0) + x + dx, MARGIN_MM + z + dy, colour);
                dot(middle(1) + y + dx, MARGIN_MM + z + dy, colour);
                dot(middle(2) + x + dx, panel_mm / 2.0 + y + dy, colour);
            }
        }
    }
    picture
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    #[test]
    fn each_kind_has_its_colour_in_all_three_views() {
        let tank = Tank {
            radius_mm: 20.0,
            height_mm: 50.0,
            wall_mm: 2.0,
            water_level_mm: 5.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let hits = Hits {
            hit: vec![[0.0, 0.0, 10.0]],
            missed: vec![[5.0, 0.0, 20.0]],
            spurious: vec![[0.0, 5.0, 30.0], [1e6, 1e6, 1e6]],
        };
        let picture = hits_picture(&hits, &tank, 2.0);
        assert_eq!(picture.dim(), (116, 264, 3));
        for (colour, wanted) in [(HIT, 3), (MISSED, 27), (SPURIOUS, 27)] {
            let count = picture.rows().into_iter().filter(|p| p.iter().eq(colour.iter())).count();
            assert_eq!(count, wanted);
        }
    }
}
