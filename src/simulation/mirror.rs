//! Light at a mirroring surface: which way it goes, and how much of it.

use crate::optics::Vec3;

/// Direction after a mirror with that unit normal.
pub fn mirror(d: &Vec3, normal: &Vec3) -> Vec3 {
    d - normal * (2.0 * d.dot(normal))
}

/// Fresnel's share of unpolarised light mirrored between two indices; 1 at total reflection.
pub fn fresnel(d: &Vec3, normal: &Vec3, n_from: f64, n_to: f64) -> f64 {
    let cos_in = d.dot(normal).abs().min(1.0);
    let ratio = n_from / n_to;
    let squared = 1.0 - ratio * ratio * (1.0 - cos_in * cos_in);
    if squared <= 0.0 {
        return 1.0;
    }
    let cos_out = squared.sqrt();
    let across = (n_from * cos_in - n_to * cos_out) / (n_from * cos_in + n_to * cos_out);
    let along = (n_to * cos_in - n_from * cos_out) / (n_to * cos_in + n_from * cos_out);
    0.5 * (across * across + along * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_known_angles() {
        let at = |degrees: f64, a: f64, b: f64| {
            let x = degrees.to_radians();
            fresnel(&Vec3::new(x.sin(), 0.0, x.cos()), &Vec3::z(), a, b)
        };
        assert!((at(0.0, 1.0, 1.5) - 0.04).abs() < 1e-12);
        // At Brewster's angle only the part across is mirrored: ((1 - n²)/(1 + n²))² / 2.
        let n: f64 = 1.5;
        let brewster = ((1.0 - n * n) / (1.0 + n * n)).powi(2) / 2.0;
        assert!((at(n.atan().to_degrees(), 1.0, n) - brewster).abs() < 1e-12);
        assert_eq!(at(50.0, 1.333, 1.0), 1.0);
        assert!(at(48.0, 1.333, 1.0) < 1.0);
    }
}
