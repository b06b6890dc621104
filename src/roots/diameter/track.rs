//! Where a photograph sees the beads of a root: its points at equal steps, projected once.
//!
//! Pixels are exact; the derivative is taken at every bead that may be measured. When a bead is moved across by
//! a fraction of a millimetre its pixel follows by the derivative.

use super::sight::{Jacobian, Pixel, Sight};
use crate::optics::Vec3;
use crate::roots::curve;

/// Points of a root at which photographs are read.
#[derive(Debug, Clone, PartialEq)]
pub struct Beads {
    /// Their indices among the root's points, ascending.
    pub points: Vec<usize>,
    /// Their places, mm.
    pub places: Vec<Vec3>,
    /// Arc length from the root's first point, mm.
    pub arc_mm: Vec<f64>,
}

impl Beads {
    /// Every point that lies `every_mm` beyond the bead before, from the first on.
    pub fn new(points_mm: &[[f64; 3]], every_mm: f64) -> Self {
        let arc = curve::chord_lengths(points_mm);
        let (mut next, mut points) = (0.0, Vec::new());
        for (k, &s) in arc.iter().enumerate() {
            if s + 1e-9 >= next {
                points.push(k);
                next = s + every_mm;
            }
        }
        let places = points.iter().map(|&k| Vec3::from(points_mm[k])).collect();
        let arc_mm = points.iter().map(|&k| arc[k]).collect();
        Self { points, places, arc_mm }
    }

    /// Unit tangent at a bead, over its neighbours.
    pub fn tangent(&self, b: usize) -> Option<Vec3> {
        let (from, to) = (b.saturating_sub(1), (b + 1).min(self.places.len() - 1));
        (self.places[to] - self.places[from]).try_normalize(1e-9)
    }
}

/// The beads of one root in one photograph.
#[derive(Debug, Clone, PartialEq)]
pub struct Track {
    /// Pixel of each bead; none where it is not seen unhindered through a regular ray.
    pub pixels: Vec<Option<Pixel>>,
    /// Derivative of the pixel by the place, px/mm, at every second bead; none where it is not seen.
    pub jacobians: Vec<Option<Jacobian>>,
}

/// Derivatives stand at every second bead.
pub const STRIDE: usize = 2;

impl Track {
    /// Projects the beads.
    pub fn new(sight: &Sight<'_>, beads: &Beads) -> Self {
        let pixels: Vec<Option<Pixel>> = beads.places.iter().map(|p| sight.pixel(p)).collect();
        let jacobians = (0..pixels.len())
            .step_by(STRIDE)
            .map(|b| pixels[b].and_then(|pixel| sight.jacobian(&beads.places[b], &pixel)))
            .collect();
        Self { pixels, jacobians }
    }

    /// The derivative nearest to a bead.
    pub fn jacobian(&self, b: usize) -> Option<&Jacobian> {
        self.jacobians[b / STRIDE].as_ref()
    }

    /// Moves bead `b` by `shift`.
    pub fn shift(&mut self, b: usize, shift: &Vec3) {
        let Some(jacobian) = self.jacobian(b).copied() else { return };
        if let Some(pixel) = &mut self.pixels[b] {
            *pixel += jacobian * shift;
        }
    }
}
