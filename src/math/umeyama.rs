//! The motion that brings points nearest to others in the sense of least squares (Kabsch 1976, Umeyama 1991).

use nalgebra::{Matrix3, Vector3};

/// `to ≈ scale rotation from + translation`, point by point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fit {
    /// A rotation, never a mirror image.
    pub rotation: Matrix3<f64>,
    /// The best scale.
    pub scale: f64,
    /// Means of the points and of their goals.
    means: [Vector3<f64>; 2],
}

impl Fit {
    /// The translation at a given scale: the best one, or 1 for a rigid motion.
    pub fn translation(&self, scale: f64) -> Vector3<f64> {
        self.means[1] - self.rotation * self.means[0] * scale
    }
}

/// Fits points to their goals, which run alike; `None` where the points lie on one line or there are fewer than three.
pub fn fit(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<Fit> {
    if from.len() < 3 || from.len() != to.len() {
        return None;
    }
    let n = from.len() as f64;
    let mean = |p: &[Vector3<f64>]| p.iter().sum::<Vector3<f64>>() / n;
    let (mf, mt) = (mean(from), mean(to));
    let covariance: Matrix3<f64> =
        from.iter().zip(to).map(|(f, t)| (t - mt) * (f - mf).transpose()).sum::<Matrix3<f64>>() / n;
    let variance = from.iter().map(|f| (f - mf).norm_squared()).sum::<f64>() / n;
    if !covariance.iter().all(|x| x.is_finite()) {
        return None;
    }
    let svd = covariance.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    if variance <= 0.0 || svd.singular_values[1] <= 1e-12 * svd.singular_values[0] {
        return None;
    }
    // Points in a plane fit their mirror image as well: it is ruled out by the determinant.
    let sign = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, (u.determinant() * vt.determinant()).signum()));
    let trace: f64 = (0..3).map(|i| svd.singular_values[i] * sign[(i, i)]).sum();
    Some(Fit { rotation: u * sign * vt, scale: trace / variance, means: [mf, mt] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Rotation3;

    #[test]
    fn a_motion_is_found_again_and_a_line_tells_none() {
        let turn = *Rotation3::new(Vector3::new(0.3, -1.2, 0.7)).matrix();
        let shift = Vector3::new(4.0, -5.0, 6.0);
        // In a plane, where the mirror image fits as well.
        let from: Vec<Vector3<f64>> =
            (0..9).map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3).powi(2), 0.0)).collect();
        let to: Vec<Vector3<f64>> = from.iter().map(|p| turn * p * 2.5 + shift).collect();
        let fit = fit(&from, &to).unwrap();
        assert!((fit.rotation - turn).norm() < 1e-12 && (fit.scale - 2.5).abs() < 1e-12);
        assert!((fit.translation(fit.scale) - shift).norm() < 1e-12);
        let line: Vec<Vector3<f64>> = (0..9).map(|k| Vector3::new(f64::from(k), 0.0, 0.0)).collect();
        assert!(super::fit(&line, &to).is_none() && super::fit(&from[..2], &to[..2]).is_none());
        assert!(super::fit(&[Vector3::repeat(f64::NAN); 4], &to[..4]).is_none());
    }
}
