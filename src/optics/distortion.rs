//! How a lens departs from a pinhole with square pixels: the models of OpenCV, COLMAP and Metashape as one formula.
//! Paper 2.2.1 has its first five coefficients.
//!
//! With `x = X/Z`, `y = Y/Z` for an ordinary lens, or `(x, y) = (X, Y)/Z · θ/tan θ` for a fisheye (θ is the angle from the
//! optical axis: equidistant), and `r² = x² + y²`:
//!
//! ```text
//! radial = (1 + k1 r² + k2 r⁴ + k3 r⁶ + r8 r⁸) / (1 + k4 r² + k5 r⁴ + k6 r⁶)
//! x' = x radial + 2 p1 x y + p2 (r² + 2x²) + s1 r² + s2 r⁴
//! y' = y radial + p1 (r² + 2y²) + 2 p2 x y + s3 r² + s4 r⁴
//! u = (f + b1) x' + b2 y' + cx
//! v = f y' + cy
//! ```
//!
//! | elsewhere | here |
//! |---|---|
//! | OpenCV `calib3d`: k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 | the same; fx = f + b1, fy = f, skew = b2 |
//! | OpenCV `fisheye` (Kannala-Brandt): k1, k2, k3, k4 | `model = "fisheye"`, k1, k2, k3, and k4 as r8 |
//! | COLMAP `THIN_PRISM_FISHEYE` | the same with p1, p2, and sx1, sy1 as s1, s3 |
//! | Metashape: k1 to k4, p1, p2, b1, b2 | k4 as r8, p1 and p2 exchanged |

use serde::{Deserialize, Serialize};

/// From where the coefficients count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Model {
    /// An ordinary lens: tangents of the angle from the axis.
    #[default]
    Brown,
    /// Equidistant: the angle itself.
    Fisheye,
}

/// Coefficients of a lens; all zero for an ideal one.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Distortion {
    /// From where they count.
    pub model: Model,
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
    /// Radial, r⁸.
    pub r8: f64,
    /// Radial, r², below the line.
    pub k4: f64,
    /// Radial, r⁴, below the line.
    pub k5: f64,
    /// Radial, r⁶, below the line.
    pub k6: f64,
    /// Thin prism: x by r², x by r⁴, y by r², y by r⁴.
    pub s: [f64; 4],
    /// Affinity: by how much the horizontal focal length exceeds the vertical one, px.
    pub b1: f64,
    /// Skew, px.
    pub b2: f64,
}

/// The place that a direction is moved to, in units of the focal length, with its derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bent {
    /// (x', y').
    pub place: [f64; 2],
    /// `[∂x'/∂X, ∂x'/∂Y, ∂y'/∂X, ∂y'/∂Y]` for the direction `(X, Y, 1)`.
    pub by_direction: [f64; 4],
    /// Derivatives of x' by k1, k2, p1, p2, k3.
    pub x_by: [f64; 5],
    /// Derivatives of y' by them.
    pub y_by: [f64; 5],
}

