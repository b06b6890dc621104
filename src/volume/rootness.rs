//! Rootness: how much each voxel's neighbourhood looks like a root, over one or several scales.  Paper 2.5.
//!
//! At every scale σ the Hessian ([`super::hessian`]) is normalised by σ², decomposed in closed form, and
//! measured by equation 16 ([`super::sato`]); the greatest measure wins (on a tie the smaller index),
//! and with it its scale and its tangent, the eigenvector of λ1. Rootness has the unit of the volume.
//! Where the volume is unknown, rootness is NaN, the tangent zero.

use super::grid::FINEST_MM;
use super::hessian::{self, Hessian, Planes, Row, Scratch};
use super::sato::Sato;
use crate::error::{Error, Result};
use crate::math::eigen3::Sym3;
use crate::photo::colour;
use ndarray::{Array3, Array4, ArrayView3, ArrayView4, ArrayViewMut2, ArrayViewMut3, Axis};
use pulp::Arch;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Parameters of rootness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Rootness {
    /// Standard deviations of the Gaussian, mm, each at least 0.4 voxels (narrower ones cannot be sampled) and at most 20.
    /// Left empty, two that suit the roots' width as the photographs show it ([`scales_for`]).
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
        Self { sigma: Vec::new(), gamma23, gamma12, alpha, dark: false }
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
        if self.sigma.len() > 255 {
            faults.push(Error::usage("rootness.sigma names over 255 scales").help("give one or several, in mm"));
        }
        // A spacing that is none, or makes no grid, is told of by the grid.
        let is_odd = |sigma: &&f64| spacing_mm >= FINEST_MM && !(0.4..=20.0).contains(&(*sigma / spacing_mm));
        for sigma in self.sigma.iter().filter(is_odd) {
            faults.push(
                Error::usage(format!("grid.spacing = {spacing_mm} mm does not suit rootness.sigma = {sigma} mm"))
                    .help("a scale lies between 0.4 and 20 voxels: change grid.spacing or the scale"),
            );
        }
        faults.extend(self.sato().check().err());
        Error::many(faults)
    }

    /// Planes beyond a plane that its rootness depends on, on either side.
    pub fn halo(&self, spacing_mm: f64) -> usize {
        self.sigma.iter().map(|s| hessian::halo(s / spacing_mm)).max().unwrap_or(0)
    }
}

/// Width, in standard deviations, that a Gaussian has whose area is spread evenly at its height: √(2π).
const EQUIVALENT: f64 = 2.506_628_274_631;

/// Scales, mm, for roots of that width in the photographs, mm: a line with a Gaussian profile of deviation s answers most at
/// σ = s (σ² s² / (s² + σ²)² is greatest there). Not under a voxel, where derivatives are coarse; a voxel where no width is
/// known. And twice that: main roots are thicker than the typical one, and on a thick root's flat top a small scale sees several lines.
pub fn scales_for(width_mm: Option<f64>, spacing_mm: f64) -> [f64; 2] {
    let hundredths = |mm: f64| (100.0 * mm).round() / 100.0;
    let typical = hundredths(width_mm.unwrap_or(0.0) / EQUIVALENT).max(spacing_mm).min(10.0 * spacing_mm);
    [typical, 2.0 * typical]
}

/// Rootness of some planes.
#[derive(Debug, Clone, PartialEq)]
pub struct RootVolume {
    /// (z, y, x), unit of the volume, 0 or more; NaN = unknown.
    pub rootness: Array3<f32>,
    /// (z, y, x, [x y z]): unit tangent times 127, rounded (0.4°); zero where rootness is 0 or unknown.
    pub tangent: Array4<i8>,
    /// (z, y, x): index of the winning scale.
    pub scale: Array3<u8>,
}

/// Gray of a merged volume (z, y, x, 3) of colours or (z, y, x, 1); NaN stays NaN.
pub fn gray(colour: ArrayView4<f32>) -> Array3<f32> {
    if colour.dim().3 == 1 {
        return colour.index_axis(Axis(3), 0).to_owned();
    }
    colour.map_axis(Axis(3), |rgb| colour::gray([rgb[0], rgb[1], rgb[2]]))
}

/// Rootness of a whole volume (z, y, x; NaN = unknown).
///
/// # Errors
/// Where a parameter is out of range.
pub fn rootness(volume: ArrayView3<f32>, spacing_mm: f64, params: &Rootness) -> Result<RootVolume> {
    Ok(Stream::new(volume.dim().into(), spacing_mm, params)?.push(volume))
}

/// Rootness of a volume whose planes come one after another; memory does not grow with its depth.
#[derive(Debug)]
pub struct Stream {
    shape: [usize; 3],
    halo: usize,
    /// -1 where roots are dark.
    sign: f64,
    sato: Sato,
    /// Planes from the next one to be measured on.
    planes: Planes,
    /// Each scale: σ in voxels, and the derivatives.
    scales: Vec<(f64, Hessian)>,
    /// Planes measured so far.
    done: usize,
}

