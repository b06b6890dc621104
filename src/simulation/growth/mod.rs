//! A root system grown by a random walk with gravitropism.
//!
//! Main roots start at the crown. Each root advances by 0.4 mm steps; its direction d changes with
//!
//! ```text
//! d' = d + ds (κ + g (down - (down·d) d)),   normalised
//! ```
//!
//! where κ is a curvature vector that wanders as an Ornstein-Uhlenbeck process of 6 mm correlation
//! length and of the given standard deviation, and g is the strength of gravitropism. Laterals start on a
//! point of their parent's axis at the insertion angle, around the parent by the golden angle with
//! jitter. Radii fall linearly from base to tip. Roots keep 1 mm from the inner wall and the floor and
//! do not grow above the crown:
//! within 8 mm of the wall they bend along it, and what would still cross is held back, so that
//! they creep along the wall as real ones do. Each root has its own random stream: a change of one root's
//! parameters leaves the roots before it as they were.

mod age;
mod params;
mod presets;

pub use age::{AgeParams, aged};
pub use params::{GrowthParams, LateralParams, MainParams};
pub use presets::Preset;

use super::noise;
use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3};
use crate::roots::Root;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Distance between neighbouring centreline points, mm.
const STEP_MM: f64 = 0.4;
/// Clearance between a root's axis and the inner wall or floor, mm.
const CLEARANCE_MM: f64 = 1.0;
/// Correlation length of the curvature, mm.
const BEND_LENGTH_MM: f64 = 6.0;
/// Below this distance from the inner wall a root turns along it, mm.
const WALL_SENSE_MM: f64 = 8.0;

/// Grows a root system inside the tank: main roots first, then the laterals order by order; `id` is the
/// position in the list, a lateral's first point is a point of its parent. A root that cannot take a single step (in the
/// corner of wall and floor) is left out.
///
/// # Errors
/// Where a parameter is out of range or the tank leaves no room for a root.
pub fn grow(params: &GrowthParams, tank: &Tank, seed: u64) -> Result<Vec<Root>> {
    params.check()?;
    tank.check()?;
    let room = Room {
        rho_mm: tank.inner_radius_mm() - CLEARANCE_MM,
        crown_mm: params.crown_mm,
        floor_mm: tank.floor_mm() - CLEARANCE_MM,
    };
    if room.rho_mm <= CLEARANCE_MM || room.floor_mm <= params.crown_mm {
        return Err(Error::usage(format!(
            "the tank (inner radius {:.1} mm, inner floor at {:.1} mm) leaves no room for a root from the crown at {:.1} mm",
            tank.inner_radius_mm(),
            tank.floor_mm(),
            params.crown_mm
        ))
        .help("raise the tank's size or lower simulate.growth.crown_mm"));
    }
    let mut roots: Vec<Root> = Vec::new();
    let m = &params.main;
    for number in 0..m.count {
        let mut rng = stream(seed, number);
        let turn = rng.random_range(0.0..std::f64::consts::TAU);
        let offset = params.crown_offset_mm.min(room.rho_mm * 0.5) * rng.random::<f64>().sqrt();
        // Hashed, not drawn from the stream: a spread of 0 leaves everything else as it is.
        let draw = |j: u64| noise::uniform(noise::hash(seed, &[101, number as u64, j]));
        let depth_mm = (params.crown_mm + m.depth_spread_mm * draw(0)).min(room.floor_mm);
        let start = Vec3::new(offset * turn.cos(), offset * turn.sin(), depth_mm);
        let base_diameter_mm = m.base_diameter_mm * (1.0 + m.diameter_spread * (2.0 * draw(1) - 1.0));
        let lean = (m.start_angle_deg * rng.random::<f64>().sqrt()).to_radians();
        let about = rng.random_range(0.0..std::f64::consts::TAU);
        let direction = Vec3::new(lean.sin() * about.cos(), lean.sin() * about.sin(), lean.cos());
        let walk = Walk {
            length_mm: m.length_mm * spread(&mut rng, m.length_spread),
            base_radius_mm: base_diameter_mm / 2.0,
            tip_radius_mm: m.tip_diameter_mm.min(base_diameter_mm) / 2.0,
            wander_per_mm: m.wander_deg_per_mm.to_radians(),
            gravitropism_per_mm: m.gravitropism_deg_per_mm.to_radians(),
        };
        roots.extend(walk.grow(roots.len(), -1, 0, start, direction, &room, &mut rng));
    }
    let mut number = m.count;
    for (order, lateral) in [(1, &params.first_order), (2, &params.second_order)] {
        laterals(&mut roots, order, lateral, &room, seed, number);
        number += lateral.count;
    }
    Ok(roots)
}

