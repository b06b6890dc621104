//! Centrelines as evenly spaced points, and the region in which they count.

use crate::optics::Tank;
use crate::roots::Root;

/// Spacing of the points along a centreline, mm.
pub const STEP_MM: f64 = 0.25;

/// A reconstruction: bare points (voxels), or centrelines.
#[derive(Debug, Clone, Copy)]
pub enum Found<'a> {
    /// Points, mm; taken as they are.
    Points(&'a [[f64; 3]]),
    /// One polyline per root, mm; resampled.
    Lines(&'a [Vec<[f64; 3]>]),
    /// Roots; their centrelines are resampled.
    Roots(&'a [Root]),
}

impl Found<'_> {
    /// The points that are compared.
    pub fn points(&self) -> Vec<[f64; 3]> {
        match self {
            Self::Points(points) => points.to_vec(),
            Self::Lines(lines) => lines.iter().flat_map(|line| resample(line)).collect(),
            Self::Roots(roots) => sampled(roots),
        }
    }
}

/// Where points count: `z_min < z < z_max` and `rho < rho_max`, mm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Region {
    /// Upper limit (smaller z).
    pub z_min_mm: f64,
    /// Lower limit (greater z).
    pub z_max_mm: f64,
    /// Limit of the distance from the axis.
    pub rho_max_mm: f64,
}

impl Region {
    /// The usual region of a tank: from 16 mm under the water level (the belt and what the surface mirrors lie
    /// above) down to `z_max_mm`, 1 mm off the inner wall.
    pub fn of_tank(tank: &Tank, z_max_mm: f64) -> Self {
        Self { z_min_mm: tank.water_level_mm + 16.0, z_max_mm, rho_max_mm: tank.inner_radius_mm() - 1.0 }
    }

    /// Whether a point counts.
    pub fn holds(&self, p: &[f64; 3]) -> bool {
        p[2] > self.z_min_mm && p[2] < self.z_max_mm && p[0].hypot(p[1]) < self.rho_max_mm
    }
}

/// Points every 0.25 mm along a polyline, from its start; the end is left out unless it falls on a step. A polyline
/// shorter than one step stays as it is.
pub fn resample(line: &[[f64; 3]]) -> Vec<[f64; 3]> {
    resample_with(line, STEP_MM).into_iter().map(|(p, ..)| p).collect()
}

/// The points of [`resample`] at any spacing, each with the segment it lies on and how far along it (0..1).
pub(super) fn resample_with(line: &[[f64; 3]], step: f64) -> Vec<([f64; 3], usize, f64)> {
    let mut arc = vec![0.0];
    for w in line.windows(2) {
        let d: f64 = (0..3).map(|k| (w[1][k] - w[0][k]).powi(2)).sum::<f64>().sqrt();
        arc.push(arc[arc.len() - 1] + d);
    }
    let total = arc[arc.len() - 1];
    if line.len() < 2 || total < step {
        return line.iter().enumerate().map(|(i, p)| (*p, i, 0.0)).collect();
    }
    let count = (total / step).ceil() as usize;
    let mut segment = 0;
    (0..count)
        .map(|i| {
            let s = i as f64 * step;
            while segment + 2 < arc.len() && arc[segment + 1] <= s {
                segment += 1;
            }
            let length = arc[segment + 1] - arc[segment];
            let f = if length > 0.0 { (s - arc[segment]) / length } else { 0.0 };
            let p = std::array::from_fn(|k| line[segment][k] + f * (line[segment + 1][k] - line[segment][k]));
            (p, segment, f)
        })
        .collect()
}

/// All centrelines of a root system as points with their radii, mm.
pub(super) fn sampled_with_radii(roots: &[Root]) -> Vec<([f64; 3], f64)> {
    let of_root = |root: &Root| -> Vec<([f64; 3], f64)> {
        let radius = |i: usize| root.radii_mm[i.min(root.radii_mm.len() - 1)];
        resample_with(&root.points_mm, STEP_MM)
            .into_iter()
            .map(|(p, i, f)| (p, radius(i) + f * (radius(i + 1) - radius(i))))
            .collect()
    };
    roots.iter().filter(|r| !r.radii_mm.is_empty()).flat_map(of_root).collect()
}

/// All centrelines of a root system as points.
pub(super) fn sampled(roots: &[Root]) -> Vec<[f64; 3]> {
    roots.iter().flat_map(|root| resample(&root.points_mm)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_even_and_the_end_is_left_out() {
        let line = [[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [1.0, 0.0, 0.0]];
        let x: Vec<f64> = resample(&line).iter().map(|p| p[0]).collect();
        assert_eq!(x.len(), 4);
        for (i, x) in x.iter().enumerate() {
            assert!((x - 0.25 * i as f64).abs() < 1e-12);
        }
    }

    #[test]
    fn short_lines_stay() {
        let line = [[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]];
        assert_eq!(resample(&line), line.to_vec());
        assert_eq!(resample(&[[1.0, 2.0, 3.0]]), vec![[1.0, 2.0, 3.0]]);
        assert!(resample(&[]).is_empty());
    }
}