impl Distortion {
    /// Names and values of all coefficients.
    pub fn named(&self) -> [(&'static str, f64); 15] {
        let [s1, s2, s3, s4] = self.s;
        [
            ("k1", self.k1),
            ("k2", self.k2),
            ("p1", self.p1),
            ("p2", self.p2),
            ("k3", self.k3),
            ("r8", self.r8),
            ("k4", self.k4),
            ("k5", self.k5),
            ("k6", self.k6),
            ("s1", s1),
            ("s2", s2),
            ("s3", s3),
            ("s4", s4),
            ("b1", self.b1),
            ("b2", self.b2),
        ]
    }

    /// (x', y') of the direction `(x, y, 1)`.
    pub fn bend(&self, x: f64, y: f64) -> (f64, f64) {
        let (x, y) = self.on_plane(x, y);
        self.on_plane_bent(x, y)
    }

    /// [`bend`](Self::bend) with its derivatives.
    pub fn bend_with_derivatives(&self, x: f64, y: f64) -> Bent {
        let [a, b, c, d] = match self.model {
            Model::Brown => [1.0, 0.0, 0.0, 1.0],
            Model::Fisheye => {
                let r2 = x * x + y * y;
                let scale = angle_by_tangent(r2);
                // (d scale / dr) / r; the difference loses its digits near the axis.
                let slope = if r2 < 1e-6 { -2.0 / 3.0 + 0.8 * r2 } else { (1.0 / (1.0 + r2) - scale) / r2 };
                [scale + slope * x * x, slope * x * y, slope * x * y, scale + slope * y * y]
            }
        };
        let (x, y) = self.on_plane(x, y);
        let (r2, below) = (x * x + y * y, self.below_line(x * x + y * y));
        let [e, f, g, h] = self.on_plane_jacobian(x, y);
        let (xd, yd) = self.on_plane_bent(x, y);
        let radial = [r2 / below, r2 * r2 / below, r2 * r2 * r2 / below];
        Bent {
            place: [xd, yd],
            by_direction: [e * a + f * c, e * b + f * d, g * a + h * c, g * b + h * d],
            x_by: [x * radial[0], x * radial[1], 2.0 * x * y, r2 + 2.0 * x * x, x * radial[2]],
            y_by: [y * radial[0], y * radial[1], r2 + 2.0 * y * y, 2.0 * x * y, y * radial[2]],
        }
    }

    /// The direction `(x, y, 1)` whose place is (x', y'): Newton's method, its steps halved while they lead away, to 1e-13.
    /// A fisheye's directions end 0.06 degrees before a right angle to the axis. Places that no direction has, far outside
    /// the picture, give the closest met on the way.
    pub fn unbend(&self, xd: f64, yd: f64) -> (f64, f64) {
        let (mut x, mut y) = (xd, yd);
        let miss = |x: f64, y: f64| {
            let (fx, fy) = self.on_plane_bent(x, y);
            (fx - xd, fy - yd)
        };
        let size = |(ex, ey): (f64, f64)| ex.abs().max(ey.abs());
        let mut e = miss(x, y);
        for _ in 0..50 {
            if size(e) < 1e-13 {
                break;
            }
            let [a, b, c, d] = self.on_plane_jacobian(x, y);
            let det = a * d - b * c;
            let (dx, dy) = ((d * e.0 - b * e.1) / det, (a * e.1 - c * e.0) / det);
            let mut part = 1.0;
            let next = loop {
                let (nx, ny) = (x - part * dx, y - part * dy);
                let ne = miss(nx, ny);
                if size(ne) < size(e) {
                    break Some((nx, ny, ne));
                }
                part *= 0.5;
                if part < 1e-3 {
                    break None;
                }
            };
            let Some(next) = next else { break };
            (x, y, e) = next;
        }
        match self.model {
            Model::Brown => (x, y),
            Model::Fisheye => {
                let angle = x.hypot(y);
                let scale = if angle < 1e-9 { 1.0 } else { angle.min(FARTHEST).tan() / angle };
                (x * scale, y * scale)
            }
        }
    }

    fn on_plane(&self, x: f64, y: f64) -> (f64, f64) {
        match self.model {
            Model::Brown => (x, y),
            Model::Fisheye => {
                let scale = angle_by_tangent(x * x + y * y);
                (x * scale, y * scale)
            }
        }
    }

    fn below_line(&self, r2: f64) -> f64 {
        1.0 + r2 * (self.k4 + r2 * (self.k5 + r2 * self.k6))
    }

    fn on_plane_bent(&self, x: f64, y: f64) -> (f64, f64) {
        let Self { k1, k2, p1, p2, k3, r8, s, .. } = self;
        let r2 = x * x + y * y;
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * r8)))) / self.below_line(r2);
        (
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s[0] + r2 * s[1]),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s[2] + r2 * s[3]),
        )
    }

    fn on_plane_jacobian(&self, x: f64, y: f64) -> [f64; 4] {
        let Self { k1, k2, p1, p2, k3, r8, k4, k5, k6, s, .. } = self;
        let r2 = x * x + y * y;
        let below = self.below_line(r2);
        let radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * (k3 + r2 * r8)))) / below;
        let above_slope = k1 + r2 * (2.0 * k2 + r2 * (3.0 * k3 + 4.0 * r2 * r8));
        let below_slope = k4 + r2 * (2.0 * k5 + 3.0 * r2 * k6);
        let slope = 2.0 * (above_slope - radial * below_slope) / below;
        let cross = slope * x * y + 2.0 * p1 * x + 2.0 * p2 * y;
        let (prism_x, prism_y) = (2.0 * (s[0] + 2.0 * r2 * s[1]), 2.0 * (s[2] + 2.0 * r2 * s[3]));
        [
            radial + slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x + prism_x * x,
            cross + prism_x * y,
            cross + prism_y * x,
            radial + slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x + prism_y * y,
        ]
    }
}