/// The room in which an axis may lie.
struct Room {
    rho_mm: f64,
    crown_mm: f64,
    floor_mm: f64,
}

fn stream(seed: u64, root: usize) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(root as u64);
    rng
}

/// Uniform factor within 1 ± `share`.
fn spread(rng: &mut ChaCha8Rng, share: f64) -> f64 {
    1.0 + share * (2.0 * rng.random::<f64>() - 1.0)
}

/// Adds the laterals of one order: evenly along the parents' bearing zones laid end to end, with jitter. The first of them
/// has the random stream `number`.
fn laterals(roots: &mut Vec<Root>, order: u32, params: &LateralParams, room: &Room, seed: u64, number: usize) {
    let parents: Vec<usize> = (0..roots.len()).filter(|&i| roots[i].order + 1 == order).collect();
    let zone_points = |root: &Root| {
        let last = root.points_mm.len() - 1;
        let at = |share: f64| ((share * last as f64).round() as usize).min(last);
        (at(params.zone[0]), at(params.zone[1]))
    };
    let total: usize = parents.iter().map(|&p| zone_points(&roots[p])).map(|(a, b)| b - a + 1).sum();
    if total == 0 {
        return;
    }
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    for k in 0..params.count {
        let mut rng = stream(seed, number + k);
        let place = (k as f64 + rng.random::<f64>()) / params.count as f64 * total as f64;
        let mut place = (place as usize).min(total - 1);
        let mut parent = parents[0];
        for &p in &parents {
            let (a, b) = zone_points(&roots[p]);
            parent = p;
            if place < b - a + 1 {
                place += a;
                break;
            }
            place -= b - a + 1;
        }
        let mother = &roots[parent];
        let points = &mother.points_mm;
        let start = Vec3::from(points[place]);
        let (before, after) = (place.saturating_sub(1), (place + 1).min(points.len() - 1));
        let along = Vec3::from(points[after]) - Vec3::from(points[before]);
        let along = along.try_normalize(1e-9).unwrap_or_else(Vec3::z);
        let turn = golden * k as f64 + rng.random_range(-0.6..0.6);
        let (side, other) = across(&along);
        let angle =
            (params.insertion_angle_deg + params.insertion_spread_deg * (2.0 * rng.random::<f64>() - 1.0)).to_radians();
        let direction = along * angle.cos() + (side * turn.cos() + other * turn.sin()) * angle.sin();
        let [a, b] = params.base_diameter_mm;
        let base_radius_mm = (a + (b - a) * rng.random::<f64>()).min(2.0 * mother.radii_mm[place]) / 2.0;
        let walk = Walk {
            length_mm: params.length_mm * spread(&mut rng, params.length_spread),
            base_radius_mm,
            tip_radius_mm: (params.tip_diameter_mm / 2.0).min(base_radius_mm),
            wander_per_mm: params.wander_deg_per_mm.to_radians(),
            gravitropism_per_mm: params.gravitropism_deg_per_mm.to_radians(),
        };
        let mother_id = mother.id;
        roots.extend(walk.grow(roots.len(), mother_id, order, start, direction, room, &mut rng));
    }
}