impl Stream {
    /// Rootness of a volume of `shape` (z, y, x) with voxels of the edge `spacing_mm`.
    ///
    /// # Errors
    /// Where a parameter is out of range, or no scale is given.
    pub fn new(shape: [usize; 3], spacing_mm: f64, params: &Rootness) -> Result<Self> {
        params.check(spacing_mm)?;
        if params.sigma.is_empty() {
            return Err(Error::usage("rootness needs a scale").help("give rootness.sigma, in mm"));
        }
        let scale = |sigma| (sigma / spacing_mm, Hessian::new((shape[1], shape[2]), sigma / spacing_mm));
        Ok(Self {
            shape,
            halo: params.halo(spacing_mm),
            sign: if params.dark { -1.0 } else { 1.0 },
            sato: params.sato(),
            planes: Planes::default(),
            scales: params.sigma.iter().map(|&sigma| scale(sigma)).collect(),
            done: 0,
        })
    }

    /// Takes the next planes (z, y, x; NaN = unknown) and gives the rootness of those that can be measured now:
    /// they follow each other over the calls, [`Rootness::halo`] planes behind; after the last plane all are given.
    pub fn push(&mut self, slab: ArrayView3<f32>) -> RootVolume {
        slab.outer_iter().for_each(|plane| self.planes.push(plane));
        let [depth, ny, nx] = self.shape;
        let held = self.planes.end();
        let end = if held >= depth { depth } else { held.saturating_sub(self.halo).max(self.done) };
        for (_, hessian) in &mut self.scales {
            hessian.advance(&self.planes, self.done, end);
        }
        let count = end - self.done;
        let mut out = RootVolume {
            rootness: Array3::from_elem((count, ny, nx), f32::NAN),
            tangent: Array4::zeros((count, ny, nx, 3)),
            scale: Array3::zeros((count, ny, nx)),
        };
        let planes = out.rootness.axis_iter_mut(Axis(0)).into_par_iter();
        planes.zip(out.tangent.axis_iter_mut(Axis(0))).zip(out.scale.axis_iter_mut(Axis(0))).enumerate().for_each_init(
            || self.scales.iter().map(|(_, hessian)| (hessian.scratch(), hessian.empty_row())).collect(),
            |scratch: &mut Vec<(Scratch, Row)>, (k, ((rootness, tangent), scale))| {
                let k = self.done + k;
                Arch::new().dispatch(Measure { stream: self, k, scratch, rootness, tangent, scale });
            },
        );
        self.done = end;
        self.planes.forget(end);
        out
    }
}

/// The measure of one plane as a task for [`Arch::dispatch`].
struct Measure<'a> {
    stream: &'a Stream,
    k: usize,
    scratch: &'a mut [(Scratch, Row)],
    rootness: ArrayViewMut2<'a, f32>,
    tangent: ArrayViewMut3<'a, i8>,
    scale: ArrayViewMut2<'a, u8>,
}

