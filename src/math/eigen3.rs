//! Eigenvalues and eigenvectors of a symmetric 3x3 matrix in closed form.
//!
//! With q = tr A / 3 and p² = |A - q1|² / 6, the eigenvalues are q + 2p cos(φ + 2πk/3) where
//! cos 3φ = det((A - q1)/p) / 2 (the trigonometric solution of the cubic). An eigenvector is the
//! longest cross product of two rows of A - λ1. All in f64; where the wanted eigenvalue is so close
//! to its neighbour that the cross products vanish, Jacobi rotations take over, so degenerate
//! matrices (planes, spheres, zero) give orthonormal directions too, never NaN for finite input.

/// A symmetric matrix as its six entries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sym3 {
    /// Row 1, column 1.
    pub xx: f64,
    /// Row 2, column 2.
    pub yy: f64,
    /// Row 3, column 3.
    pub zz: f64,
    /// Row 1, column 2.
    pub xy: f64,
    /// Row 1, column 3.
    pub xz: f64,
    /// Row 2, column 3.
    pub yz: f64,
}

impl Sym3 {
    /// Eigenvalues, largest first (λ1 ≥ λ2 ≥ λ3), exact to about 1e-8 of the largest magnitude.
    pub fn eigenvalues(&self) -> [f64; 3] {
        let q = (self.xx + self.yy + self.zz) / 3.0;
        let (a, b, c) = (self.xx - q, self.yy - q, self.zz - q);
        let off = self.xy * self.xy + self.xz * self.xz + self.yz * self.yz;
        let p = ((a * a + b * b + c * c + 2.0 * off) / 6.0).sqrt();
        // Below this p³ would be denormal, and the three values agree anyway.
        if p < 1e-100 {
            return [q; 3];
        }
        let det = a * (b * c - self.yz * self.yz) - self.xy * (self.xy * c - self.yz * self.xz)
            + self.xz * (self.xy * self.yz - b * self.xz);
        let phi = (det / (2.0 * p * p * p)).clamp(-1.0, 1.0).acos() / 3.0;
        let (sin, cos) = phi.sin_cos();
        let root3 = 3.0_f64.sqrt();
        // cos(φ ± 2π/3) from sin φ and cos φ; φ lies in [0, π/3], which orders the three.
        [q + 2.0 * p * cos, q + p * (root3 * sin - cos), q - p * (root3 * sin + cos)]
    }

    /// Unit eigenvector of the largest eigenvalue `lambda1` (as [`Self::eigenvalues`] gave it), (x, y, z),
    /// sign free. Where λ1 is double or triple, some unit vector of its eigenspace.
    pub fn principal_direction(&self, lambda1: f64) -> [f64; 3] {
        let rows = [
            [self.xx - lambda1, self.xy, self.xz],
            [self.xy, self.yy - lambda1, self.yz],
            [self.xz, self.yz, self.zz - lambda1],
        ];
        let norms = rows.iter().flatten().map(|x| x * x).sum::<f64>();
        let mut best = [0.0; 3];
        let mut length2 = 0.0;
        for (u, v) in [(0, 1), (0, 2), (1, 2)] {
            let [u, v]: [[f64; 3]; 2] = [rows[u], rows[v]];
            let w = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let l = w[0] * w[0] + w[1] * w[1] + w[2] * w[2];
            if l > length2 {
                (best, length2) = (w, l);
            }
        }
        // The cross product's length is the product of the gaps to the other eigenvalues: below 1e-5
        // of the scale the closed form's error in λ1 would tilt the vector visibly.
        if length2 <= (1e-10 * norms * norms).max(1e-280) {
            return self.jacobi().1[0];
        }
        let s = length2.sqrt().recip();
        best.map(|x| x * s)
    }