/// Two unit vectors across a unit vector and each other.
fn across(d: &Vec3) -> (Vec3, Vec3) {
    let helper = if d.z.abs() < 0.8 { Vec3::z() } else { Vec3::x() };
    let side = d.cross(&helper).normalize();
    (side, d.cross(&side))
}

/// One root's walk.
struct Walk {
    length_mm: f64,
    base_radius_mm: f64,
    tip_radius_mm: f64,
    wander_per_mm: f64,
    gravitropism_per_mm: f64,
}

impl Walk {
    /// The root; `None` where there is no room for a single step.
    #[allow(clippy::too_many_arguments)]
    fn grow(
        &self,
        id: usize,
        parent: i64,
        order: u32,
        start: Vec3,
        direction: Vec3,
        room: &Room,
        rng: &mut ChaCha8Rng,
    ) -> Option<Root> {
        let steps = (self.length_mm / STEP_MM).round().max(2.0) as usize;
        let keep = (-STEP_MM / BEND_LENGTH_MM).exp();
        let kick = self.wander_per_mm * (1.0 - keep * keep).sqrt();
        let (mut p, mut d) = (start, direction);
        let mut bend = gaussian_vector(rng) * self.wander_per_mm;
        let mut points_mm = vec![[p.x, p.y, p.z]];
        for _ in 0..steps {
            bend = bend * keep + gaussian_vector(rng) * kick;
            let down = Vec3::z() - d * d.z;
            d += (bend - d * bend.dot(&d) + down * self.gravitropism_per_mm) * STEP_MM;
            d = held_back(&p, &d, room).try_normalize(1e-9).unwrap_or_else(Vec3::z);
            let q = room.nearest(&(p + d * STEP_MM));
            // A root that can only be pushed back (in a corner) has come to its end.
            if (q - p).norm() < 0.25 * STEP_MM {
                break;
            }
            d = (q - p).normalize();
            p = q;
            points_mm.push([p.x, p.y, p.z]);
        }
        let last = (points_mm.len() - 1).max(1) as f64;
        let radii_mm = (0..points_mm.len())
            .map(|i| self.base_radius_mm + (self.tip_radius_mm - self.base_radius_mm) * i as f64 / last)
            .collect();
        (points_mm.len() > 1).then_some(Root { id: id as i64, parent, order, points_mm, radii_mm })
    }
}

/// Takes from a direction what leads to the wall or the floor, the more the nearer they are.
fn held_back(p: &Vec3, d: &Vec3, room: &Room) -> Vec3 {
    let rho = p.x.hypot(p.y);
    let mut d = *d;
    if rho > 1e-9 {
        let outward = Vec3::new(p.x / rho, p.y / rho, 0.0);
        let near = 1.0 - ((room.rho_mm - rho) / WALL_SENSE_MM).clamp(0.0, 1.0);
        d -= outward * (d.dot(&outward).max(0.0) * 0.15 * near);
    }
    let near = 1.0 - ((room.floor_mm - p.z) / WALL_SENSE_MM).clamp(0.0, 1.0);
    d.z -= d.z.max(0.0) * 0.15 * near;
    d
}

impl Room {
    /// The nearest point inside.
    fn nearest(&self, p: &Vec3) -> Vec3 {
        let rho = p.x.hypot(p.y);
        let scale = if rho > self.rho_mm { self.rho_mm / rho } else { 1.0 };
        Vec3::new(p.x * scale, p.y * scale, p.z.clamp(self.crown_mm, self.floor_mm))
    }
}

