//! The point of a root that is nearest to a place.

use crate::optics::Vec3;

/// Distance from a place to a polyline, mm, and the nearer point of the nearest segment.
pub fn nearest(line: &[[f64; 3]], at: &Vec3) -> (usize, f64) {
    let mut best = (0, f64::INFINITY);
    for k in 0..line.len() {
        let a = Vec3::from(line[k]);
        let b = Vec3::from(line[(k + 1).min(line.len() - 1)]);
        let along = b - a;
        let t = if along.norm_squared() > 0.0 {
            ((at - a).dot(&along) / along.norm_squared()).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let distance = (a + along * t - at).norm();
        if distance < best.1 {
            best = (if t < 0.5 { k } else { k + 1 }, distance);
        }
    }
    best
}
