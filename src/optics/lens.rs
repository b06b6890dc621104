//! The lens: focal length, principal point, and how it departs from a pinhole with square pixels ([`Distortion`]).
//! Paper 2.2.1.
//!
//! The centre of the top-left pixel is `(u, v) = (0, 0)`.

use super::distortion::{Bent, Distortion, Model};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// A camera's intrinsic parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Picture width, px.
    pub width: usize,
    /// Picture height, px.
    pub height: usize,
    /// Focal length, px; the vertical one where the distortion's `b1` is not 0.
    #[serde(rename = "f")]
    pub focal_px: f64,
    /// Principal point, px from the centre of the top-left pixel.
    pub cx: f64,
    /// Principal point, px from the centre of the top-left pixel.
    pub cy: f64,
    /// Distortion.
    #[serde(flatten)]
    pub distortion: Distortion,
}

/// A pixel with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelSlopes {
    /// (u, v).
    pub pixel: [f64; 2],
    /// `[∂u/∂x, ∂u/∂y, ∂v/∂x, ∂v/∂y]` for the direction `(x, y, 1)`.
    pub by_direction: [f64; 4],
    /// Derivatives of u by f, cx, cy, k1, k2, p1, p2, k3.
    pub u_by: [f64; 8],
    /// Derivatives of v by them.
    pub v_by: [f64; 8],
}

/// Tangent of the angle from the axis, left, right, up and down, beyond which an ideal lens shows nothing of a fisheye's
/// picture (60 degrees): a pinhole's picture of it would have no end.
const WIDEST: f64 = 1.75;

impl Lens {
    /// Fails where a number is not finite, a focal length not positive or the picture empty.
    ///
    /// # Errors
    /// Names the offending number.
    pub fn check(&self) -> Result<()> {
        let own = [("f", self.focal_px), ("cx", self.cx), ("cy", self.cy)];
        for (name, value) in own.into_iter().chain(self.distortion.named()) {
            if !value.is_finite() {
                return Err(Error::failed(format!("lens: `{name}` is {value}")).help("give a finite number"));
            }
        }
        let (fx, fy) = (self.focal_px + self.distortion.b1, self.focal_px);
        if fx <= 0.0 || fy <= 0.0 {
            let value = if fx == fy { format!("`f` is {fy} px") } else { format!("{fx} x {fy} px") };
            return Err(Error::failed(format!("lens: focal length {value}")).help("it is given in pixels and positive"));
        }
        if self.width == 0 || self.height == 0 {
            return Err(Error::failed(format!("lens: picture of {} x {} px", self.width, self.height)));
        }
        Ok(())
    }

    /// The same lens without distortion: that of the undistorted photographs. Its picture is as large; that of a fisheye
    /// is larger, so that it holds the whole photograph, up to 60 degrees from the axis.
    pub fn ideal(&self) -> Self {
        let plain = Self { distortion: Distortion::default(), ..*self };
        if self.distortion.model == Model::Brown {
            return plain;
        }
        let (right, below) = (self.width as f64 - 1.0, self.height as f64 - 1.0);
        let mut span = [[0.0, right], [0.0, below]];
        let steps = 64;
        for i in 0..=steps {
            let part = f64::from(i) / f64::from(steps);
            for (u, v) in [(part * right, 0.0), (part * right, below), (0.0, part * below), (right, part * below)] {
                let (x, y) = self.direction(u, v);
                let seen = plain.pixel(x.clamp(-WIDEST, WIDEST), y.clamp(-WIDEST, WIDEST));
                for (span, at) in span.iter_mut().zip([seen.0, seen.1]) {
                    *span = [span[0].min(at.floor()), span[1].max(at.ceil())];
                }
            }
        }
        let size = |span: [f64; 2]| (span[1] - span[0]) as usize + 1;
        let [across, down] = span;
        Self { width: size(across), height: size(down), cx: plain.cx - across[0], cy: plain.cy - down[0], ..plain }
    }

    /// Pixel of the normalised direction `(x, y) = (X/Z, Y/Z)`, through the distortion.
    pub fn pixel(&self, x: f64, y: f64) -> (f64, f64) {
        let (xd, yd) = self.distortion.bend(x, y);
        let (fx, skew) = (self.focal_px + self.distortion.b1, self.distortion.b2);
        (fx * xd + skew * yd + self.cx, self.focal_px * yd + self.cy)
    }

    /// [`pixel`](Self::pixel) with its derivatives.
    pub fn pixel_with_derivatives(&self, x: f64, y: f64) -> PixelSlopes {
        let Bent { place: [xd, yd], by_direction: [a, b, c, d], x_by, y_by } =
            self.distortion.bend_with_derivatives(x, y);
        let (fx, fy, skew) = (self.focal_px + self.distortion.b1, self.focal_px, self.distortion.b2);
        let coefficient = |k: usize| (fx * x_by[k] + skew * y_by[k], fy * y_by[k]);
        let by = [
            (xd, yd),
            (1.0, 0.0),
            (0.0, 1.0),
            coefficient(0),
            coefficient(1),
            coefficient(2),
            coefficient(3),
            coefficient(4),
        ];
        PixelSlopes {
            pixel: [fx * xd + skew * yd + self.cx, fy * yd + self.cy],
            by_direction: [fx * a + skew * c, fx * b + skew * d, fy * c, fy * d],
            u_by: by.map(|(u, _)| u),
            v_by: by.map(|(_, v)| v),
        }
    }

