//! Rootness: how much each voxel's neighbourhood looks like a root, over one or several scales.  Paper 2.5.
//!
//! At every scale σ the Hessian ([`super::hessian`]) is normalised by σ², decomposed in closed form, and
//! measured by equation 16 ([`super::sato`]); the greatest measure wins (on a tie the smaller index),
//! and with it its scale and its tangent, the eigenvector of λ1. Rootness has the unit of the volume.
//! Where the volume is unknown, rootness is NaN, the tangent zero.

use super::hessian::{self, Hessian};
use super::sato::Sato;
use crate::error::{Error, Result};
use crate::math::eigen3::Sym3;
use crate::photo::colour;
use ndarray::{Array3, Array4, ArrayView3, ArrayView4, Axis};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Parameters of rootness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rootness {
    /// Standard deviations of the Gaussian, mm, each at least 0.4 voxels (narrower ones cannot be sampled) and at most 20.
    pub sigma: Vec<f64>,
    /// γ23 of equation 16, see [`Sato`].
    pub gamma23: f64,
    /// γ12 of equation 16.
    pub gamma12: f64,
    /// α of equation 16.
    pub alpha: f64,
    /// Roots are darker than the water behind them.
    pub dark: bool,
}

impl Default for Rootness {
    fn default() -> Self {
        let Sato { gamma23, gamma12, alpha } = Sato::default();
        Self { sigma: vec![1.0], gamma23, gamma12, alpha, dark: false }
    }
}

impl Rootness {
    fn sato(&self) -> Sato {
        Sato { gamma23: self.gamma23, gamma12: self.gamma12, alpha: self.alpha }
    }

    /// Fails where a parameter is out of range for the voxel edge `spacing_mm`.
    ///
    /// # Errors
    /// All faults at once.
    pub fn check(&self, spacing_mm: f64) -> Result<()> {
        let mut faults = Vec::new();
        if self.sigma.is_empty() || self.sigma.len() > 255 {
            faults.push(Error::usage("rootness.sigma names no scale, or over 255").help("give one or several, in mm"));
        }
        for &sigma in &self.sigma {
            if !(0.4..=20.0).contains(&(sigma / spacing_mm)) {
                faults.push(
                    Error::usage(format!("rootness.sigma holds {sigma} mm, {:.2} voxels", sigma / spacing_mm))
                        .help("a scale lies between 0.4 and 20 voxels; change it or grid.spacing"),
                );
            }
        }
        faults.extend(self.sato().check().err());
        Error::many(faults)
    }

    /// Planes that a slab needs beyond its own on either side.
    pub fn halo(&self, spacing_mm: f64) -> usize {
        self.sigma.iter().map(|s| hessian::halo(s / spacing_mm)).max().unwrap_or(0)
    }
}

/// Rootness of the inner planes of a slab.
#[derive(Debug, Clone, PartialEq)]
pub struct RootVolume {
    /// (z, y, x), unit of the volume, 0 or more; NaN = unknown.
    pub rootness: Array3<f32>,
    /// (z, y, x, [x y z]): unit tangent times 127, rounded (0.4°); zero where rootness is 0 or unknown.
    pub tangent: Array4<i8>,
    /// (z, y, x): index of the winning scale.
    pub scale: Array3<u8>,
}

/// Gray of a merged colour volume (z, y, x, 3); NaN stays NaN.
pub fn gray(colour: ArrayView4<f32>) -> Array3<f32> {
    colour.map_axis(Axis(3), |rgb| colour::gray([rgb[0], rgb[1], rgb[2]]))
}

/// Rootness of the planes `inner` of `slab` (z, y, x; NaN = unknown), which holds [`Rootness::halo`]
/// planes beyond them wherever the volume has them. For a whole volume, `inner` is all its planes.
///
/// # Errors
/// Where a parameter is out of range or `inner` leaves the slab.
pub fn rootness(slab: ArrayView3<f32>, inner: Range<usize>, spacing_mm: f64, params: &Rootness) -> Result<RootVolume> {
    params.check(spacing_mm)?;
    let (nz, ny, nx) = slab.dim();
    if inner.end > nz || inner.start > inner.end {
        return Err(Error::failed(format!("rootness: planes {inner:?} of a slab of {nz}")));
    }
    let shape = (inner.len(), ny, nx);
    let mut out = RootVolume {
        rootness: Array3::zeros(shape),
        tangent: Array4::zeros((shape.0, ny, nx, 3)),
        scale: Array3::zeros(shape),
    };
    let sato = params.sato();
    for (index, sigma) in params.sigma.iter().enumerate() {
        let sigma_voxels = sigma / spacing_mm;
        let hessian = Hessian::new(slab, inner.clone(), sigma_voxels);
        let planes = out.rootness.axis_iter_mut(Axis(0)).into_par_iter();
        planes.zip(out.tangent.axis_iter_mut(Axis(0))).zip(out.scale.axis_iter_mut(Axis(0))).enumerate().for_each(
            |(k, ((mut rootness, mut tangent), mut scale))| {
                let mut row = hessian.empty_row();
                for j in 0..ny {
                    hessian.row(k, j, &mut row);
                    for i in 0..nx {
                        if slab[[inner.start + k, j, i]].is_nan() {
                            rootness[[j, i]] = f32::NAN;
                            continue;
                        }
                        let sign = if params.dark { -1.0 } else { 1.0 };
                        let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|c| sign * f64::from(row[c][i]));
                        let m = Sym3 { xx, yy, zz, xy, xz, yz };
                        if !may_be_line(&m) {
                            continue;
                        }
                        let lambda = m.eigenvalues();
                        let value = (sigma_voxels * sigma_voxels * sato.measure(lambda)) as f32;
                        if value > rootness[[j, i]] {
                            rootness[[j, i]] = value;
                            scale[[j, i]] = index as u8;
                            for (c, t) in m.principal_direction(lambda[0]).into_iter().enumerate() {
                                tangent[[j, i, c]] = (t * 127.0).round() as i8;
                            }
                        }
                    }
                }
            },
        );
    }
    Ok(out)
}

/// Whether at least two eigenvalues may be negative, by the signs of the characteristic polynomial's
/// coefficients: spares most voxels the decomposition.
fn may_be_line(m: &Sym3) -> bool {
    let trace = m.xx + m.yy + m.zz;
    let minors = m.xx * m.yy - m.xy * m.xy + m.xx * m.zz - m.xz * m.xz + m.yy * m.zz - m.yz * m.yz;
    let det =
        m.xx * (m.yy * m.zz - m.yz * m.yz) - m.xy * (m.xy * m.zz - m.yz * m.xz) + m.xz * (m.xy * m.yz - m.yy * m.xz);
    // det > 0: all three positive or just one; else all negative, or just one (then no line).
    if det > 0.0 { !(trace > 0.0 && minors > 0.0) } else { trace < 0.0 && minors > 0.0 }
}
