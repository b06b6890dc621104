//! The lens: one focal length, square pixels, principal point, and the radial and tangential
//! distortion of OpenCV (k1, k2, p1, p2, k3).  Paper 2.2.1.
//!
//! With `x = X/Z`, `y = Y/Z`, `r² = x² + y²` and `radial = 1 + k1 r² + k2 r⁴ + k3 r⁶`:
//!
//! ```text
//! x' = x radial + 2 p1 x y + p2 (r² + 2x²)        u = f x' + cx
//! y' = y radial + p1 (r² + 2y²) + 2 p2 x y        v = f y' + cy
//! ```
//!
//! The centre of the top-left pixel is `(u, v) = (0, 0)`.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Distortion coefficients in OpenCV's order of meaning; all zero for an ideal lens.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Distortion {
    /// Radial, r².
    pub k1: f64,
    /// Radial, r⁴.
    pub k2: f64,
    /// Tangential.
    pub p1: f64,
    /// Tangential.
    pub p2: f64,
    /// Radial, r⁶.
    pub k3: f64,
}

/// A camera's intrinsic parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Lens {
    /// Picture width, px.
    pub width: usize,
    /// Picture height, px.
    pub height: usize,
    /// Focal length, px.
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

impl Lens {
    /// Fails where a number is not finite, the focal length not positive or the picture empty.
    ///
    /// # Errors
    /// Names the offending number.
    pub fn check(&self) -> Result<()> {
        let d = &self.distortion;
        for (name, value) in [
            ("f", self.focal_px),
            ("cx", self.cx),
            ("cy", self.cy),
            ("k1", d.k1),
            ("k2", d.k2),
            ("p1", d.p1),
            ("p2", d.p2),
            ("k3", d.k3),
        ] {
            if !value.is_finite() {
                return Err(Error::failed(format!("lens: `{name}` is {value}")).help("give a finite number"));
            }
        }
        if self.focal_px <= 0.0 {
            return Err(Error::failed(format!("lens: focal length `f` is {} px", self.focal_px))
                .help("it is given in pixels and positive"));
        }
        if self.width == 0 || self.height == 0 {
            return Err(Error::failed(format!("lens: picture of {} x {} px", self.width, self.height)));
        }
        Ok(())
    }

    /// The same lens without distortion: that of the undistorted photographs.
    pub fn ideal(&self) -> Self {
        Self { distortion: Distortion::default(), ..*self }
    }

    /// Pixel of the normalised direction `(x, y) = (X/Z, Y/Z)`, through the distortion.
    pub fn pixel(&self, x: f64, y: f64) -> (f64, f64) {
        let (xd, yd) = self.distort(x, y);
        (self.focal_px * xd + self.cx, self.focal_px * yd + self.cy)
    }

    /// Normalised direction `(X/Z, Y/Z)` of a pixel, with the distortion undone (Newton; 1e-12).
    pub fn direction(&self, u: f64, v: f64) -> (f64, f64) {
        let (xd, yd) = ((u - self.cx) / self.focal_px, (v - self.cy) / self.focal_px);
        let (mut x, mut y) = (xd, yd);
        for _ in 0..20 {
            let (fx, fy) = self.distort(x, y);
            let (ex, ey) = (fx - xd, fy - yd);
            if ex.abs().max(ey.abs()) < 1e-13 {
                break;
            }
            let [a, b, c, d] = self.distort_jacobian(x, y);
            let det = a * d - b * c;
            x -= (d * ex - b * ey) / det;
            y -= (a * ey - c * ex) / det;
        }
        (x, y)
    }

    fn distort(&self, x: f64, y: f64) -> (f64, f64) {
        let Distortion { k1, k2, p1, p2, k3 } = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y,
        )
    }

    /// `[∂x'/∂x, ∂x'/∂y, ∂y'/∂x, ∂y'/∂y]`.
    fn distort_jacobian(&self, x: f64, y: f64) -> [f64; 4] {
        let Distortion { k1, k2, p1, p2, k3 } = self.distortion;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
        let slope = 2.0 * (k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3));
        let cross = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        [
            radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x,
            cross,
            cross,
            radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn direction_undoes_pixel() {
        let lens = Lens {
            width: 968,
            height: 648,
            focal_px: 984.0,
            cx: 488.2,
            cy: 320.1,
            distortion: Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.01 },
        };
        for (u, v) in [(0.0, 0.0), (967.0, 647.0), (488.2, 320.1), (100.5, 600.25)] {
            let (x, y) = lens.direction(u, v);
            let (u2, v2) = lens.pixel(x, y);
            assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9, "{u} {v} -> {u2} {v2}");
        }
    }

    #[test]
    fn lens_with_nan_is_refused() {
        let lens =
            Lens { width: 10, height: 10, focal_px: f64::NAN, cx: 0.0, cy: 0.0, distortion: Distortion::default() };
        assert!(lens.check().unwrap_err().message.contains("`f`"));
    }
}
