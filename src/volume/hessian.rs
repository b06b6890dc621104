//! Second derivatives of a volume at one scale, unseen voxels and borders included.
//!
//! Derivatives are taken by separable Gaussian kernels ([`super::gaussian`]). They need values where
//! there are none: beyond the tank's wall, at the ends of the volume, in voxels that too few views
//! see. A constant there (zero, say) would put a cliff and with it a ridge along the whole wall;
//! mirroring cannot follow a round wall. So unknown values within a kernel's reach are first filled by
//! the normalised convolution Σ g f m / Σ g m over the known ones (m = 1 where known, the same σ),
//! which continues the volume evenly along its border. Known values are never changed.
//!
//! A slab's derivatives need [`halo`] planes on either side: a radius for the kernels and another one
//! for the fill. Planes that lie outside the volume count as unknown, so slabs with their halo give the
//! bits of the whole volume.

use super::gaussian::{Kernels, correlate, radius};
use ndarray::ArrayView3;
use rayon::prelude::*;
use std::ops::Range;

/// Planes that a slab needs beyond its own on either side, as far as the volume has them.
pub fn halo(sigma_voxels: f64) -> usize {
    2 * radius(sigma_voxels)
}

/// The six second derivatives of one row: xx, yy, zz, xy, xz, yz per voxel².
pub type Row = [Vec<f32>; 6];

/// Pairs (derivative in x, derivative in y) of the plane-wise pass that the six derivatives are made
/// of: smooth, x, y, xx, yy, xy.
const PLANES: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1)];

/// For each of xx, yy, zz, xy, xz, yz: which of [`PLANES`], and the order of the derivative in z.
const OF_PLANES: [(usize, usize); 6] = [(3, 0), (4, 0), (0, 2), (5, 0), (1, 1), (2, 1)];

/// A slab differentiated in its planes; rows are finished across planes on demand.
pub struct Hessian {
    kernels: [Vec<f32>; 3],
    radius: usize,
    shape: (usize, usize),
    /// For planes from `inner.start - radius` on: the six plane-wise derivatives.
    planes: Vec<Vec<f32>>,
}

impl Hessian {
    /// Differentiates the planes `inner` of `slab` (z, y, x; NaN = unknown) at `sigma_voxels`. The slab
    /// holds [`halo`] planes beyond `inner` wherever the volume has them.
    pub fn new(slab: ArrayView3<f32>, inner: Range<usize>, sigma_voxels: f64) -> Self {
        let k = Kernels::new(sigma_voxels);
        let kernels = [k.smooth, k.first, k.second];
        let r = radius(sigma_voxels);
        let shape = (slab.shape()[1], slab.shape()[2]);
        let fill = Fill::new(slab, &kernels[0], r);
        let planes = (0..inner.len() + 2 * r)
            .into_par_iter()
            .map(|p| differentiate(&fill.plane((inner.start + p) as isize - r as isize), shape, r, &kernels))
            .collect();
        Self { kernels, radius: r, shape, planes }
    }

    /// An empty row for [`Self::row`].
    pub fn empty_row(&self) -> Row {
        std::array::from_fn(|_| vec![0.0; self.shape.1])
    }

    /// Derivatives of row `j` in the `k`-th plane of `inner`.
    pub fn row(&self, k: usize, j: usize, out: &mut Row) {
        let (ny, nx) = self.shape;
        for (out, (plane, order)) in out.iter_mut().zip(OF_PLANES) {
            let from = (plane * ny + j) * nx;
            let at = |z: isize| &self.planes[(k + self.radius).wrapping_add_signed(z)][from..from + nx];
            correlate(out, &self.kernels[order], order == 1, at);
        }
    }
}

/// Plane-wise derivatives of a filled plane that is `r` wider than `shape` on every side.
fn differentiate(filled: &[f32], (ny, nx): (usize, usize), r: usize, kernels: &[Vec<f32>; 3]) -> Vec<f32> {
    let wide = nx + 2 * r;
    // Along x: orders 0, 1, 2 for all rows, those beyond the plane too.
    let mut along_x = vec![0.0; 3 * (ny + 2 * r) * nx];
    for (order, part) in along_x.chunks_exact_mut((ny + 2 * r) * nx).enumerate() {
        for (j, out) in part.chunks_exact_mut(nx).enumerate() {
            let row = &filled[j * wide..(j + 1) * wide];
            correlate(out, &kernels[order], order == 1, |x| &row[r.wrapping_add_signed(x)..]);
        }
    }
    let mut planes = vec![0.0; 6 * ny * nx];
    for (part, (in_x, in_y)) in planes.chunks_exact_mut(ny * nx).zip(PLANES) {
        let source = &along_x[in_x * (ny + 2 * r) * nx..];
        for (j, out) in part.chunks_exact_mut(nx).enumerate() {
            let row = |y: isize| &source[(j + r).wrapping_add_signed(y) * nx..];
            correlate(out, &kernels[in_y], in_y == 1, row);
        }
    }
    planes
}

/// Fills unknown values by normalised convolution.
struct Fill<'a> {
    slab: ArrayView3<'a, f32>,
    smooth: &'a [f32],
    radius: usize,
    /// Per plane of the slab, wider by the radius on every side: Σ g f m over the plane, then Σ g m.
    sums: Vec<[Vec<f32>; 2]>,
}