fn gaussian_vector(rng: &mut ChaCha8Rng) -> Vec3 {
    let (a, b) = noise::normal_pair(rng.random());
    let (c, _) = noise::normal_pair(rng.random());
    Vec3::new(a, b, c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn tank(radius_mm: f64) -> Tank {
        Tank {
            radius_mm,
            height_mm: 2.5 * radius_mm,
            wall_mm: 4.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        }
    }

    #[test]
    fn roots_stay_inside_and_evenly_sampled() {
        for radius in [30.0, 45.0, 90.0] {
            let tank = tank(radius);
            let roots = grow(&GrowthParams::default(), &tank, 3).unwrap();
            assert!((69..=71).contains(&roots.len()), "{}", roots.len());
            for root in &roots {
                assert_eq!(root.points_mm.len(), root.radii_mm.len());
                for p in &root.points_mm {
                    assert!(p[0].hypot(p[1]) <= tank.inner_radius_mm() - 1.0 + 1e-9);
                    assert!(p[2] <= tank.floor_mm() - 1.0 + 1e-9);
                }
                for w in root.points_mm.windows(2) {
                    let step = (Vec3::from(w[1]) - Vec3::from(w[0])).norm();
                    assert!(step > 0.09 && step < 0.41, "{step}");
                }
            }
        }
    }

    #[test]
    fn laterals_start_on_their_parent_and_are_thinner() {
        let roots = grow(&GrowthParams::default(), &tank(90.0), 5).unwrap();
        for root in roots.iter().filter(|r| r.parent >= 0) {
            let parent = &roots[root.parent as usize];
            assert_eq!(parent.order + 1, root.order);
            let at = parent.points_mm.iter().position(|p| *p == root.points_mm[0]).unwrap();
            assert!(root.radii_mm[0] <= parent.radii_mm[at] + 1e-12);
        }
    }

    #[test]
    fn roots_without_room_for_a_step_are_left_out() {
        // Everything creeps into the corner of a narrow tank.
        let mut params = GrowthParams::preset(Preset::Maize);
        params.main.length_mm = 400.0;
        params.second_order.count = 2000;
        let roots = grow(&params, &tank(20.0), 1).unwrap();
        assert!(roots.len() < 14 + 110 + 2000, "{}", roots.len());
        for (i, root) in roots.iter().enumerate() {
            assert!(root.points_mm.len() > 1 && root.id == i as i64);
            assert!(root.parent < 0 || roots[root.parent as usize].points_mm.contains(&root.points_mm[0]));
        }
    }

    #[test]
    fn same_seed_same_roots_other_seed_others() {
        let grow = |seed| grow(&GrowthParams::default(), &tank(60.0), seed).unwrap();
        assert_eq!(grow(1), grow(1));
        assert_ne!(grow(1), grow(2));
    }

    #[test]
    fn bushes_have_many_crown_roots_from_near_the_axis_and_no_taproot() {
        for (preset, metres, diameters) in [(Preset::Rice, 5.5..8.0, 0.6..1.1), (Preset::Maize, 5.0..8.0, 1.4..2.4)] {
            let params = GrowthParams::preset(preset);
            let roots = grow(&params, &tank(75.0), 3).unwrap();
            let crown: Vec<&Root> = roots.iter().filter(|r| r.parent < 0).collect();
            assert_eq!(crown.len(), params.main.count);
            for root in &crown {
                let [x, y, z] = root.points_mm[0];
                assert!(x.hypot(y) <= 3.0 && (8.0..=14.0).contains(&z), "{x} {y} {z}");
                assert!(diameters.contains(&(2.0 * root.radii_mm[0])), "{}", root.radii_mm[0]);
            }
            let depths = crown.iter().map(|r| r.points_mm[0][2]);
            assert!(depths.clone().fold(f64::NEG_INFINITY, f64::max) - depths.fold(f64::INFINITY, f64::min) > 3.0);
            let steps = roots.iter().flat_map(|r| r.points_mm.windows(2));
            let total = steps.map(|w| (Vec3::from(w[1]) - Vec3::from(w[0])).norm()).sum::<f64>() / 1000.0;
            assert!(metres.contains(&total), "{preset:?}: {total} m");
        }
    }

    #[test]
    fn bad_parameters_are_named_together() {
        let mut params = GrowthParams::default();
        params.main.length_mm = -1.0;
        params.second_order.zone = [0.9, 0.1];
        let error = grow(&params, &tank(60.0), 1).unwrap_err().to_string();
        assert!(error.contains("main.length_mm") && error.contains("second_order.zone"), "{error}");
    }
}
