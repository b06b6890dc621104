//! Width, hulls, solidity, the enclosing ellipsoid.

use super::hull::{area, circle, least_width, planar, spatial};
use crate::optics::Vec3;
use crate::roots::Root;
use nalgebra::{Matrix4, Vector4};

/// Thickness of the slices of the slicewise hull, mm.
const SLICE_MM: f64 = 1.0;
/// The ellipsoid may be larger than the smallest by this share of its squared size (Khachiyan's tolerance).
const TOLERANCE: f64 = 1e-3;

pub(super) fn traits(roots: &[Root], volume: f64, put: &mut impl FnMut(&str, f64)) {
    let points: Vec<Vec3> = roots.iter().flat_map(|r| &r.points_mm).map(|p| Vec3::from(*p)).collect();
    let flat = |a: usize, b: usize| planar(&points.iter().map(|p| [p[a], p[b]]).collect::<Vec<_>>());
    let plan = flat(0, 1);
    put("width_max_mm", 2.0 * circle(&plan).1);
    put("width_min_mm", least_width(&plan));
    put("hull_area_xy_mm2", area(&plan));
    put("hull_area_xz_mm2", area(&flat(0, 2)));
    put("hull_area_yz_mm2", area(&flat(1, 2)));
    let hull = spatial(&points);
    put("convex_hull_volume_mm3", hull.volume);
    put("convex_hull_slicewise_mm3", slicewise(&points));
    put("solidity", volume / hull.volume);
    let axes = ellipsoid(&hull.corners);
    put("ellipsoid_axis_long_mm", axes[0]);
    put("ellipsoid_axis_middle_mm", axes[1]);
    put("ellipsoid_axis_short_mm", axes[2]);
    put("ellipsoid_aspect_ratio", axes[2] / axes[0]);
}

/// Sum over horizontal slices of their points' hull area times the slice's thickness.
fn slicewise(points: &[Vec3]) -> f64 {
    let mut slices: std::collections::BTreeMap<i64, Vec<[f64; 2]>> = std::collections::BTreeMap::new();
    for p in points {
        slices.entry((p.z / SLICE_MM).floor() as i64).or_default().push([p.x, p.y]);
    }
    slices.values().map(|s| area(&planar(s)) * SLICE_MM).sum()
}

/// Full axes, longest first, of the ellipsoid of least volume about the points (Khachiyan 1996); NaN for flat sets.
fn ellipsoid(points: &[Vec3]) -> [f64; 3] {
    let n = points.len();
    if n < 4 {
        return [f64::NAN; 3];
    }
    let lifted: Vec<Vector4<f64>> = points.iter().map(|p| p.push(1.0)).collect();
    let mut weights = vec![1.0 / n as f64; n];
    for _ in 0..10_000 {
        let mut moments = Matrix4::zeros();
        for (p, w) in lifted.iter().zip(&weights) {
            moments += p * (p * *w).transpose();
        }
        let Some(inverse) = moments.try_inverse() else { return [f64::NAN; 3] };
        let far: Vec<f64> = lifted.iter().map(|p| p.dot(&(inverse * p))).collect();
        let most = (0..n).max_by(|&a, &b| far[a].total_cmp(&far[b])).unwrap_or(0);
        let excess = far[most] - 4.0;
        if excess < 4.0 * TOLERANCE {
            break;
        }
        let step = excess / (4.0 * (far[most] - 1.0));
        weights.iter_mut().for_each(|w| *w *= 1.0 - step);
        weights[most] += step;
    }
    let centre: Vec3 = points.iter().zip(weights.iter()).map(|(p, w)| p * *w).sum();
    let mut spread = nalgebra::Matrix3::zeros();
    for (p, w) in points.iter().zip(weights.iter()) {
        spread += (p - centre) * (p - centre).transpose() * *w;
    }
    let mut axes: [f64; 3] = (spread * 3.0).symmetric_eigenvalues().map(|e| 2.0 * e.max(0.0).sqrt()).into();
    axes.sort_by(|a, b| b.total_cmp(a));
    axes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ellipsoids_points_give_its_axes() {
        let points: Vec<Vec3> = (0..400)
            .map(|k| {
                let z = -1.0 + (f64::from(k) + 0.5) / 200.0;
                let angle = 2.399_963 * f64::from(k);
                let rho = (1.0 - z * z).sqrt();
                Vec3::new(5.0 * rho * angle.cos() + 3.0, 2.0 * rho * angle.sin(), 9.0 * z)
            })
            .collect();
        let axes = ellipsoid(&points);
        for (axis, truth) in axes.iter().zip([18.0, 10.0, 4.0]) {
            assert!((axis / truth - 1.0).abs() < 0.02, "{axes:?}");
        }
        let hull = spatial(&points);
        let truth = 4.0 / 3.0 * std::f64::consts::PI * 5.0 * 2.0 * 9.0;
        assert!(hull.volume < truth && hull.volume > 0.96 * truth, "{} of {truth}", hull.volume);
    }
}