impl pulp::WithSimd for Measure<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self { stream: Stream { planes, scales, sato, sign, .. }, k, scratch, .. } = self;
        let (mut rootness, mut tangent, mut scale) = (self.rootness, self.tangent, self.scale);
        let (ny, nx) = rootness.dim();
        if (0..ny).all(|j| planes.known(k, j, nx).is_empty()) {
            return;
        }
        for (index, ((sigma, hessian), (scratch, row))) in scales.iter().zip(scratch).enumerate() {
            hessian.plane(k, scratch);
            for j in 0..ny {
                let columns = planes.known(k, j, nx);
                hessian.row(scratch, j, columns.clone(), row);
                for i in columns.filter(|i| planes.is_known(k, j * nx + i)) {
                    if index == 0 {
                        rootness[[j, i]] = 0.0;
                    }
                    let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|c| sign * f64::from(row[c][i]));
                    let m = Sym3 { xx, yy, zz, xy, xz, yz };
                    if !may_be_line(&m) {
                        continue;
                    }
                    let lambda = m.eigenvalues();
                    let value = (sigma * sigma * sato.measure(lambda)) as f32;
                    if value > rootness[[j, i]] {
                        rootness[[j, i]] = value;
                        scale[[j, i]] = index as u8;
                        for (c, t) in m.principal_direction(lambda[0]).into_iter().enumerate() {
                            tangent[[j, i, c]] = (t * 127.0).round() as i8;
                        }
                    }
                }
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::concatenate;

    #[test]
    fn planes_given_in_pieces_measure_as_the_whole_bit_for_bit() {
        let volume = Array3::from_shape_fn((31, 12, 40), |(k, j, i)| {
            let n = (k * 7919 + j * 104_729 + i * 1_299_709) % 1000;
            if n < 60 || j == 0 || k == 30 { f32::NAN } else { n as f32 / 1000.0 }
        });
        let params = Rootness { sigma: vec![0.5, 1.2], ..Rootness::default() };
        let whole = rootness(volume.view(), 1.0, &params).unwrap();
        assert!(whole.scale.iter().any(|&s| s == 0) && whole.scale.iter().any(|&s| s == 1));
        for step in [1, 5, 16] {
            let mut stream = Stream::new([31, 12, 40], 1.0, &params).unwrap();
            let parts: Vec<RootVolume> =
                volume.axis_chunks_iter(Axis(0), step).map(|planes| stream.push(planes)).collect();
            let values: Vec<_> = parts.iter().map(|p| p.rootness.view()).collect();
            let values = concatenate(Axis(0), &values).unwrap();
            assert!(values.iter().zip(&whole.rootness).all(|(a, b)| a.to_bits() == b.to_bits()), "{step} at a time");
            let tangents: Vec<_> = parts.iter().map(|p| p.tangent.view()).collect();
            assert_eq!(concatenate(Axis(0), &tangents).unwrap(), whole.tangent);
            let scales: Vec<_> = parts.iter().map(|p| p.scale.view()).collect();
            assert_eq!(concatenate(Axis(0), &scales).unwrap(), whole.scale);
        }
        assert!(whole.rootness[[30, 5, 5]].is_nan() && whole.rootness[[3, 0, 5]].is_nan());
    }

    /// Bright rods along z of Gaussian profile, standard deviations 1 and 3 voxels; the first planes' ends are unknown.
    fn rods() -> Array3<f32> {
        let mut volume = Array3::from_shape_fn((20, 24, 44), |(_, j, i)| {
            let rod = |x: f32, sd: f32| {
                let (dx, dy) = (i as f32 - x, j as f32 - 12.0);
                (-(dx * dx + dy * dy) / (2.0 * sd * sd)).exp()
            };
            rod(10.0, 1.0) + rod(30.0, 3.0)
        });
        volume.slice_axis_mut(Axis(0), (..2).into()).fill(f32::NAN);
        volume
    }

    fn whole(volume: &Array3<f32>, params: &Rootness) -> RootVolume {
        rootness(volume.view(), 1.0, params).unwrap()
    }

    #[test]
    fn the_strongest_scale_wins_and_is_kept() {
        let (volume, sigma) = (rods(), vec![1.0, 3.0]);
        let both = whole(&volume, &Rootness { sigma: sigma.clone(), ..Rootness::default() });
        assert_eq!([both.scale[[12, 12, 10]], both.scale[[12, 12, 30]]], [0, 1]);
        let alone = sigma.iter().map(|&s| whole(&volume, &Rootness { sigma: vec![s], ..Rootness::default() }));
        let alone: Vec<RootVolume> = alone.collect();
        for (at, value) in both.rootness.indexed_iter().filter(|(_, value)| !value.is_nan()) {
            let [narrow, wide] = [alone[0].rootness[at], alone[1].rootness[at]];
            assert_eq!(*value, narrow.max(wide), "{at:?}");
            assert_eq!(both.scale[at], u8::from(wide > narrow), "{at:?}");
        }
        // Normalised by σ², both rods count about alike although the wide one bends nine times less.
        let ratio = both.rootness[[12, 12, 10]] / both.rootness[[12, 12, 30]];
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
        assert_eq!([0, 1, 2].map(|c| both.tangent[[12, 12, 30, c]].abs()), [0, 0, 127]);
    }

    #[test]
    fn dark_roots_before_a_bright_room_count_as_bright_ones_before_a_dark_one() {
        let volume = rods();
        let one = || Rootness { sigma: vec![1.0], ..Rootness::default() };
        let bright = whole(&volume, &one());
        let negative = volume.mapv(|v| 1.0 - v);
        let dark = whole(&negative, &Rootness { dark: true, ..one() });
        for (at, value) in bright.rootness.indexed_iter().filter(|(_, value)| !value.is_nan()) {
            assert!((dark.rootness[at] - value).abs() < 1e-4, "{at:?}");
        }
        assert!(whole(&negative, &one()).rootness[[12, 12, 10]] < 1e-3);
    }

    #[test]
    fn what_is_unknown_stays_so_and_neither_ends_a_root_nor_makes_one() {
        let out = whole(&rods(), &Rootness { sigma: vec![1.0], ..Rootness::default() });
        assert!(out.rootness.slice_axis(Axis(0), (..2).into()).iter().all(|v| v.is_nan()));
        assert!(out.tangent.slice_axis(Axis(0), (..2).into()).iter().all(|&t| t == 0));
        let (end, middle) = (out.rootness[[2, 12, 10]], out.rootness[[12, 12, 10]]);
        // What continues it is blurred, so it fades there, but neither ends nor flares.
        assert!((0.6..1.05).contains(&(end / middle)), "{end} at the border, {middle} inside");
    }

    #[test]
    fn the_scale_follows_the_roots_width_but_not_under_a_voxel() {
        assert_eq!(
            [Some(1.5), Some(0.5), None].map(|width| scales_for(width, 0.4)),
            [[0.6, 1.2], [0.4, 0.8], [0.4, 0.8]]
        );
    }
}
