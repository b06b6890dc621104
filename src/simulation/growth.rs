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

use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3};
use crate::roots::Root;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Distance between neighbouring centreline points, mm.
const STEP_MM: f64 = 0.4;
/// Clearance between a root's axis and the inner wall or floor, mm.
const CLEARANCE_MM: f64 = 1.0;
/// Correlation length of the curvature, mm.
const BEND_LENGTH_MM: f64 = 6.0;
/// Below this distance from the inner wall a root turns along it, mm.
const WALL_SENSE_MM: f64 = 8.0;

/// The main roots, which start at the crown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MainParams {
    /// Number of main roots: 1 for a taproot, more for a fibrous system.
    pub count: usize,
    /// Mean length, mm.
    pub length_mm: f64,
    /// Relative spread of the lengths: uniform within ± this share, 0..1.
    pub length_spread: f64,
    /// Diameter at the base, mm.
    pub base_diameter_mm: f64,
    /// Diameter at the tip, mm.
    pub tip_diameter_mm: f64,
    /// Largest angle to the vertical at which a main root starts, degrees 0..90.
    pub start_angle_deg: f64,
    /// Standard deviation of the curvature, degrees per mm.
    pub wander_deg_per_mm: f64,
    /// Rate at which a horizontal root turns down, degrees per mm.
    pub gravitropism_deg_per_mm: f64,
}

/// The laterals of one order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LateralParams {
    /// Number of laterals over all parents, shared out by the parents' lengths.
    pub count: usize,
    /// Part of the parent that bears laterals: [from, to] as shares of its length, 0 base, 1 tip.
    pub zone: [f64; 2],
    /// Mean length, mm.
    pub length_mm: f64,
    /// Relative spread of the lengths: uniform within ± this share, 0..1.
    pub length_spread: f64,
    /// Diameter at the base, mm: uniform within [from, to]; never over the parent's there.
    pub base_diameter_mm: [f64; 2],
    /// Diameter at the tip, mm.
    pub tip_diameter_mm: f64,
    /// Angle to the parent at the insertion, degrees 0..180.
    pub insertion_angle_deg: f64,
    /// Spread of that angle: uniform within ± this, degrees.
    pub insertion_spread_deg: f64,
    /// Standard deviation of the curvature, degrees per mm.
    pub wander_deg_per_mm: f64,
    /// Rate at which a horizontal root turns down, degrees per mm.
    pub gravitropism_deg_per_mm: f64,
}

/// How a root system grows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GrowthParams {
    /// Depth of the crown below the rim, mm: where the main roots start, near the axis.
    pub crown_mm: f64,
    /// Greatest distance of the crown from the tank's axis, mm.
    pub crown_offset_mm: f64,
    /// Order 0.
    pub main: MainParams,
    /// Order 1: laterals of the main roots.
    pub first_order: LateralParams,
    /// Order 2: laterals of the first-order laterals.
    pub second_order: LateralParams,
}

impl Default for MainParams {
    /// One taproot.
    fn default() -> Self {
        Self {
            count: 1,
            length_mm: 180.0,
            length_spread: 0.1,
            base_diameter_mm: 3.0,
            tip_diameter_mm: 0.6,
            start_angle_deg: 4.0,
            wander_deg_per_mm: 1.2,
            gravitropism_deg_per_mm: 1.0,
        }
    }
}

impl Default for LateralParams {
    /// Those of a taproot's first order.
    fn default() -> Self {
        Self {
            count: 24,
            zone: [0.04, 0.85],
            length_mm: 100.0,
            length_spread: 0.5,
            base_diameter_mm: [0.9, 1.6],
            tip_diameter_mm: 0.5,
            insertion_angle_deg: 75.0,
            insertion_spread_deg: 15.0,
            wander_deg_per_mm: 2.0,
            gravitropism_deg_per_mm: 0.5,
        }
    }
}

impl Default for GrowthParams {
    /// A taproot with laterals of two orders, at home in a tank of 90 mm radius.
    fn default() -> Self {
        Self {
            crown_mm: 3.0,
            crown_offset_mm: 5.0,
            main: MainParams::default(),
            first_order: LateralParams::default(),
            second_order: LateralParams {
                count: 46,
                zone: [0.1, 0.8],
                length_mm: 38.0,
                length_spread: 0.6,
                base_diameter_mm: [0.6, 0.9],
                tip_diameter_mm: 0.4,
                insertion_angle_deg: 60.0,
                insertion_spread_deg: 20.0,
                wander_deg_per_mm: 3.0,
                gravitropism_deg_per_mm: 0.2,
            },
        }
    }
}

