//! A ray from the camera into the water.  Paper 2.2.2, 2.3.1; Snell's law in vector form.
//!
//! The ray meets the tank's outer wall at p₁, is refracted, meets the inner wall at p₂, is refracted
//! again and runs through the water along p₂ + t v₂ until it meets the inner wall once more at p₃.
//! Nothing here looks for the rim, the belts or the water surface: the caller asks the points.

use super::{Tank, Vec3};

/// A camera's ray where it runs through the water; points and directions in the tank frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WaterRay {
    /// Where the ray meets the outer wall, mm.
    pub p1_mm: Vec3,
    /// Direction inside the wall.
    pub v1: Vec3,
    /// Where the ray enters the water, mm.
    pub p2_mm: Vec3,
    /// Direction in the water.
    pub v2: Vec3,
    /// Where the ray would meet the inner wall again, mm.
    pub p3_mm: Vec3,
}

/// Parameters of the two points at which `origin + t direction` meets the cylinder of that radius
/// about the z axis, nearer first; `None` where the ray misses it or runs along the axis.  Paper 2.2.2.
pub fn cylinder_hits(origin: &Vec3, direction: &Vec3, radius_mm: f64) -> Option<(f64, f64)> {
    let a = direction.x * direction.x + direction.y * direction.y;
    let half_b = origin.x * direction.x + origin.y * direction.y;
    let c = origin.x * origin.x + origin.y * origin.y - radius_mm * radius_mm;
    let d = half_b * half_b - a * c;
    if a < 1e-18 || d < 0.0 {
        return None;
    }
    // The larger root by magnitude first, the other from the product: no cancellation.
    let big = -(half_b + half_b.signum() * d.sqrt());
    let (t1, t2) = if big == 0.0 { (0.0, 0.0) } else { (big / a, c / big) };
    Some((t1.min(t2), t1.max(t2)))
}

/// Snell's law for a unit direction at a surface with unit normal `normal` (either side), from index
/// `n_from` to `n_to`; `None` at total reflection.
pub fn refract(direction: &Vec3, normal: &Vec3, n_from: f64, n_to: f64) -> Option<Vec3> {
    let cos_in = direction.dot(normal);
    let ratio = n_from / n_to;
    let cos_out_squared = 1.0 - ratio * ratio * (1.0 - cos_in * cos_in);
    if cos_out_squared < 0.0 {
        return None;
    }
    let cos_out = cos_out_squared.sqrt() * cos_in.signum();
    Some(direction * ratio + normal * (cos_out - ratio * cos_in))
}

/// Outward unit normal of a cylinder about the z axis at a point of its surface.
pub fn cylinder_normal(point_mm: &Vec3) -> Vec3 {
    let rho = (point_mm.x * point_mm.x + point_mm.y * point_mm.y).sqrt();
    Vec3::new(point_mm.x / rho, point_mm.y / rho, 0.0)
}

/// Follows the ray from a camera outside the tank into the water; `None` where it misses the tank or
/// is reflected totally.
pub fn trace(tank: &Tank, origin_mm: &Vec3, direction: &Vec3) -> Option<WaterRay> {
    let (t1, _) = cylinder_hits(origin_mm, direction, tank.radius_mm)?;
    if t1 <= 0.0 {
        return None;
    }
    let p1_mm = origin_mm + direction * t1;
    let v1 = refract(direction, &cylinder_normal(&p1_mm), tank.index.air, tank.index.wall)?;
    let (t2, _) = cylinder_hits(&p1_mm, &v1, tank.inner_radius_mm())?;
    if t2 <= 0.0 {
        return None;
    }
    let p2_mm = p1_mm + v1 * t2;
    let v2 = refract(&v1, &cylinder_normal(&p2_mm), tank.index.wall, tank.index.water)?;
    let (_, t3) = cylinder_hits(&p2_mm, &v2, tank.inner_radius_mm())?;
    Some(WaterRay { p1_mm, v1, p2_mm, v2, p3_mm: p2_mm + v2 * t3 })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn tank() -> Tank {
        Tank {
            radius_mm: 90.0,
            height_mm: 246.6,
            wall_mm: 5.0,
            water_level_mm: 12.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    #[test]
    fn a_ray_at_the_axis_goes_straight_on() {
        let ray = trace(&tank(), &Vec3::new(480.0, 0.0, 100.0), &Vec3::new(-1.0, 0.0, 0.0)).unwrap();
        assert!((ray.p3_mm - Vec3::new(-85.0, 0.0, 100.0)).norm() < 1e-12);
    }

    #[test]
    fn invariants_hold_through_both_walls() {
        // n v_z and n ρ sin(angle) are the same in air, wall and water (Bouguer).
        let origin = Vec3::new(480.0, 0.0, 90.0);
        let direction = Vec3::new(-1.0, 0.14, 0.07).normalize();
        let ray = trace(&tank(), &origin, &direction).unwrap();
        let moment = |p: &Vec3, v: &Vec3| p.x * v.y - p.y * v.x;
        let b = moment(&origin, &direction);
        assert!((1.49 * moment(&ray.p1_mm, &ray.v1) - b).abs() < 1e-10);
        assert!((1.333 * moment(&ray.p2_mm, &ray.v2) - b).abs() < 1e-10);
        assert!((1.333 * ray.v2.z - direction.z).abs() < 1e-12);
        assert!((ray.v2.norm() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_ray_beside_the_tank_is_none() {
        assert!(trace(&tank(), &Vec3::new(480.0, 0.0, 90.0), &Vec3::new(-1.0, 0.3, 0.0).normalize()).is_none());
    }
}
