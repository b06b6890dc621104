//! Extracted roots drawn back onto a photograph.  Paper 2.5, figure 7.
//!
//! The tank's region keeps its brightness and everything else is darkened, so that a wrong pose shows;
//! marks are discs with a soft edge that leave the root beneath them visible.

use crate::optics::{Tank, Vec3, View, trace};
use ndarray::{Array3, Axis};
use rayon::prelude::*;
use std::ops::Range;

/// A mark on a photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mark {
    /// Pixel, right.
    pub u: f64,
    /// Pixel, down.
    pub v: f64,
    /// RGB.
    pub colour: [u8; 3],
}

/// How much of the brightness is left outside the tank.
const DARKENED: f32 = 0.35;

/// The undistorted photograph (y, x, rgb) with everything but the tank darkened and the marks drawn
/// with the given radius in px.
pub fn overlay(mut photo: Array3<u8>, view: &View, tank: &Tank, marks: &[Mark], radius_px: f64) -> Array3<u8> {
    let (centre, ideal) = (view.centre_in_tank(), view.ideal());
    let darker: [u8; 256] = std::array::from_fn(|code| (code as f32 * DARKENED) as u8);
    photo.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(y, mut row)| {
        let seen =
            on_tank_columns(row.len_of(Axis(0)), |x| on_tank(tank, &centre, &ideal.ray_in_tank(x as f64, y as f64)));
        for beside in [0..seen.start, seen.end..row.len_of(Axis(0))] {
            row.slice_axis_mut(Axis(0), beside.into()).map_inplace(|code| *code = darker[usize::from(*code)]);
        }
    });
    for mark in marks {
        draw(&mut photo, mark, radius_px);
    }
    photo
}

/// The columns of a row that see the tank. Its outline is convex, so they are one interval, whose ends are found
/// by bisection between every [`STRIDE`]-th column.
fn on_tank_columns(width: usize, sees: impl Fn(usize) -> bool) -> Range<usize> {
    const STRIDE: usize = 8;
    let Some(inside) = (0..width).step_by(STRIDE).find(|&x| sees(x)) else { return 0..0 };
    let last = (inside..width).step_by(STRIDE).take_while(|&x| sees(x)).last().unwrap_or(inside);
    let edge = |mut seen: usize, mut unseen: usize| {
        while seen.abs_diff(unseen) > 1 {
            let middle = usize::midpoint(seen, unseen);
            *(if sees(middle) { &mut seen } else { &mut unseen }) = middle;
        }
        seen
    };
    let from = if inside == 0 { 0 } else { edge(inside, inside - STRIDE) };
    let beyond = (last + STRIDE).min(width);
    from..edge(last, beyond) + 1
}

/// Whether the ray meets the tank's outside: its wall between rim and floor, or the rim's disc.
fn on_tank(tank: &Tank, centre: &Vec3, ray: &Vec3) -> bool {
    let Some((near, _)) = trace::cylinder_hits(centre, ray, tank.radius_mm) else { return false };
    let z = centre.z + near * ray.z;
    if (0.0..=tank.height_mm).contains(&z) {
        return true;
    }
    let end = if z < 0.0 { 0.0 } else { tank.height_mm };
    let t = (end - centre.z) / ray.z;
    t > near && (centre.x + t * ray.x).hypot(centre.y + t * ray.y) <= tank.radius_mm
}

fn draw(picture: &mut Array3<u8>, mark: &Mark, radius_px: f64) {
    let (height, width, _) = picture.dim();
    if !(mark.u.is_finite() && mark.v.is_finite()) {
        return;
    }
    let span = |c: f64, n: usize| {
        let (from, to) = ((c - radius_px - 1.0).ceil().max(0.0), (c + radius_px + 1.0).floor());
        (from as usize)..((to + 1.0).clamp(0.0, n as f64) as usize)
    };
    for y in span(mark.v, height) {
        for x in span(mark.u, width) {
            let distance = (x as f64 - mark.u).hypot(y as f64 - mark.v);
            let cover = (radius_px + 0.5 - distance).clamp(0.0, 1.0) * 0.8;
            for c in 0..3 {
                let old = f64::from(picture[[y, x, c]]);
                picture[[y, x, c]] = (old + (f64::from(mark.colour[c]) - old) * cover).round() as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Distortion, Index, Lens, Mat3};

    #[test]
    fn the_tank_stays_bright_and_marks_are_drawn() {
        let lens =
            Lens { width: 120, height: 90, focal_px: 100.0, cx: 60.0, cy: 45.0, distortion: Distortion::default() };
        // The camera on +x looks along -x at the middle of the tank: x_cam = y, y_cam = z - 60.
        let rotation = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0);
        // Right-handed: flip x so that det = 1.
        let rotation = if rotation.determinant() > 0.0 {
            rotation
        } else {
            Mat3::new(0.0, -1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0)
        };
        let view = View { lens, rotation, translation_mm: Vec3::new(0.0, -60.0, 400.0) };
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 120.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let photo = Array3::from_elem((90, 120, 3), 200);
        let mark = Mark { u: 60.0, v: 45.0, colour: [255, 0, 0] };
        let outside = Mark { u: -50.0, v: 1e9, colour: [255, 0, 0] };
        let picture = overlay(photo, &view, &tank, &[mark, outside], 2.0);
        assert_eq!(picture[[45, 66, 0]], 200, "inside the tank nothing changes");
        assert_eq!(picture[[45, 5, 0]], 70, "outside it is darker");
        let (centre, ideal) = (view.centre_in_tank(), view.ideal());
        for y in 0..90 {
            let sees = |x: usize| on_tank(&tank, &centre, &ideal.ray_in_tank(x as f64, y as f64));
            let slow: Vec<usize> = (0..120).filter(|&x| sees(x)).collect();
            assert_eq!(on_tank_columns(120, sees).collect::<Vec<_>>(), slow, "row {y}");
        }
        assert!(picture[[45, 60, 0]] > 230 && picture[[45, 60, 1]] < 60, "the mark is red");
    }
}