impl GrowthParams {
    /// Fails where a number is out of its range.
    ///
    /// # Errors
    /// Every fault at once, each naming its key.
    pub fn check(&self) -> Result<()> {
        let mut faults = Vec::new();
        let mut need = |ok: bool, key: &str, value: String, remedy: &str| {
            if !ok {
                faults.push(Error::usage(format!("simulate.growth.{key} is {value}")).help(remedy));
            }
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let m = &self.main;
        need(positive(m.length_mm), "main.length_mm", m.length_mm.to_string(), "give a positive length in mm");
        need(share(m.length_spread), "main.length_spread", m.length_spread.to_string(), "give a share, 0 to 1");
        for (key, d) in [
            ("main.base_diameter_mm", m.base_diameter_mm),
            ("main.tip_diameter_mm", m.tip_diameter_mm),
            ("first_order.tip_diameter_mm", self.first_order.tip_diameter_mm),
            ("second_order.tip_diameter_mm", self.second_order.tip_diameter_mm),
        ] {
            need(positive(d) && d <= 20.0, key, d.to_string(), "give a diameter of at most 20 mm");
        }
        for (order, l) in [("first_order", &self.first_order), ("second_order", &self.second_order)] {
            let key = |name: &str| format!("{order}.{name}");
            need(positive(l.length_mm), &key("length_mm"), l.length_mm.to_string(), "give a positive length in mm");
            need(share(l.length_spread), &key("length_spread"), l.length_spread.to_string(), "give a share, 0 to 1");
            let [a, b] = l.zone;
            need(share(a) && share(b) && a <= b, &key("zone"), format!("[{a}, {b}]"), "give shares 0 to 1, from <= to");
            let [a, b] = l.base_diameter_mm;
            need(
                positive(a) && positive(b) && a <= b && b <= 20.0,
                &key("base_diameter_mm"),
                format!("[{a}, {b}]"),
                "give diameters of at most 20 mm, from <= to",
            );
        }
        for (key, x) in [
            ("crown_mm", self.crown_mm),
            ("crown_offset_mm", self.crown_offset_mm),
            ("main.start_angle_deg", m.start_angle_deg),
            ("main.wander_deg_per_mm", m.wander_deg_per_mm),
            ("main.gravitropism_deg_per_mm", m.gravitropism_deg_per_mm),
            ("first_order.insertion_angle_deg", self.first_order.insertion_angle_deg),
            ("first_order.wander_deg_per_mm", self.first_order.wander_deg_per_mm),
            ("second_order.insertion_angle_deg", self.second_order.insertion_angle_deg),
            ("second_order.wander_deg_per_mm", self.second_order.wander_deg_per_mm),
        ] {
            need(x.is_finite() && x >= 0.0, key, x.to_string(), "give a number of at least 0");
        }
        for (key, x) in [
            ("first_order.gravitropism_deg_per_mm", self.first_order.gravitropism_deg_per_mm),
            ("second_order.gravitropism_deg_per_mm", self.second_order.gravitropism_deg_per_mm),
            ("first_order.insertion_spread_deg", self.first_order.insertion_spread_deg),
            ("second_order.insertion_spread_deg", self.second_order.insertion_spread_deg),
        ] {
            need(x.is_finite(), key, x.to_string(), "give a number");
        }
        Error::many(faults)
    }
}

/// Grows a root system inside the tank: main roots first, then the laterals order by order; `id` is the
/// position in the list, a lateral's first point is a point of its parent.
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
    for id in 0..m.count {
        let mut rng = stream(seed, id);
        let turn = rng.random_range(0.0..std::f64::consts::TAU);
        let offset = params.crown_offset_mm.min(room.rho_mm * 0.5) * rng.random::<f64>().sqrt();
        let start = Vec3::new(offset * turn.cos(), offset * turn.sin(), params.crown_mm);
        let lean = (m.start_angle_deg * rng.random::<f64>().sqrt()).to_radians();
        let about = rng.random_range(0.0..std::f64::consts::TAU);
        let direction = Vec3::new(lean.sin() * about.cos(), lean.sin() * about.sin(), lean.cos());
        let walk = Walk {
            length_mm: m.length_mm * spread(&mut rng, m.length_spread),
            base_radius_mm: m.base_diameter_mm / 2.0,
            tip_radius_mm: m.tip_diameter_mm.min(m.base_diameter_mm) / 2.0,
            wander_per_mm: m.wander_deg_per_mm.to_radians(),
            gravitropism_per_mm: m.gravitropism_deg_per_mm.to_radians(),
        };
        roots.push(walk.grow(id, -1, 0, start, direction, &room, &mut rng));
    }
    for (order, lateral) in [(1, &params.first_order), (2, &params.second_order)] {
        laterals(&mut roots, order, lateral, &room, seed);
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

/// Adds the laterals of one order: evenly along the parents' bearing zones laid end to end, with jitter.
fn laterals(roots: &mut Vec<Root>, order: u32, params: &LateralParams, room: &Room, seed: u64) {
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
        let id = roots.len();
        let mut rng = stream(seed, id);
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
        roots.push(walk.grow(id, mother_id, order, start, direction, room, &mut rng));
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
    ) -> Root {
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
        Root { id: id as i64, parent, order, points_mm, radii_mm }
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
    let (a, b) = super::noise::normal_pair(rng.random());
    let (c, _) = super::noise::normal_pair(rng.random());
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
            assert_eq!(roots.len(), 71);
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
    fn same_seed_same_roots_other_seed_others() {
        let grow = |seed| grow(&GrowthParams::default(), &tank(60.0), seed).unwrap();
        assert_eq!(grow(1), grow(1));
        assert_ne!(grow(1), grow(2));
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
