//! Second derivatives of a volume at one scale, plane by plane, unseen voxels and borders included.
//!
//! Derivatives are taken by separable Gaussian kernels ([`super::gaussian`]), along z first. They need values where
//! there are none: beyond the tank's wall, at the ends of the volume, in voxels that too few views
//! see. A constant there (zero, say) would put a cliff and with it a ridge along the whole wall;
//! mirroring cannot follow a round wall. So unknown values within a kernel's reach are first filled by
//! the normalised convolution Σ g f m / Σ g m over the known ones (m = 1 where known, the same σ),
//! which continues the volume evenly along its border. Known values are never changed.
//!
//! The derivatives of a plane need [`halo`] planes on either side: a radius for the kernels and another one
//! for the fill. Planes that lie outside the volume count as unknown. Planes come in order, each one is filled
//! once, and only those within reach of the next derivatives are held: the bits do not depend on how many come
//! at a time.

use super::gaussian::{Kernels, correlate, radius};
use ndarray::ArrayView2;
use pulp::Arch;
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;

/// Planes that the derivatives of a plane need beyond it on either side, as far as the volume has them.
pub fn halo(sigma_voxels: f64) -> usize {
    2 * radius(sigma_voxels)
}

/// The six second derivatives of one row: xx, yy, zz, xy, xz, yz per voxel².
pub type Row = [Vec<f32>; 6];

/// For each of xx, yy, zz, xy, xz, yz: orders of the derivative in x, y, z.
const ORDERS: [[usize; 3]; 6] = [[2, 0, 0], [0, 2, 0], [0, 0, 2], [1, 1, 0], [1, 0, 1], [0, 1, 1]];

/// One plane of a volume.
#[derive(Debug)]
pub struct Plane {
    /// Values (y, x), 0 where unknown.
    value: Vec<f32>,
    /// 1 where known, else 0.
    known: Vec<f32>,
}

/// Neighbouring planes of a volume, those that are still needed.
#[derive(Debug, Default)]
pub struct Planes {
    first: usize,
    planes: VecDeque<Plane>,
}

impl Planes {
    /// Adds the next plane (y, x; NaN = unknown).
    pub fn push(&mut self, plane: ArrayView2<f32>) {
        self.planes.push_back(Plane {
            value: plane.iter().map(|&v| if v.is_nan() { 0.0 } else { v }).collect(),
            known: plane.iter().map(|v| f32::from(u8::from(!v.is_nan()))).collect(),
        });
    }

    /// One behind the last plane.
    pub fn end(&self) -> usize {
        self.first + self.planes.len()
    }

    /// Drops the planes before `k`.
    pub fn forget(&mut self, k: usize) {
        let count = k.saturating_sub(self.first).min(self.planes.len());
        self.planes.drain(..count);
        self.first += count;
    }

    /// Columns from the first to the last known one of row `j` of `nx` voxels in plane `k`; empty where nothing is
    /// known.
    pub fn known(&self, k: usize, j: usize, nx: usize) -> Range<usize> {
        let row = &self.planes[k - self.first].known[j * nx..(j + 1) * nx];
        let first = row.iter().position(|&m| m > 0.0).unwrap_or(0);
        first..row.iter().rposition(|&m| m > 0.0).map_or(first, |last| last + 1)
    }

    /// Whether a voxel of a held plane is known.
    pub fn is_known(&self, k: usize, at: usize) -> bool {
        self.planes[k - self.first].known[at] > 0.0
    }

    fn get(&self, k: isize) -> Option<&Plane> {
        self.planes.get(usize::try_from(k).ok()?.checked_sub(self.first)?)
    }
}

/// The filled planes of a volume that derivatives are taken from.
#[derive(Debug)]
pub struct Hessian {
    kernels: [Vec<f32>; 3],
    radius: usize,
    shape: (usize, usize),
    /// Index of the first filled plane held; the volume begins a radius behind the first one filled.
    first: isize,
    /// Filled planes, wider than the volume by the radius on every side.
    filled: VecDeque<Vec<f32>>,
}

/// What the derivatives of a plane are made in.
#[derive(Debug)]
pub struct Scratch {
    /// Derivatives of a row of filled values along z, by order.
    along_z: [Vec<f32>; 3],
    /// For each of [`ORDERS`]: the derivatives along z and x of all rows, a radius beyond the plane too.
    along_x: Vec<Vec<f32>>,
}

