//! Roots that sway: the turning table moves the water, and the water the roots.
//!
//! In a swaying view every point x is moved sideways by
//!
//! ```text
//! d(x) = A w (cos θ, sin θ, 0),   w = min(1, |x - crown| / 60 mm) (0.6 + 0.4 sin(k·x + φ)),   θ = θ₀ + 0.8 sin(x_z / 30 mm)
//! ```
//!
//! with θ₀, φ and the direction of k (wavelength 90 mm) drawn per view: greatest displacement A, none at the crown,
//! neighbours move together, laterals stay on their parents. What would touch the wall is held back.

use super::noise::{hash, uniform};
use crate::optics::{Tank, Vec3};
use crate::roots::Root;
use std::f64::consts::TAU;

/// The roots as they hang in that view.
pub fn swayed(roots: &[Root], tank: &Tank, amplitude_mm: f64, seed: u64, view: usize) -> Vec<Root> {
    let draw = |i: u64| uniform(hash(seed, &[59, view as u64, i]));
    let (theta, phase) = (TAU * draw(0), TAU * draw(1));
    let k = Vec3::new(draw(2) - 0.5, draw(3) - 0.5, draw(4) - 0.5).normalize() * (TAU / 90.0);
    let crown = roots.iter().find_map(|r| r.points_mm.first()).map_or_else(Vec3::zeros, |p| Vec3::from(*p));
    let mut roots = roots.to_vec();
    for root in &mut roots {
        for (p, radius) in root.points_mm.iter_mut().zip(&root.radii_mm) {
            let x = Vec3::from(*p);
            let weight = ((x - crown).norm() / 60.0).min(1.0) * (0.6 + 0.4 * (k.dot(&x) + phase).sin());
            let angle = theta + 0.8 * (x.z / 30.0).sin();
            let moved = x + Vec3::new(angle.cos(), angle.sin(), 0.0) * (amplitude_mm * weight);
            let rho = moved.x.hypot(moved.y);
            let scale = ((tank.inner_radius_mm() - radius - 0.1) / rho.max(1e-9)).min(1.0);
            *p = [moved.x * scale, moved.y * scale, moved.z];
        }
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use crate::simulation::{GrowthParams, grow};

    #[test]
    fn sway_is_bounded_smooth_and_keeps_roots_joined() {
        let tank = Tank {
            radius_mm: 60.0,
            height_mm: 160.0,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let roots = grow(&GrowthParams::default(), &tank, 2).unwrap();
        let moved = swayed(&roots, &tank, 1.5, 9, 4);
        let mut most = 0f64;
        for (a, b) in roots.iter().zip(&moved) {
            for (p, q) in a.points_mm.iter().zip(&b.points_mm) {
                most = most.max((Vec3::from(*p) - Vec3::from(*q)).norm());
                assert!(q[0].hypot(q[1]) <= tank.inner_radius_mm());
            }
            if a.parent >= 0 {
                assert!(moved[a.parent as usize].points_mm.contains(&b.points_mm[0]));
            }
        }
        assert!(most > 0.8 && most <= 1.5 + 1e-9, "{most}");
        assert_ne!(moved, swayed(&roots, &tank, 1.5, 9, 5));
    }
}
