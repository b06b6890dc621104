//! The three-parameter line measure of Sato et al. 1998, equation 16.  Paper 2.5.
//!
//! For the eigenvalues λ1 ≥ λ2 ≥ λ3 of the Hessian (a bright line: λ1 ≈ 0, λ2 ≈ λ3 ≪ 0):
//!
//! ```text
//! |λ3| (λ2/λ3)^γ23 (1 + λ1/|λ2|)^γ12       λ3 ≤ λ2 < 0, λ1 ≤ 0
//! |λ3| (λ2/λ3)^γ23 (1 - α λ1/|λ2|)^γ12     λ3 ≤ λ2 < 0 < λ1 < |λ2|/α
//! 0                                        otherwise
//! ```
//!
//! At λ1 = 0 it is √(λ2 λ3) for γ23 = 1/2 and min(|λ2|, |λ3|) for γ23 = 1. An exponent of 0 leaves its
//! factor out.

use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};

/// Parameters of the line measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sato {
    /// γ23 ≥ 0: how much a flat cross-section costs.
    pub gamma23: f64,
    /// γ12 ≥ 0: how much curvature along the line costs.
    pub gamma12: f64,
    /// 0 < α ≤ 1: makes λ1 > 0 (waists, bends) cheaper than λ1 < 0 (blobs).
    pub alpha: f64,
}

impl Default for Sato {
    /// The paper's choice (section 3).
    fn default() -> Self {
        Self { gamma23: 0.5, gamma12: 0.5, alpha: 0.25 }
    }
}

impl Sato {
    /// Fails where a parameter is out of range.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        for (name, value) in [("gamma23", self.gamma23), ("gamma12", self.gamma12)] {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(Error::usage(format!("rootness.{name} is {value}")).help("exponents are 0 or more"));
            }
        }
        if !(self.alpha > 0.0 && self.alpha <= 1.0) {
            faults.push(Error::usage(format!("rootness.alpha is {}", self.alpha)).help("alpha lies in (0, 1]"));
        }
        Error::many(faults)
    }

    /// The measure of one voxel; 0 where the neighbourhood is not line-like.
    pub fn measure(&self, [l1, l2, l3]: [f64; 3]) -> f64 {
        if l2 >= 0.0 {
            return 0.0;
        }
        let along = if l1 <= 0.0 { 1.0 - l1 / l2 } else { 1.0 + self.alpha * l1 / l2 };
        if along <= 0.0 && self.gamma12 > 0.0 || l1 >= -l2 / self.alpha {
            return 0.0;
        }
        -l3 * power(l2 / l3, self.gamma23) * power(along, self.gamma12)
    }
}

/// `x^p` for x ≥ 0, without the general power for the usual exponents.
fn power(x: f64, p: f64) -> f64 {
    if p == 0.5 {
        x.sqrt()
    } else if p == 1.0 {
        x
    } else if p == 0.0 {
        1.0
    } else {
        x.powf(p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_vectors() {
        let paper = Sato::default();
        let other = Sato { gamma23: 1.0, gamma12: 1.0, alpha: 0.25 };
        for (l, by_paper, by_other) in [
            ([0.0, -1.0, -1.0], 1.0, 1.0),
            ([0.0, -0.5, -1.0], 0.5f64.sqrt(), 0.5),
            ([-0.5, -1.0, -1.0], 0.5f64.sqrt(), 0.5),
            ([-1.0, -1.0, -1.0], 0.0, 0.0),
            ([0.5, -1.0, -1.0], 0.9354, 0.875),
            ([2.0, -1.0, -1.0], 0.5f64.sqrt(), 0.5),
            ([4.0, -1.0, -1.0], 0.0, 0.0),
            ([0.5, 0.1, -1.0], 0.0, 0.0),
        ] {
            assert!((paper.measure(l) - by_paper).abs() < 1e-4, "{l:?}");
            assert!((other.measure(l) - by_other).abs() < 1e-4, "{l:?}");
        }
    }

    #[test]
    fn general_powers_continue_the_usual_ones() {
        let l = [-0.3, -0.8, -1.1];
        for p in [0.5, 1.0] {
            let near = Sato { gamma23: p + 1e-9, gamma12: p + 1e-9, alpha: 0.25 };
            let at = Sato { gamma23: p, gamma12: p, alpha: 0.25 };
            assert!((near.measure(l) - at.measure(l)).abs() < 1e-7);
        }
    }

    #[test]
    fn out_of_range_is_refused() {
        assert_eq!(Sato { gamma23: -1.0, gamma12: f64::NAN, alpha: 0.0 }.check().unwrap_err().others.len(), 2);
    }
}