impl Hessian {
    /// Derivatives at `sigma_voxels` of planes of `shape` (y, x).
    pub fn new(shape: (usize, usize), sigma_voxels: f64) -> Self {
        let k = Kernels::new(sigma_voxels);
        let radius = radius(sigma_voxels);
        Self {
            kernels: [k.smooth, k.first, k.second],
            radius,
            shape,
            first: -(radius as isize),
            filled: VecDeque::new(),
        }
    }

    /// Makes ready the derivatives of all planes before `end` and drops what those from `begin` on do not need.
    /// `known` holds the planes from the last `end` on up to [`halo`] beyond the new one.
    pub fn advance(&mut self, known: &Planes, begin: usize, end: usize) {
        if begin >= end {
            return;
        }
        let gone = (begin as isize - self.radius as isize - self.first).clamp(0, self.filled.len() as isize);
        self.filled.drain(..gone as usize);
        self.first += gone;
        let next = self.first + self.filled.len() as isize;
        let fill = |k| Arch::new().dispatch(Fill { hessian: self, known, k });
        let filled: Vec<Vec<f32>> = (next..(end + self.radius) as isize).into_par_iter().map(fill).collect();
        self.filled.extend(filled);
    }

    /// Room for [`Self::plane`].
    pub fn scratch(&self) -> Scratch {
        let ((ny, nx), r) = (self.shape, self.radius);
        Scratch {
            along_z: std::array::from_fn(|_| vec![0.0; nx + 2 * r]),
            along_x: vec![vec![0.0; (ny + 2 * r) * nx]; ORDERS.len()],
        }
    }

    /// An empty row for [`Self::row`].
    pub fn empty_row(&self) -> Row {
        std::array::from_fn(|_| vec![0.0; self.shape.1])
    }

    /// Differentiates plane `k` along z and x.
    #[inline(always)]
    pub fn plane(&self, k: usize, scratch: &mut Scratch) {
        let ((ny, nx), r) = (self.shape, self.radius);
        let wide = nx + 2 * r;
        let middle = (k as isize - self.first) as usize;
        for j in 0..ny + 2 * r {
            for (order, out) in scratch.along_z.iter_mut().enumerate() {
                let row = |z: isize| &self.filled[middle.wrapping_add_signed(z)][j * wide..(j + 1) * wide];
                correlate(out, &self.kernels[order], order == 1, row);
            }
            for (out, [x, _, z]) in scratch.along_x.iter_mut().zip(ORDERS) {
                let source = &scratch.along_z[z];
                let out = &mut out[j * nx..(j + 1) * nx];
                correlate(out, &self.kernels[x], x == 1, |x| &source[r.wrapping_add_signed(x)..]);
            }
        }
    }

    /// Derivatives of the columns `columns` of row `j` of the plane in `scratch`.
    #[inline(always)]
    pub fn row(&self, scratch: &Scratch, j: usize, columns: Range<usize>, out: &mut Row) {
        let nx = self.shape.1;
        for ((out, source), [_, y, _]) in out.iter_mut().zip(&scratch.along_x).zip(ORDERS) {
            let row = |y: isize| &source[(j + self.radius).wrapping_add_signed(y) * nx + columns.start..];
            correlate(&mut out[columns.clone()], &self.kernels[y], y == 1, row);
        }
    }
}

/// Plane `k` of the volume, or beyond it by up to a radius, widened by a radius on every side: known
/// values as they are, unknown ones filled, 0 where no known value is within reach.
struct Fill<'a> {
    hessian: &'a Hessian,
    known: &'a Planes,
    k: isize,
}

