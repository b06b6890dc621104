//! M-estimators that keep outliers from pulling a fit.  Paper 2.2.3.
//!
//! With the scaled residual `x = r / scale`: soft-L1 `ρ = 2(√(1 + x²) - 1)`, Cauchy `ρ = ln(1 + x²)`,
//! least squares `ρ = x²`. All behave as x² near zero. `weight` is `ρ'(x) / 2x`, the factor of x² in
//! iteratively reweighted least squares. NaN gives NaN.

use serde::{Deserialize, Serialize};

/// Which M-estimator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Loss {
    /// Plain least squares.
    Squares,
    /// 2(√(1 + x²) - 1): linear in the tails.
    SoftL1,
    /// ln(1 + x²): logarithmic in the tails.
    Cauchy,
}

impl Loss {
    /// ρ of the scaled residual x.
    pub fn rho(self, x: f64) -> f64 {
        let s = x * x;
        match self {
            Self::Squares => s,
            Self::SoftL1 => 2.0 * ((1.0 + s).sqrt() - 1.0),
            Self::Cauchy => s.ln_1p(),
        }
    }

    /// Weight of x² that gives the same slope as ρ, 0..=1.
    pub fn weight(self, x: f64) -> f64 {
        let s = x * x;
        match self {
            Self::Squares => 1.0,
            Self::SoftL1 => 1.0 / (1.0 + s).sqrt(),
            Self::Cauchy => 1.0 / (1.0 + s),
        }
    }
}

/// Median of `values` (mean of the middle two for an even count), reordering them; NaN where empty.
pub fn median(values: &mut [f64]) -> f64 {
    let n = values.len();
    if n == 0 {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    0.5 * (values[(n - 1) / 2] + values[n / 2])
}

/// Standard deviation of a normal distribution about zero with the same median absolute value:
/// 1.4826 median |r|; NaN where empty.
pub fn spread(residuals: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = residuals.map(f64::abs).collect();
    1.4826 * median(&mut sizes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weight_is_the_slope_of_rho() {
        for loss in [Loss::Squares, Loss::SoftL1, Loss::Cauchy] {
            for x in [0.01, 0.5, 1.0, 7.0] {
                let h = 1e-6;
                let slope = (loss.rho(x + h) - loss.rho(x - h)) / (2.0 * h);
                assert!((slope / (2.0 * x) - loss.weight(x)).abs() < 1e-6, "{loss:?} at {x}");
            }
        }
    }

    #[test]
    fn median_of_even_and_odd() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(&mut []).is_nan());
    }
}
