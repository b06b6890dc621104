//! Non-maximum suppression across the root: thins rootness to ridges.  Paper 2.5.
//!
//! A voxel of rootness above 0 stays where no value across its tangent exceeds its own:
//!
//! - `directions-13`, the paper's: the tangent takes one of 13 orientations ([`super::orientation`]) and
//!   the voxel is compared with the 3x3x3 neighbours orthogonal to it (their dilation);
//! - `continuous`: eight points at one voxel's distance around the true tangent, trilinear.
//!
//! Ties stay: on a plateau, or where a ridge runs midway between two voxels, all equal voxels are kept.
//! Neighbours that are unknown or outside the volume suppress nothing.
//!
//! Each ridge voxel also gets its offset to the ridge's crest: the top of the paraboloid through the
//! 3x3x3 rootness values around it (central differences; unknown = the centre's value), within the plane across the tangent,
//! no longer than half a voxel's diagonal; zero where the paraboloid has no top.
//!
//! A slab needs one plane beyond its own on either side.

use super::orientation::{across, nearest};
use super::ridges::Ridges;
use super::rootness::RootVolume;
use crate::error::{Error, Result};
use ndarray::ArrayView3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Planes that a slab needs beyond its own on either side.
pub const HALO: usize = 1;

/// How the tangent is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Tangent {
    /// The nearest of 13 orientations, as in the paper.
    #[serde(rename = "directions-13")]
    Directions13,
    /// As it is; neighbours interpolated.
    Continuous,
}

/// Parameters of suppression.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Suppress {
    /// directions-13 (paper 2.5) or continuous.
    pub tangent: Tangent,
}

impl Default for Suppress {
    fn default() -> Self {
        Self { tangent: Tangent::Directions13 }
    }
}

/// Ridges of the planes `inner` of a slab whose plane 0 is plane `first_plane` of a volume of `planes`
/// planes. For a whole volume: `inner` all its planes, `first_plane` 0.
///
/// # Errors
/// Where `inner` leaves the slab.
pub fn suppress(
    slab: &RootVolume,
    inner: Range<usize>,
    first_plane: usize,
    planes: usize,
    params: &Suppress,
) -> Result<Ridges> {
    let (nz, ny, nx) = slab.rootness.dim();
    if inner.end > nz || first_plane + nz > planes {
        return Err(Error::failed(format!(
            "suppress: planes {inner:?} of a slab of {nz} at {first_plane} of {planes}"
        )));
    }
    let masks: Vec<_> = (0..13).map(across).collect();
    let by_plane: Vec<Ridges> = inner
        .into_par_iter()
        .map(|k| {
            let mut ridges = Ridges::default();
            for j in 0..ny {
                for i in 0..nx {
                    let value = slab.rootness[[k, j, i]];
                    if value.is_nan() || value <= 0.0 {
                        continue;
                    }
                    let tangent = unit([0, 1, 2].map(|c| f32::from(slab.tangent[[k, j, i, c]])));
                    let around = Around::new(slab.rootness.view(), [k, j, i]);
                    let stays = match params.tangent {
                        Tangent::Directions13 => masks[nearest(tangent)].iter().all(|&d| around.known(d) <= value),
                        Tangent::Continuous => around.is_crest(tangent),
                    };
                    if stays {
                        ridges.index.push((((first_plane + k) * ny + j) * nx + i) as u32);
                        ridges.rootness.push(value);
                        ridges.tangent.push(tangent);
                        ridges.offset.push(around.offset(tangent));
                        ridges.scale.push(slab.scale[[k, j, i]]);
                    }
                }
            }
            ridges
        })
        .collect();
    let mut all = Ridges { shape: [planes, ny, nx], ..Ridges::default() };
    by_plane.into_iter().for_each(|next| all.append(next));
    Ok(all)
}

/// The 3x3x3 values around a voxel; NaN where unknown or outside.
struct Around([f32; 27]);

impl Around {
    fn new(volume: ArrayView3<f32>, voxel: [usize; 3]) -> Self {
        Self(std::array::from_fn(|n| {
            let [k, j, i] =
                [(0, n / 9), (1, n / 3 % 3), (2, n % 3)].map(|(c, d)| voxel[c].wrapping_add(d).wrapping_sub(1));
            volume.get([k, j, i]).copied().unwrap_or(f32::NAN)
        }))
    }

    /// Value at an offset (x, y, z) of -1, 0, 1 each.
    fn at(&self, d: [i8; 3]) -> f32 {
        self.0[(13 + 9 * d[2] + 3 * d[1] + d[0]) as usize]
    }

