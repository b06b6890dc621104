//! Lens distortion undone: the photograph that the ideal lens ([`Lens::ideal`]) of the same focal length and
//! principal axis would have taken.  Paper 2.2.1.
//!
//! Each pixel (u, v) of the result takes the value of the photograph at `lens.pixel(ideal direction)`, by
//! Catmull-Rom bicubic interpolation (a = -1/2), which keeps thin roots sharper than a bilinear one; results
//! are rounded to nearest, clamped to what the photograph's depth can hold. Beyond the photograph its edge is repeated for the interpolation,
//! and pixels that fall more than one pixel outside its outermost centres are black: there is nothing to see.

use super::Depth;
use crate::optics::Lens;
use ndarray::{Array3, ArrayView3, Axis};
use rayon::prelude::*;

/// The photograph without its lens distortion, of the size of the ideal lens's picture; `lens` is the photograph's own.
///
/// The caller checks that the photograph has the lens's size.
pub fn undistort<T: Depth>(photograph: &Array3<T>, lens: &Lens) -> Array3<T> {
    let ideal = lens.ideal();
    let mut out = Array3::from_elem((ideal.height, ideal.width, 3), T::default());
    let source = photograph.as_standard_layout();
    let source = source.view();
    out.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(v, mut row)| {
        let y = (v as f64 - ideal.cy) / ideal.focal_px;
        for (u, mut pixel) in row.axis_iter_mut(Axis(0)).enumerate() {
            let x = (u as f64 - ideal.cx) / ideal.focal_px;
            let (us, vs) = lens.pixel(x, y);
            if let Some(rgb) = bicubic(&source, us, vs) {
                pixel.iter_mut().zip(rgb).for_each(|(to, from)| *to = from);
            }
        }
    });
    out
}

/// Catmull-Rom value at (u, v); `None` more than a pixel outside the picture.
fn bicubic<T: Depth>(picture: &ArrayView3<T>, u: f64, v: f64) -> Option<[T; 3]> {
    let (height, width, _) = picture.dim();
    if !(u >= -1.0 && v >= -1.0 && u <= width as f64 && v <= height as f64) {
        return None;
    }
    let (u0, v0) = (u.floor(), v.floor());
    let (wu, wv) = (weights((u - u0) as f32), weights((v - v0) as f32));
    let (u0, v0) = (u0 as isize - 1, v0 as isize - 1);
    let pixels = picture.as_slice().expect("standard layout");
    let mut sum = [0f32; 3];
    let inside = u0 >= 0 && u0 + 4 <= width as isize;
    for (dv, &wv) in wv.iter().enumerate() {
        let row = (v0 + dv as isize).clamp(0, height as isize - 1) as usize * width;
        let mut line = [0f32; 3];
        if inside {
            let taps = &pixels[3 * (row + u0 as usize)..][..12];
            for c in 0..3 {
                line[c] = (wu[0] * f32::from(taps[c].steps()) + wu[1] * f32::from(taps[c + 3].steps()))
                    + (wu[2] * f32::from(taps[c + 6].steps()) + wu[3] * f32::from(taps[c + 9].steps()));
            }
        } else {
            for (du, &wu) in wu.iter().enumerate() {
                let column = (u0 + du as isize).clamp(0, width as isize - 1) as usize;
                for c in 0..3 {
                    line[c] += wu * f32::from(pixels[3 * (row + column) + c].steps());
                }
            }
        }
        for c in 0..3 {
            sum[c] += wv * line[c];
        }
    }
    Some(sum.map(T::nearest))
}

/// Weights of the four taps around a position `t` (0..1) past the second.
fn weights(t: f32) -> [f32; 4] {
    [
        t * (-0.5 + t * (1.0 - 0.5 * t)),
        1.0 + t * t * (-2.5 + 1.5 * t),
        t * (0.5 + t * (2.0 - 1.5 * t)),
        t * t * (-0.5 + 0.5 * t),
    ]
}

#[cfg(test)]
mod tests {
    use super::super::Picture;
    use super::*;
    use crate::optics::Distortion;

    fn lens(distortion: Distortion) -> Lens {
        Lens { width: 96, height: 64, focal_px: 90.0, cx: 48.2, cy: 31.1, distortion }
    }

    #[test]
    fn an_ideal_lens_changes_nothing() {
        let picture = Picture::from_shape_fn((64, 96, 3), |(y, x, c)| (x * 37 + y * 91 + c * 50) as u8);
        assert_eq!(undistort(&picture, &lens(Distortion::default())), picture);
    }

    #[test]
    fn a_smooth_picture_is_that_of_the_ideal_lens() {
        // Photograph of a pattern that is smooth in the direction, through a distorting lens.
        let bent = lens(Distortion { k1: -0.2, k2: 0.05, p1: 2e-3, p2: -1e-3, k3: 0.0, ..Distortion::default() });
        let pattern = |(x, y): (f64, f64)| (127.5 + 100.0 * (9.0 * x).sin() * (7.0 * y).cos()).round() as u8;
        let photograph = Picture::from_shape_fn((64, 96, 3), |(v, u, _)| pattern(bent.direction(u as f64, v as f64)));
        let out = undistort(&photograph, &bent);
        let ideal = bent.ideal();
        for ((v, u, c), &value) in out.indexed_iter() {
            let (us, vs) = {
                let (x, y) = ideal.direction(u as f64, v as f64);
                bent.pixel(x, y)
            };
            if us > 0.0 && vs > 0.0 && us < 95.0 && vs < 63.0 {
                let want = pattern(ideal.direction(u as f64, v as f64));
                assert!(value.abs_diff(want) <= 2, "({u}, {v}, {c}): {value} instead of {want}");
            }
        }
    }

    #[test]
    fn sixteen_bits_are_those_of_eight_with_finer_steps() {
        let bent = lens(Distortion { k1: -0.2, k2: 0.05, p1: 2e-3, p2: -1e-3, k3: 0.0, ..Distortion::default() });
        let codes = Picture::from_shape_fn((64, 96, 3), |(y, x, c)| (x * 37 + y * 91 + c * 50) as u8);
        let steps = codes.mapv(|code| 257 * u16::from(code));
        let (coarse, fine) = (undistort(&codes, &bent), undistort(&steps, &bent));
        assert!(fine.iter().any(|steps| steps % 257 != 0), "nothing between the codes");
        for (code, steps) in coarse.iter().zip(&fine) {
            assert!((f64::from(*code) - f64::from(*steps) / 257.0).abs() <= 0.5 + 0.51 / 257.0, "{code} {steps}");
        }
        let plain = lens(Distortion::default());
        let deep = steps.mapv(|s| s.wrapping_add(101));
        assert_eq!(undistort(&deep, &plain), deep);
    }

    #[test]
    fn beyond_the_photograph_is_black() {
        let pincushion = lens(Distortion { k1: 0.3, ..Distortion::default() });
        let out = undistort(&Picture::from_elem((64, 96, 3), 200), &pincushion);
        assert_eq!(out[[0, 0, 0]], 0);
        assert_eq!(out[[32, 48, 0]], 200);
    }
}