/// Largest angle from the axis that has a direction `(x, y, 1)` here, radians.
const FARTHEST: f64 = std::f64::consts::FRAC_PI_2 - 1e-3;

/// θ / tan θ for `tan² θ`.
fn angle_by_tangent(tangent_squared: f64) -> f64 {
    let tangent = tangent_squared.sqrt();
    if tangent < 1e-8 { 1.0 } else { tangent.atan() / tangent }
}

/// The coefficients as files write them: those of an ordinary lens or of a fisheye always, others where they are not 0.
#[derive(Serialize, Deserialize, Default)]
#[serde(default)]
struct Written {
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<Model>,
    k1: Option<f64>,
    k2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    p2: Option<f64>,
    k3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    r8: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k5: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    k6: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    s1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    s2: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    s3: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    s4: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    b1: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    b2: Option<f64>,
}

impl TryFrom<Written> for Distortion {
    type Error = String;

    fn try_from(w: Written) -> Result<Self, String> {
        let model = w.model.unwrap_or_default();
        let need = |value: Option<f64>, key: &str| value.ok_or_else(|| format!("missing field `{key}` of the lens"));
        let or_zero = |value: Option<f64>| value.unwrap_or(0.0);
        let (k1, k2, k3) = (need(w.k1, "k1")?, need(w.k2, "k2")?, need(w.k3, "k3")?);
        let (p1, p2, r8, k4) = match model {
            Model::Brown => (need(w.p1, "p1")?, need(w.p2, "p2")?, or_zero(w.r8), or_zero(w.k4)),
            Model::Fisheye => {
                if [w.k5, w.k6, w.r8].iter().any(Option::is_some) {
                    return Err("a fisheye has k1, k2, k3, k4, and no `k5`, `k6`, `r8`".into());
                }
                (or_zero(w.p1), or_zero(w.p2), need(w.k4, "k4")?, 0.0)
            }
        };
        let (k5, k6) = (or_zero(w.k5), or_zero(w.k6));
        let (s, b1, b2) = ([w.s1, w.s2, w.s3, w.s4].map(or_zero), or_zero(w.b1), or_zero(w.b2));
        Ok(Self { model, k1, k2, p1, p2, k3, r8, k4, k5, k6, s, b1, b2 })
    }
}

