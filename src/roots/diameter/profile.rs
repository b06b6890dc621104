//! The light of one photograph about one centreline point.

use super::DiameterParams;
use super::clutter::Clutter;
use super::track::{Beads, Track};
use crate::optics::{Vec3, ViewMap};
use crate::photo::{Depth, Photograph, colour};
use ndarray::{Array2, Array3, Axis};

/// A pixel position: x = column u, y = row v.
pub type Pixel = nalgebra::Vector2<f64>;
/// Derivative of the pixel by the point in the tank, px/mm.
pub type Jacobian = nalgebra::Matrix2x3<f64>;

/// A photograph with its way of seeing.
#[derive(Debug, Clone)]
pub struct Sight<'a> {
    /// From the water to the photograph's own pixels (lens distortion included).
    pub map: &'a ViewMap,
    /// Linear light along the roots' colour axis.
    pub light: Array2<f32>,
}

/// Step of the numeric derivative, mm: far below a pixel, far above rounding.
const STEP_MM: f64 = 0.02;

impl<'a> Sight<'a> {
    /// `photograph` as taken, `map` for the lens that took it, `axis` the weights of the photograph's codes that tell roots
    /// from what is behind them. Light is linear, since blur is; a channel counts with the weight of its codes at its
    /// mean.
    pub fn new(map: &'a ViewMap, photograph: &Photograph, axis: [f64; 3]) -> Self {
        let light = match photograph {
            Photograph::Eight(codes) => light(codes, axis),
            Photograph::Sixteen(steps) => light(steps, axis),
        };
        Self { map, light }
    }

    /// Pixel of a point that the view sees unhindered through a regular ray, else none.
    pub fn pixel(&self, point_mm: &Vec3) -> Option<Pixel> {
        let p = self.map.project(point_mm)?;
        (p.clear && p.distance_mm < STEP_MM && self.map.view().holds(p.u, p.v)).then(|| Pixel::new(p.u, p.v))
    }

    /// Derivative of the pixel by the point that is seen at `pixel`.
    pub fn jacobian(&self, point_mm: &Vec3, pixel: &Pixel) -> Option<Jacobian> {
        let column = |axis: usize| {
            let mut moved = *point_mm;
            moved[axis] += STEP_MM;
            self.pixel(&moved).map(|there| (there - pixel) / STEP_MM)
        };
        Some(Jacobian::from_columns(&[column(0)?, column(1)?, column(2)?]))
    }
}

/// Linear light along the axis, whose weights are those of codes.
fn light<T: Depth>(photograph: &Array3<T>, axis: [f64; 3]) -> Array2<f32> {
    let (code, most) = (usize::from(T::STEPS), usize::from(T::GREATEST));
    let linear: Vec<f32> = (0..=most).map(|v| colour::linear_of_srgb(v as f32 / most as f32)).collect();
    let (height, width, _) = photograph.dim();
    let mut weights = [0, 1, 2].map(|c| {
        let steps: u64 = photograph.index_axis(Axis(2), c).iter().map(|x| u64::from(x.steps())).sum();
        let mean = (steps as usize / (height * width).max(1)).clamp(code, most - code);
        axis[c] / f64::from(linear[mean + code] - linear[mean - code])
    });
    let sum: f64 = weights.iter().map(|w| w.abs()).sum();
    weights.iter_mut().for_each(|w| *w /= sum.max(1e-300));
    let weights = weights.map(|w| w as f32);
    Array2::from_shape_fn((height, width), |(v, u)| {
        (0..3).map(|c| weights[c] * linear[usize::from(photograph[[v, u, c]].steps())]).sum::<f32>()
    })
}

/// The light about a stretch of root in one photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Distance across the projected line, px, and light, of every pixel taken.
    pub pixels: Vec<(f64, f64)>,
    /// Scale across the line, px/mm.
    pub scale: f64,
    /// Change of the distance across the line, px, per mm of the point's way.
    pub across: Vec3,
    /// Half width of the strip that the pixels come from, px.
    pub half_px: f64,
}