    /// The same; the centre's value where unknown.
    fn known(&self, d: [i8; 3]) -> f32 {
        let value = self.at(d);
        if value.is_nan() { self.0[13] } else { value }
    }

    /// Trilinear value at a point within a voxel's edge of the centre; unknown corners have the centre's value.
    fn interpolate(&self, p: [f32; 3]) -> f32 {
        let low = p.map(|x| if x < 0.0 { -1i8 } else { 0 });
        let f = [0, 1, 2].map(|c| p[c] - f32::from(low[c]));
        let mut sum = 0.0;
        for corner in 0..8 {
            let bit = [corner & 1, corner >> 1 & 1, corner >> 2];
            let weight: f32 = (0..3).map(|c| if bit[c] == 1 { f[c] } else { 1.0 - f[c] }).product();
            sum += weight * self.known([0, 1, 2].map(|c| low[c] + bit[c] as i8));
        }
        sum
    }

    /// Whether no point at one voxel's distance across the tangent exceeds the centre.
    fn is_crest(&self, tangent: [f32; 3]) -> bool {
        let (u, v) = plane_across(tangent);
        const H: f32 = std::f32::consts::FRAC_1_SQRT_2;
        [(1.0, 0.0), (H, H), (0.0, 1.0), (-H, H), (-1.0, 0.0), (-H, -H), (0.0, -1.0), (H, -H)]
            .iter()
            .all(|&(a, b)| self.interpolate([0, 1, 2].map(|c| (a * u[c] + b * v[c]).clamp(-1.0, 1.0))) <= self.0[13])
    }

    /// Offset to the crest across the tangent, voxels.
    fn offset(&self, tangent: [f32; 3]) -> [f32; 3] {
        let (u, v) = plane_across(tangent);
        let f = |x, y, z| self.known([x, y, z]);
        let g = [f(1, 0, 0) - f(-1, 0, 0), f(0, 1, 0) - f(0, -1, 0), f(0, 0, 1) - f(0, 0, -1)].map(|d| d / 2.0);
        let c = 2.0 * self.0[13];
        let [xx, yy, zz] = [f(1, 0, 0) + f(-1, 0, 0) - c, f(0, 1, 0) + f(0, -1, 0) - c, f(0, 0, 1) + f(0, 0, -1) - c];
        let xy = (f(1, 1, 0) + f(-1, -1, 0) - f(1, -1, 0) - f(-1, 1, 0)) / 4.0;
        let xz = (f(1, 0, 1) + f(-1, 0, -1) - f(1, 0, -1) - f(-1, 0, 1)) / 4.0;
        let yz = (f(0, 1, 1) + f(0, -1, -1) - f(0, 1, -1) - f(0, -1, 1)) / 4.0;
        let bend = |a: [f32; 3], b: [f32; 3]| {
            a[0] * (xx * b[0] + xy * b[1] + xz * b[2])
                + a[1] * (xy * b[0] + yy * b[1] + yz * b[2])
                + a[2] * (xz * b[0] + yz * b[1] + zz * b[2])
        };
        let (uu, uv, vv) = (bend(u, u), bend(u, v), bend(v, v));
        let [gu, gv] = [u, v].map(|a| g[0] * a[0] + g[1] * a[1] + g[2] * a[2]);
        let det = uu * vv - uv * uv;
        if !(det > 0.0 && uu < 0.0) {
            return [0.0; 3];
        }
        let (a, b) = ((uv * gv - vv * gu) / det, (uv * gu - uu * gv) / det);
        // A crest farther away belongs to another voxel: stop at the corner of this one.
        let shorten = (0.75f32.sqrt() / (a * a + b * b).sqrt()).min(1.0);
        [0, 1, 2].map(|c| shorten * (a * u[c] + b * v[c]))
    }
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { [0.0, 0.0, 1.0] }
}

/// Two unit vectors orthogonal to `t` and to each other.
fn plane_across(t: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let cross =
        |a: [f32; 3], b: [f32; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let axis = if t[0].abs() <= t[1].abs() && t[0].abs() <= t[2].abs() {
        [1.0, 0.0, 0.0]
    } else if t[1].abs() <= t[2].abs() {
        [0.0, 1.0, 0.0]
    } else {
        [0.0, 0.0, 1.0]
    };
    let u = unit(cross(t, axis));
    (u, cross(t, u))
}

#[cfg(test)]
mod tests;
