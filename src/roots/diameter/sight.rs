//! A photograph as a root's width is read in it: where it shows a place, and its light.

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