/// Share of the pixels within the root's own width that must be free of other roots.
const FREE: f64 = 0.6;

/// A root in one photograph.
#[derive(Debug, Clone, Copy)]
pub struct Seen<'a> {
    /// The photograph.
    pub sight: &'a Sight<'a>,
    /// What covers what in it.
    pub clutter: &'a Clutter<'a>,
    /// Where it shows the root's beads.
    pub track: &'a Track,
}

/// The profile about bead `b` (one with a derivative) of root `number` of the list, `radius_mm` thick, in one
/// photograph; none where the stretch is not seen, seen end on, or covered by other roots.
pub fn profile(
    seen: &Seen<'_>,
    beads: &Beads,
    number: usize,
    b: usize,
    radius_mm: f64,
    params: &DiameterParams,
) -> Option<Profile> {
    let Seen { sight, clutter, track } = seen;
    let (centre, jacobian) = (track.pixels[b]?, track.jacobian(b)?);
    let reach = (params.stretch_mm / params.bead_mm()).round().max(1.0) as usize;
    let ends = (b.saturating_sub(reach), (b + reach).min(beads.places.len() - 1));
    let mut line = Vec::with_capacity(ends.1 - ends.0 + 1);
    for pixel in &track.pixels[ends.0..=ends.1] {
        line.push((*pixel)?);
    }
    let (first, last) = (line[0], line[line.len() - 1]);
    let along = (last - first).try_normalize(1e-9)?;
    let across = Pixel::new(-along.y, along.x);
    let tangent = (beads.places[ends.1] - beads.places[ends.0]).try_normalize(1e-9)?;
    // The view's direction in the water moves no pixel: it spans the kernel of the Jacobian.
    let (right, down) = (jacobian.row(0).transpose(), jacobian.row(1).transpose());
    let view = right.cross(&down).try_normalize(1e-12)?;
    let side = view.cross(&tangent);
    // Seen nearly end on, the stretch is a spot, not a bar.
    if side.norm() < 0.5 {
        return None;
    }
    let scale = (jacobian * side.normalize()).dot(&across).abs();
    let expected = 2.0 * radius_mm * scale;
    let half = 0.75 * expected + params.margin_px;
    let length = (last - first).norm().max(2.0);
    let reach = half.hypot(0.5 * length) + 1.0;
    let (height, width) = sight.light.dim();
    let range = |centre: f64, size: usize| {
        (centre - reach).ceil().max(0.0) as usize..((centre + reach).floor() + 1.0).clamp(0.0, size as f64) as usize
    };
    let mut pixels = Vec::new();
    let (mut own, mut free) = (0u32, 0u32);
    for v in range(centre.y, height) {
        for u in range(centre.x, width) {
            let at = Pixel::new(u as f64, v as f64);
            let t = (at - centre).dot(&along);
            if t.abs() > 0.5 * length {
                continue;
            }
            let x = offset(&line, &at, &across);
            if x.abs() > half {
                continue;
            }
            let foreign = clutter.is_foreign(v, u, number);
            if x.abs() <= 0.5 * expected + 1.0 {
                own += 1;
                free += u32::from(!foreign);
            }
            if !foreign {
                pixels.push((x, f64::from(sight.light[[v, u]])));
            }
        }
    }
    (f64::from(free) >= FREE * f64::from(own) && pixels.len() >= 12).then_some(Profile {
        pixels,
        scale,
        across: jacobian.transpose() * across,
        half_px: half,
    })
}

/// Signed distance of a pixel from the polyline, positive towards `across`.
fn offset(line: &[Pixel], at: &Pixel, across: &Pixel) -> f64 {
    let mut best = (f64::INFINITY, 0.0);
    for pair in line.windows(2) {
        let way = pair[1] - pair[0];
        let f = ((at - pair[0]).dot(&way) / way.norm_squared().max(1e-18)).clamp(0.0, 1.0);
        let miss = at - pair[0] - way * f;
        let distance = miss.norm();
        if distance < best.0 {
            best = (distance, if miss.dot(across) < 0.0 { -distance } else { distance });
        }
    }
    best.1
}