impl pulp::WithSimd for Fill<'_> {
    type Output = Vec<f32>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Vec<f32> {
        let Self { hessian: Hessian { kernels, radius: r, shape: (ny, nx), .. }, known, k } = self;
        let (r, ny, nx, smooth) = (*r, *ny, *nx, &kernels[0]);
        let width = nx + 2 * r;
        let mut filled = vec![0.0; (ny + 2 * r) * width];
        let empty = vec![0.0; nx];
        let mut padded = vec![0.0; nx + 4 * r];
        // Sums along z and x of Σ g f m and Σ g m, with empty rows for two radii above and below.
        let along_x = [0, 1].map(|part| {
            let mut out = vec![0.0; (ny + 4 * r) * width];
            for j in 0..ny {
                correlate(&mut padded[2 * r..2 * r + nx], smooth, false, |z| match known.get(k + z) {
                    Some(plane) => &(if part == 0 { &plane.value } else { &plane.known })[j * nx..(j + 1) * nx],
                    None => &empty,
                });
                let from = (j + 2 * r) * width;
                correlate(&mut out[from..from + width], smooth, false, |x| &padded[r.wrapping_add_signed(x)..]);
            }
            out
        });
        let mut sums = [vec![0.0; width], vec![0.0; width]];
        for (j, out) in filled.chunks_exact_mut(width).enumerate() {
            for (sum, source) in sums.iter_mut().zip(&along_x) {
                correlate(sum, smooth, false, |y| &source[(j + r).wrapping_add_signed(y) * width..]);
            }
            for i in 0..width {
                out[i] = if sums[1][i] > 0.0 { sums[0][i] / sums[1][i] } else { 0.0 };
            }
            let row = j.wrapping_sub(r);
            if let Some(plane) = known.get(k).filter(|_| row < ny) {
                let (value, is_known) = (&plane.value[row * nx..][..nx], &plane.known[row * nx..][..nx]);
                for i in 0..nx {
                    out[r + i] = if is_known[i] > 0.0 { value[i] } else { out[r + i] };
                }
            }
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array3, ArrayView3, Axis};

    /// Calls `each` with the derivatives of every row of the volume, given in pieces of `step` planes.
    fn rows(volume: ArrayView3<f32>, sigma: f64, step: usize, mut each: impl FnMut(usize, usize, &Row)) {
        let (nz, ny, nx) = volume.dim();
        let mut hessian = Hessian::new((ny, nx), sigma);
        let (mut scratch, mut row) = (hessian.scratch(), hessian.empty_row());
        let (mut planes, mut done) = (Planes::default(), 0);
        for from in (0..nz).step_by(step) {
            volume.slice_axis(Axis(0), (from..(from + step).min(nz)).into()).outer_iter().for_each(|p| planes.push(p));
            let end = if planes.end() == nz { nz } else { planes.end().saturating_sub(halo(sigma)) };
            hessian.advance(&planes, done, end);
            for k in done..end {
                hessian.plane(k, &mut scratch);
                for j in 0..ny {
                    hessian.row(&scratch, j, 0..nx, &mut row);
                    each(k, j, &row);
                }
            }
            done = end;
            planes.forget(done);
        }
        assert_eq!(done, nz);
    }

    #[test]
    fn quadratics_are_differentiated_exactly_away_from_borders() {
        let volume = Array3::from_shape_fn((21, 23, 25), |(k, j, i)| {
            let (x, y, z) = (i as f32 - 12.0, j as f32 - 11.0, k as f32 - 10.0);
            0.3 * x * x - 0.2 * y * y + 0.1 * z * z + 0.4 * x * y - 0.5 * x * z + 0.6 * y * z + x - 2.0
        });
        rows(volume.view(), 0.9, 21, |k, j, row| {
            for (got, expected) in row.iter().zip([0.6, -0.4, 0.2, 0.4, -0.5, 0.6]) {
                let far = (k, j) != (10, 11);
                assert!(far || (got[12] - expected).abs() < 1e-4, "{} for {expected}", got[12]);
            }
        });
    }

    #[test]
    fn an_even_volume_has_no_ridges_at_its_borders_nor_at_unknown_voxels() {
        let volume = Array3::from_shape_fn((12, 20, 20), |(k, j, i)| {
            let rho = (j as f32 - 9.5).hypot(i as f32 - 9.5);
            if rho > 8.0 || (k, j) == (5, 9) { f32::NAN } else { 0.7 }
        });
        rows(volume.view(), 1.0, 12, |k, j, row| {
            for i in (0..20).filter(|&i| !volume[[k, j, i]].is_nan()) {
                assert!(row.iter().all(|d| d[i].abs() < 2e-6), "{:?} at {k} {j} {i}", row.each_ref().map(|d| d[i]));
            }
        });
    }

    #[test]
    fn pieces_equal_the_whole_bit_for_bit() {
        let volume = Array3::from_shape_fn((37, 9, 45), |(k, j, i)| {
            let n = (k * 7919 + j * 104_729 + i * 1_299_709) % 1000;
            if n < 150 { f32::NAN } else { n as f32 / 1000.0 }
        });
        let all = |sigma, step| {
            let mut out = Vec::new();
            rows(volume.view(), sigma, step, |_, _, row| out.extend(row.iter().flatten().map(|x| x.to_bits())));
            out
        };
        for sigma in [0.5, 0.8] {
            let whole = all(sigma, 37);
            for step in [1, 3, 16] {
                assert!(whole == all(sigma, step), "sigma {sigma}, {step} planes at a time");
            }
        }
    }
}