    /// Eigenvalues, largest first, and the unit eigenvectors in the same order, by cyclic Jacobi
    /// rotations: slower, exact to rounding for every finite matrix.
    pub fn jacobi(&self) -> ([f64; 3], [[f64; 3]; 3]) {
        let mut a = [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]];
        let mut v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        for _ in 0..30 {
            if a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0 {
                break;
            }
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                if a[p][q].abs() <= f64::MIN_POSITIVE {
                    a[p][q] = 0.0;
                    a[q][p] = 0.0;
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
                let c = (t * t + 1.0).sqrt().recip();
                let s = t * c;
                for row in &mut a {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..3 {
                    (a[p][k], a[q][k]) = (c * a[p][k] - s * a[q][k], s * a[p][k] + c * a[q][k]);
                    // v holds the eigenvectors as rows.
                    (v[p][k], v[q][k]) = (c * v[p][k] - s * v[q][k], s * v[p][k] + c * v[q][k]);
                }
                if a[p][q].abs() <= 1e-17 * (a[p][p].abs() + a[q][q].abs()) {
                    a[p][q] = 0.0;
                    a[q][p] = 0.0;
                }
            }
        }
        let mut order = [0, 1, 2];
        order.sort_by(|&i, &j| a[j][j].total_cmp(&a[i][i]));
        (order.map(|i| a[i][i]), order.map(|i| v[i]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn residual(m: &Sym3, lambda: f64, v: [f64; 3]) -> f64 {
        let r = [
            m.xx * v[0] + m.xy * v[1] + m.xz * v[2] - lambda * v[0],
            m.xy * v[0] + m.yy * v[1] + m.yz * v[2] - lambda * v[1],
            m.xz * v[0] + m.yz * v[1] + m.zz * v[2] - lambda * v[2],
        ];
        r.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn check(m: Sym3) {
        let n = nalgebra::Matrix3::new(m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz);
        let mut expected: Vec<f64> = n.symmetric_eigenvalues().iter().copied().collect();
        expected.sort_by(|a, b| b.total_cmp(a));
        let scale = n.norm().max(1e-300);
        let got = m.eigenvalues();
        let (by_jacobi, vectors) = m.jacobi();
        for i in 0..3 {
            assert!((got[i] - expected[i]).abs() <= 3e-8 * scale, "{m:?}: {got:?} for {expected:?}");
            assert!((by_jacobi[i] - expected[i]).abs() <= 1e-13 * scale, "{m:?}: {by_jacobi:?} for {expected:?}");
            assert!(residual(&m, by_jacobi[i], vectors[i]) <= 1e-13 * scale, "{m:?}");
        }
        let v = m.principal_direction(got[0]);
        assert!((v.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12, "{m:?}: {v:?}");
        assert!(residual(&m, expected[0], v) <= 1e-5 * scale, "{m:?}: {v:?}");
    }

    #[test]
    fn degenerate_matrices() {
        let line = |xx, yy, zz| Sym3 { xx, yy, zz, xy: 0.0, xz: 0.0, yz: 0.0 };
        for m in [
            line(0.0, 0.0, 0.0),
            line(-1.0, -1.0, -1.0),
            line(0.0, -1.0, -1.0),
            line(-1.0, 0.0, -1.0),
            line(0.0, 0.0, -1.0),
            line(1e-30, -1e-30, 3e-30),
            line(1e20, -1e20, 0.0),
            Sym3 { xx: 1.0, yy: 1.0, zz: 1.0, xy: 1.0, xz: 1.0, yz: 1.0 },
            Sym3 { xx: -1.0, yy: -1.0, zz: -1.0, xy: 0.5, xz: 0.5, yz: 0.5 },
            Sym3 { xx: 1.0, yy: 1.0, zz: 1.0, xy: 1e-12, xz: 0.0, yz: -1e-12 },
        ] {
            check(m);
        }
    }

    proptest! {
        #[test]
        fn agrees_with_nalgebra(e in prop::array::uniform6(-1.0f64..1.0), exponent in -20i32..20) {
            let s = 10f64.powi(exponent);
            check(Sym3 { xx: e[0] * s, yy: e[1] * s, zz: e[2] * s, xy: e[3] * s, xz: e[4] * s, yz: e[5] * s });
        }

        #[test]
        fn agrees_with_nalgebra_near_degeneracy(d in prop::array::uniform3(-1.0f64..1.0), gap in -12i32..0) {
            // q1 + a small difference: a line, plane or sphere turned by a rotation close to nothing.
            let g = 10f64.powi(gap);
            check(Sym3 { xx: -1.0 + d[0] * g, yy: -1.0, zz: -1.0, xy: d[1] * g, xz: d[2] * g, yz: 0.0 });
        }
    }
}