impl From<Distortion> for Written {
    fn from(d: Distortion) -> Self {
        let if_any = |value: f64| (value != 0.0).then_some(value);
        let [s1, s2, s3, s4] = d.s.map(if_any);
        let (always, shared) = match d.model {
            Model::Brown => (Self { p1: Some(d.p1), p2: Some(d.p2), r8: if_any(d.r8), ..Self::default() }, d.k4),
            Model::Fisheye => {
                let model = Some(Model::Fisheye);
                (Self { model, p1: if_any(d.p1), p2: if_any(d.p2), ..Self::default() }, d.r8)
            }
        };
        let k4 = if d.model == Model::Fisheye { Some(shared) } else { if_any(shared) };
        Self {
            k1: Some(d.k1),
            k2: Some(d.k2),
            k3: Some(d.k3),
            k4,
            k5: if_any(d.k5),
            k6: if_any(d.k6),
            s1,
            s2,
            s3,
            s4,
            b1: if_any(d.b1),
            b2: if_any(d.b2),
            ..always
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn all() -> [Distortion; 4] {
        let brown = Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.01, ..Distortion::default() };
        let rational = Distortion { k4: 0.02, k5: -0.03, k6: 0.004, s: [1e-3, -2e-4, 5e-4, 3e-4], r8: 1e-3, ..brown };
        let fisheye =
            Distortion { model: Model::Fisheye, k1: 0.03, k2: -0.01, k3: 4e-3, r8: -1e-3, ..Distortion::default() };
        let prism = Distortion { p1: 1e-3, p2: -5e-4, s: [1e-3, 0.0, -1e-3, 0.0], b1: 3.0, b2: -1.0, ..fisheye };
        [brown, rational, fisheye, prism]
    }

    #[test]
    fn unbending_undoes_bending() {
        for d in all() {
            let reach = if d.model == Model::Fisheye { 2.5 } else { 0.8 };
            for (x, y) in [(0.0, 0.0), (1e-9, 0.0), (0.3, -0.2), (-1.0, 0.9), (0.01, 1.0)] {
                let (x, y) = (x * reach, y * reach);
                let (xd, yd) = d.bend(x, y);
                let back = d.unbend(xd, yd);
                assert!((back.0 - x).abs() < 1e-11 && (back.1 - y).abs() < 1e-11, "{d:?} {x} {y} {back:?}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let h = 1e-6;
        for d in all() {
            for (x, y) in [(0.0, 0.0), (1e-4, 2e-4), (0.3, -0.2), (-0.7, 0.5)] {
                let bent = d.bend_with_derivatives(x, y);
                let slope = |plus: (f64, f64), minus: (f64, f64)| {
                    [(plus.0 - minus.0) / (2.0 * h), (plus.1 - minus.1) / (2.0 * h)]
                };
                let by_x = slope(d.bend(x + h, y), d.bend(x - h, y));
                let by_y = slope(d.bend(x, y + h), d.bend(x, y - h));
                let [a, b, c, e] = bent.by_direction;
                for (found, want) in [(a, by_x[0]), (c, by_x[1]), (b, by_y[0]), (e, by_y[1])] {
                    assert!((found - want).abs() < 1e-8, "{d:?} {x} {y}: {found} {want}");
                }
                let moved = |k: usize, by: f64| {
                    let mut d = d;
                    *[&mut d.k1, &mut d.k2, &mut d.p1, &mut d.p2, &mut d.k3][k] += by;
                    d.bend(x, y)
                };
                for k in 0..5 {
                    let want = slope(moved(k, h), moved(k, -h));
                    assert!(
                        (bent.x_by[k] - want[0]).abs() < 1e-8 && (bent.y_by[k] - want[1]).abs() < 1e-8,
                        "{d:?} {k}"
                    );
                }
            }
        }
    }

    #[test]
    fn what_is_written_is_read_back_and_what_is_missing_is_named() {
        for d in all() {
            let text = serde_json::to_string(&d).unwrap();
            assert_eq!(serde_json::from_str::<Distortion>(&text).unwrap(), d, "{text}");
        }
        let plain = serde_json::to_string(&Distortion::default()).unwrap();
        assert_eq!(plain, r#"{"k1":0.0,"k2":0.0,"p1":0.0,"p2":0.0,"k3":0.0}"#);
        let fault = |text: &str| serde_json::from_str::<Distortion>(text).unwrap_err().to_string();
        assert!(fault(r#"{"k1":0,"k2":0,"p1":0,"k3":0}"#).contains("`p2`"));
        assert!(fault(r#"{"model":"fisheye","k1":0,"k2":0,"k3":0}"#).contains("`k4`"));
        assert!(fault(r#"{"model":"fisheye","k1":0,"k2":0,"k3":0,"k4":0,"k5":0}"#).contains("`k5`"));
        assert!(fault(r#"{"model":"fov","k1":0}"#).contains("fisheye"));
    }
}