impl<'a> Fill<'a> {
    fn new(slab: ArrayView3<'a, f32>, smooth: &'a [f32], radius: usize) -> Self {
        let (nz, ny, nx) = slab.dim();
        let (width, rows) = (nx + 2 * radius, ny + 2 * radius);
        let sums = (0..nz)
            .into_par_iter()
            .map(|k| {
                let mut source = [vec![0.0; nx + 4 * radius], vec![0.0; nx + 4 * radius]];
                // Sums along x of the known rows, with empty rows for two radii above and below.
                let mut along_x = [(); 2].map(|()| vec![0.0; (ny + 4 * radius) * width]);
                for j in 0..ny {
                    for i in 0..nx {
                        let value = slab[[k, j, i]];
                        let known = !value.is_nan();
                        source[0][2 * radius + i] = if known { value } else { 0.0 };
                        source[1][2 * radius + i] = f32::from(u8::from(known));
                    }
                    for (sum, source) in along_x.iter_mut().zip(&source) {
                        let from = (j + 2 * radius) * width;
                        correlate(&mut sum[from..from + width], smooth, false, |x| {
                            &source[radius.wrapping_add_signed(x)..]
                        });
                    }
                }
                along_x.map(|source| {
                    let mut sum = vec![0.0; rows * width];
                    for (j, out) in sum.chunks_exact_mut(width).enumerate() {
                        correlate(out, smooth, false, |y| &source[(j + radius).wrapping_add_signed(y) * width..]);
                    }
                    sum
                })
            })
            .collect();
        Self { slab, smooth, radius, sums }
    }

    /// Plane `k` of the slab, or beyond it by up to a radius, widened by a radius on every side: known
    /// values as they are, unknown ones filled, 0 where no known value is within reach.
    fn plane(&self, k: isize) -> Vec<f32> {
        let (nz, ny, nx) = self.slab.dim();
        let width = nx + 2 * self.radius;
        let empty = vec![0.0; width];
        let mut sums = [vec![0.0; width], vec![0.0; width]];
        let mut filled = vec![0.0; (ny + 2 * self.radius) * width];
        for (j, out) in filled.chunks_exact_mut(width).enumerate() {
            for (c, sum) in sums.iter_mut().enumerate() {
                correlate(sum, self.smooth, false, |z| match usize::try_from(k + z) {
                    Ok(plane) if plane < nz => &self.sums[plane][c][j * width..],
                    _ => &empty,
                });
            }
            for i in 0..width {
                out[i] = if sums[1][i] > 0.0 { sums[0][i] / sums[1][i] } else { 0.0 };
            }
            let row = j.wrapping_sub(self.radius);
            if let Some(plane) = usize::try_from(k).ok().filter(|&plane| plane < nz && row < ny) {
                for i in 0..nx {
                    let value = self.slab[[plane, row, i]];
                    if !value.is_nan() {
                        out[self.radius + i] = value;
                    }
                }
            }
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array3, Axis};

    fn all(volume: ArrayView3<f32>, inner: Range<usize>, sigma: f64) -> Vec<f32> {
        let hessian = Hessian::new(volume, inner.clone(), sigma);
        let mut row = hessian.empty_row();
        let mut out = Vec::new();
        for k in 0..inner.len() {
            for j in 0..volume.shape()[1] {
                hessian.row(k, j, &mut row);
                out.extend(row.iter().flatten());
            }
        }
        out
    }

    #[test]
    fn quadratics_are_differentiated_exactly_away_from_borders() {
        let volume = Array3::from_shape_fn((21, 23, 25), |(k, j, i)| {
            let (x, y, z) = (i as f32 - 12.0, j as f32 - 11.0, k as f32 - 10.0);
            0.3 * x * x - 0.2 * y * y + 0.1 * z * z + 0.4 * x * y - 0.5 * x * z + 0.6 * y * z + x - 2.0
        });
        let hessian = Hessian::new(volume.view(), 10..11, 0.9);
        let mut row = hessian.empty_row();
        hessian.row(0, 11, &mut row);
        for (got, expected) in row.iter().zip([0.6, -0.4, 0.2, 0.4, -0.5, 0.6]) {
            assert!((got[12] - expected).abs() < 1e-4, "{} for {expected}", got[12]);
        }
    }

    #[test]
    fn an_even_volume_has_no_ridges_at_its_borders_nor_at_unknown_voxels() {
        let volume = Array3::from_shape_fn((12, 20, 20), |(k, j, i)| {
            let rho = (j as f32 - 9.5).hypot(i as f32 - 9.5);
            if rho > 8.0 || (k, j) == (5, 9) { f32::NAN } else { 0.7 }
        });
        let hessian = Hessian::new(volume.view(), 0..12, 1.0);
        let mut row = hessian.empty_row();
        for ((k, j, i), value) in volume.indexed_iter() {
            hessian.row(k, j, &mut row);
            if !value.is_nan() {
                assert!(row.iter().all(|d| d[i].abs() < 2e-6), "{:?} at {k} {j} {i}", row.each_ref().map(|d| d[i]));
            }
        }
    }

    #[test]
    fn slabs_with_their_halo_equal_the_whole_bit_for_bit() {
        let volume = Array3::from_shape_fn((37, 9, 11), |(k, j, i)| {
            let n = (k * 7919 + j * 104_729 + i * 1_299_709) % 1000;
            if n < 150 { f32::NAN } else { n as f32 / 1000.0 }
        });
        for sigma in [0.5, 0.8] {
            let whole = all(volume.view(), 0..37, sigma);
            let mut bricks = Vec::new();
            for (from, to) in [(0, 3), (3, 19), (19, 20), (20, 37)] {
                let (a, b) = (from.max(halo(sigma)) - halo(sigma), (to + halo(sigma)).min(37));
                bricks.extend(all(volume.slice_axis(Axis(0), (a..b).into()), from - a..to - a, sigma));
            }
            assert!(whole.iter().zip(&bricks).all(|(x, y)| x.to_bits() == y.to_bits()));
            assert_eq!(whole.len(), bricks.len());
        }
    }
}
