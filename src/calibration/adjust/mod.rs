//! Cameras, lens and belt points adjusted together, with the tank's size as the yardstick.
//!
//! One ring of views around one cylinder leaves focal length, distortion, the principal point's height
//! and the pitch almost free together. What cures it is knowledge of the tank: belt points are bound to
//! the cylinder of known radius, the outline's rings (rim, floor, belt edges) lie at known heights, and its sides
//! where belts end the view of the cylinder.
//!
//! **Unknowns**, in the tank frame: the lens (f, cx, cy, k1, k2, p1, p2, k3), the printed surface's radius
//! (within its prior: the distance of rim and floor corrects it), a pose per view (turned by
//! `exp ω` from the left, shifted by δt), two numbers (φ, z) per belt point, and per contour one offset of
//! the seen edge along the outward normal (blur and halo move all of a contour's edges alike); after the first round
//! the axis that the table turned about (the module `turning`).
//!
//! **Residuals**: `pixel - sighting` of each belt point (two), the distance from each outline point to
//! its contour along the contour's normal in the picture (one), each pose's distance from a turn about the axis (six),
//! priors. Each kind is divided by its robust standard deviation (1.4826 median |r|, taken anew between rounds) and weighted by the loss.
//!
//! **Solution**: Levenberg-Marquardt on the reweighted normal equations; the points are eliminated
//! (Schur complement), all sums run in a fixed order. The turn about z is not observable: it is held for
//! the covariance and laid by [`super::similarity::first_view_to_azimuth_zero`] afterwards.

mod axis;
mod covariance;
mod normal;
mod solve;
mod state;
mod turning;

pub use covariance::Uncertainty;
pub use solve::{Adjusted, adjust};
pub use state::{Contour, Network, OutlinePoint, Shape, Start};
pub use turning::{Bump, Turning};

use crate::math::robust::Loss;
use serde::{Deserialize, Serialize};

/// What the adjustment may move and how far it trusts what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdjustParams {
    /// M-estimator of all residuals.
    pub loss: Loss,
    /// Where the loss bends, in robust standard deviations of the residuals, 1..10; 2 keeps 95 % of
    /// normal residuals at nearly full weight.
    pub loss_scale: f64,
    /// Rounds of Levenberg-Marquardt between which standard deviations are taken anew, 1..20.
    pub rounds: usize,
    /// Steps per round, 1..200.
    pub steps: usize,
    /// A round ends when the cost falls by less than this part.
    pub tolerance: f64,
    /// Prior standard deviation of the focal length about the one that the camera wrote into the photographs (EXIF), as a
    /// part of it; 0 leaves that unread. It is written in whole mm of 35 mm film, and focusing near changes it.
    pub focal_sigma: f64,
    /// Prior standard deviation of the principal point about the picture's centre, as a part of the
    /// picture's width, 0 (held) to 1. Lenses are mounted to a few per cent.
    pub principal_point_sigma: f64,
    /// Prior standard deviation of k1 and k2 about 0; 0 holds them.
    pub radial_sigma: f64,
    /// Prior standard deviation of p1 and p2 about 0; 0 holds them.
    pub tangential_sigma: f64,
    /// Prior standard deviation of k3 about 0; 0 holds it: the tank fills too little of the picture to
    /// tell r⁶ from r⁴.
    pub k3_sigma: f64,
    /// Prior standard deviation of the printed surface's radius (the typed radius and the print's thickness
    /// together), mm; 0 holds it. Two sheets of paper more or less, or a tape measure read to a tenth.
    pub radius_sigma_mm: f64,
    /// Prior standard deviation of a contour's common edge offset, px: by how far blur, halo and half-tones
    /// may shift all of its edges.
    pub edge_offset_sigma_px: f64,
    /// Whether poses are drawn towards turns about one axis, as strongly as they are near such turns without that.
    pub one_axis: bool,
}

impl Default for AdjustParams {
    fn default() -> Self {
        Self {
            loss: Loss::SoftL1,
            loss_scale: 2.0,
            rounds: 3,
            steps: 50,
            tolerance: 1e-6,
            focal_sigma: 0.05,
            principal_point_sigma: 0.05,
            radial_sigma: 0.3,
            tangential_sigma: 0.002,
            k3_sigma: 0.0,
            radius_sigma_mm: 0.05,
            edge_offset_sigma_px: 0.15,
            one_axis: true,
        }
    }
}

#[cfg(test)]
mod tests;
