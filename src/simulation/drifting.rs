//! Flat bits that hang in the water and turn with the tank: specks, leaves. None of them is a root.
//!
//! A bit is an ellipse in space, a third to two thirds as wide as long, matt on both sides, brown, green or pale. The log
//! of its half length is uniform, so most are specks and few are leaves.

use super::noise::{hash, normal_pair, uniform};
use crate::optics::{Tank, Vec3};

/// Linear colours of the bits.
const COLOURS: [[f64; 3]; 4] = [[0.20, 0.13, 0.05], [0.10, 0.16, 0.03], [0.42, 0.38, 0.26], [0.05, 0.04, 0.03]];

#[derive(Debug, Clone)]
struct Bit {
    centre: Vec3,
    normal: Vec3,
    /// Unit vectors along and across, and half the extent along each, mm.
    axes: [(Vec3, f64); 2],
    colour: Vec3,
}

/// All bits.
#[derive(Debug, Clone)]
pub struct Drifting {
    /// Sorted by depth.
    bits: Vec<Bit>,
    /// The longest half length, mm.
    longest_mm: f64,
}

/// A bit that a ray met.
#[derive(Debug, Clone, Copy)]
pub struct BitHit {
    /// Distance along the unit direction, mm.
    pub t_mm: f64,
    /// Unit normal of the side that was met.
    pub normal: Vec3,
    /// Linear colour.
    pub colour: Vec3,
}

impl Drifting {
    /// `count` bits of half lengths around `size_mm`, anywhere in the water.
    pub fn new(tank: &Tank, count: usize, size_mm: f64, seed: u64) -> Self {
        let bit = |i: u64| {
            let draw = |j: u64| uniform(hash(seed, &[89, i, j]));
            let half = (size_mm * 4f64.powf(2.0 * draw(0) - 1.0)).min(0.4 * tank.inner_radius_mm());
            let (rho, azimuth) = ((tank.inner_radius_mm() - half) * draw(1).sqrt(), std::f64::consts::TAU * draw(2));
            let (top, bottom) = (tank.water_level_mm + half, tank.floor_mm() - half);
            let z = top + (bottom - top).max(0.0) * draw(3);
            let ((a, b), (c, _)) = (normal_pair(hash(seed, &[89, i, 10])), normal_pair(hash(seed, &[89, i, 11])));
            let normal = Vec3::new(a, b, c).try_normalize(1e-9).unwrap_or_else(Vec3::z);
            let side = normal.cross(&if normal.z.abs() < 0.8 { Vec3::z() } else { Vec3::x() }).normalize();
            let turn = std::f64::consts::TAU * draw(7);
            let along = side * turn.cos() + normal.cross(&side) * turn.sin();
            Bit {
                centre: Vec3::new(rho * azimuth.cos(), rho * azimuth.sin(), z),
                normal,
                axes: [(along, half), (normal.cross(&along), half * (1.0 + draw(4)) / 3.0)],
                colour: Vec3::from(COLOURS[(draw(5) * COLOURS.len() as f64) as usize]) * (0.7 + 0.6 * draw(6)),
            }
        };
        Self::of((0..count as u64).map(bit).collect())
    }

    fn of(mut bits: Vec<Bit>) -> Self {
        bits.sort_by(|a, b| a.centre.z.total_cmp(&b.centre.z));
        let longest_mm = bits.iter().map(|bit| bit.axes[0].1).fold(0.0, f64::max);
        Self { bits, longest_mm }
    }

    /// The first bit within `limit_mm`; `near` is set where the ray meets one or passes one within `reach_mm`.
    pub fn first_hit(&self, o: &Vec3, d: &Vec3, limit_mm: f64, reach_mm: f64, near: &mut bool) -> Option<BitHit> {
        if self.bits.is_empty() {
            return None;
        }
        let mut first: Option<BitHit> = None;
        let (from, to, more) = (o.z, o.z + d.z * limit_mm, self.longest_mm + reach_mm);
        let start = self.bits.partition_point(|bit| bit.centre.z < from.min(to) - more);
        for bit in self.bits[start..].iter().take_while(|bit| bit.centre.z <= from.max(to) + more) {
            let slope = bit.normal.dot(d);
            let t = bit.normal.dot(&(bit.centre - o)) / slope;
            if !(t > 0.0 && t < first.map_or(limit_mm, |hit| hit.t_mm)) {
                continue;
            }
            let off = o + d * t - bit.centre;
            let out =
                |more: f64| bit.axes.iter().map(|(axis, half)| (axis.dot(&off) / (half + more)).powi(2)).sum::<f64>();
            *near |= out(reach_mm) < 1.0;
            if out(0.0) < 1.0 {
                first = Some(BitHit { t_mm: t, normal: bit.normal * -slope.signum(), colour: bit.colour });
            }
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    #[test]
    fn bits_lie_in_the_water_and_rays_meet_them() {
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 100.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let bits = Drifting::new(&tank, 200, 1.0, 5);
        for (i, bit) in bits.bits.iter().enumerate() {
            for (axis, half) in bit.axes {
                assert!(axis.dot(&bit.normal).abs() < 1e-12 && (axis.norm() - 1.0).abs() < 1e-12);
                for end in [bit.centre + axis * half, bit.centre - axis * half] {
                    assert!(end.x.hypot(end.y) <= tank.inner_radius_mm() + 1e-9);
                    assert!(end.z >= 10.0 && end.z <= tank.floor_mm(), "{end}");
                }
            }
            // Aimed at from 2 mm before it, a bit is met there; a half length and more beside it, it is not.
            let alone = Drifting::of(vec![bit.clone()]);
            let from = bit.centre + bit.normal * 2.0;
            let mut near = false;
            let hit = alone.first_hit(&from, &-bit.normal, 9.0, 0.0, &mut near).unwrap();
            assert!((hit.t_mm - 2.0).abs() < 1e-9 && near && (hit.normal - bit.normal).norm() < 1e-12, "{i}");
            let mut near = false;
            let beside = from + bit.axes[0].0 * (bit.axes[0].1 + 0.1);
            assert!(alone.first_hit(&beside, &-bit.normal, 9.0, 0.0, &mut near).is_none() && !near);
            assert!(alone.first_hit(&beside, &-bit.normal, 9.0, 0.2, &mut near).is_none() && near);
            assert!(alone.first_hit(&from, &-bit.normal, 1.9, 0.0, &mut near).is_none());
        }
    }
}