    /// Normalised direction `(X/Z, Y/Z)` of a pixel, with the distortion undone ([`Distortion::unbend`]).
    pub fn direction(&self, u: f64, v: f64) -> (f64, f64) {
        let yd = (v - self.cy) / self.focal_px;
        let xd = (u - self.cx - self.distortion.b2 * yd) / (self.focal_px + self.distortion.b1);
        self.distortion.unbend(xd, yd)
    }

    /// [`direction`](Self::direction) with `[∂x/∂u, ∂x/∂v, ∂y/∂u, ∂y/∂v]`.
    pub fn direction_with_derivatives(&self, u: f64, v: f64) -> ((f64, f64), [f64; 4]) {
        let (x, y) = self.direction(u, v);
        let [a, b, c, d] = self.pixel_with_derivatives(x, y).by_direction;
        let det = a * d - b * c;
        ((x, y), [d / det, -b / det, -c / det, a / det])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lens(distortion: Distortion) -> Lens {
        Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.2, cy: 320.1, distortion }
    }

    fn all() -> [Lens; 2] {
        let brown = Distortion {
            k1: -0.09,
            k2: 0.05,
            p1: 4e-4,
            p2: -3e-4,
            k3: 0.01,
            b1: 20.0,
            b2: -3.0,
            ..Distortion::default()
        };
        let fisheye =
            Distortion { model: Model::Fisheye, k1: 0.03, k2: -0.01, b1: -5.0, b2: 2.0, ..Distortion::default() };
        [lens(brown), lens(fisheye)]
    }

    #[test]
    fn direction_undoes_pixel() {
        for lens in all() {
            for (u, v) in [(0.0, 0.0), (967.0, 647.0), (488.2, 320.1), (100.5, 600.25)] {
                let (x, y) = lens.direction(u, v);
                let (u2, v2) = lens.pixel(x, y);
                assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9, "{u} {v} -> {u2} {v2}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let h = 1e-4;
        for lens in all() {
            let ((x, y), by_pixel) = lens.direction_with_derivatives(120.0, 500.0);
            let slope = |a: (f64, f64), b: (f64, f64)| [(a.0 - b.0) / (2.0 * h), (a.1 - b.1) / (2.0 * h)];
            let by_u = slope(lens.direction(120.0 + h, 500.0), lens.direction(120.0 - h, 500.0));
            let by_v = slope(lens.direction(120.0, 500.0 + h), lens.direction(120.0, 500.0 - h));
            for (found, want) in by_pixel.into_iter().zip([by_u[0], by_v[0], by_u[1], by_v[1]]) {
                assert!((found - want).abs() < 1e-8, "{found} {want}");
            }
            let slopes = lens.pixel_with_derivatives(x, y);
            let moved = |k: usize, by: f64| {
                let mut l = lens;
                let d = &mut l.distortion;
                *[&mut l.focal_px, &mut l.cx, &mut l.cy, &mut d.k1, &mut d.k2, &mut d.p1, &mut d.p2, &mut d.k3][k] +=
                    by;
                l.pixel(x, y)
            };
            for k in 0..8 {
                let want = slope(moved(k, h), moved(k, -h));
                let (u, v) = (slopes.u_by[k], slopes.v_by[k]);
                assert!((u - want[0]).abs() < 1e-6 && (v - want[1]).abs() < 1e-6, "{k}: {u} {v} {want:?}");
            }
        }
    }

    #[test]
    fn the_ideal_picture_of_a_fisheye_holds_its_photograph() {
        let [brown, fisheye] = all();
        let plain = brown.ideal();
        assert_eq!((plain.width, plain.height, plain.cx), (968, 648, 488.2));
        let ideal = fisheye.ideal();
        for (u, v) in [(0.0, 0.0), (967.0, 0.0), (0.0, 647.0), (967.0, 647.0), (480.0, 0.0)] {
            let (x, y) = fisheye.direction(u, v);
            let (u, v) = ideal.pixel(x, y);
            assert!(u >= 0.0 && v >= 0.0 && u <= ideal.width as f64 && v <= ideal.height as f64, "{ideal:?} {u} {v}");
        }
        // A whole hemisphere ends at 60 degrees.
        let hemisphere = Lens { focal_px: 300.0, ..fisheye }.ideal();
        assert!((1040..=1060).contains(&hemisphere.width), "{hemisphere:?}");
    }

    #[test]
    fn lens_with_impossible_numbers_is_refused() {
        let bad = |change: fn(&mut Lens)| {
            let mut lens = lens(Distortion::default());
            change(&mut lens);
            lens.check().unwrap_err().message
        };
        assert!(bad(|l| l.focal_px = f64::NAN).contains("`f`"));
        assert!(bad(|l| l.distortion.s[1] = f64::INFINITY).contains("`s2`"));
        assert!(bad(|l| l.distortion.b1 = -2000.0).contains("focal length -1016"));
        assert!(bad(|l| l.width = 0).contains("0 x 648"));
    }
}
