//! A furnished room: four walls, floor and ceiling around the tank, about a metre away.
//!
//! The walls lie at a distance, not in a direction alone: a tank full of water is a strong lens whose image of a wall
//! depends on how far the wall is, and a bumped or carried camera sees the wall move behind the tank.

use super::stand::Stand;
use super::wall::{SOFT_MM, Seen, Wall};
use crate::optics::{Tank, Vec3};
use crate::simulation::noise::{hash, uniform};
use serde::{Deserialize, Serialize};

/// Least distance of the walls from the tank's axis, mm, and from the camera.
const WALL_MM: f64 = 1000.0;
const BEHIND_MM: f64 = 300.0;
/// Ceiling and floor above and below the middle of the tank, mm, at least.
const ABOVE_MM: f64 = 1100.0;
const BELOW_MM: f64 = 800.0;

/// Shelves reach no farther than this from the tank along walls that do, mm.
const SHELVES_MM: f64 = 4000.0;

/// What stands in the room; by default nothing, and the room is a far plain background.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RoomParams {
    /// Share of the shelves' length, on all four walls, that holds coloured things, 0..1; 0 for no shelves.
    pub clutter: f64,
    /// Bright windows, at most one to a wall: behind the tank, to the left, behind the camera, to the right.
    pub windows: usize,
    /// Linear light of the windows; 1 is full white.
    pub window_level: f64,
    /// Lamps in sight, at most one to a wall, in the same order.
    pub lamps: usize,
}

impl Default for RoomParams {
    fn default() -> Self {
        Self { clutter: 0.0, windows: 0, window_level: 0.9, lamps: 0 }
    }
}

/// The room's box, in the room's frame, and its walls.
#[derive(Debug, Clone)]
pub struct Furniture {
    /// Middle of the tank.
    pub middle: Vec3,
    low: Vec3,
    high: Vec3,
    /// Behind the tank, to the left, behind the camera, to the right.
    walls: [Wall; 4],
    floor: Vec3,
    ceiling: Vec3,
}

impl Furniture {
    /// The room around all those stands; `None` where nothing stands in it. `paint` is the walls' linear colour, from
    /// which each wall differs by up to 0.4 of it.
    pub fn new(params: &RoomParams, paint: Vec3, tank: &Tank, stands: &[Stand], seed: u64) -> Option<Self> {
        if params.clutter == 0.0 && params.windows == 0 && params.lamps == 0 {
            return None;
        }
        let first = stands.first()?;
        let middle = first.room_from_tank * (Vec3::z() * (0.5 * tank.height_mm) - first.origin_mm);
        let (mut half, mut above, mut below) = (WALL_MM, ABOVE_MM, BELOW_MM);
        for stand in stands {
            let off = stand.centre_mm - Vec3::z() * (0.5 * tank.height_mm);
            half = half.max(off.x.hypot(off.y) + BEHIND_MM);
            above = above.max(BEHIND_MM - off.z);
            below = below.max(BEHIND_MM + off.z);
        }
        let wall = |i: usize| {
            let seed = hash(seed, &[97, i as u64]);
            let paint = paint * (0.6 + 0.8 * uniform(seed));
            let window = (i < params.windows).then_some(params.window_level);
            let [reach, up, down] = [half, above, below].map(|x| x.min(SHELVES_MM));
            Wall::new(paint, reach, [-up, down], params.clutter, window, i < params.lamps, seed)
        };
        Some(Self {
            middle,
            low: middle - Vec3::new(half, half, above),
            high: middle + Vec3::new(half, half, below),
            walls: [0, 1, 2, 3].map(wall),
            floor: paint * 0.5,
            ceiling: paint * 1.6,
        })
    }

    /// Whether nothing in the room is finer than a pixel of that width, radians, wherever the camera stands.
    pub fn is_smooth(&self, pixel: f64) -> bool {
        (self.high - self.low).norm() * pixel <= SOFT_MM
    }

    /// Where a ray (room's frame) from inside meets the room, and what is seen there.
    pub fn seen(&self, o: &Vec3, d: &Vec3) -> (Vec3, Seen) {
        let (mut t, mut side) = (f64::INFINITY, 2);
        for k in 0..3 {
            if d[k] != 0.0 {
                let end = ((if d[k] > 0.0 { self.high[k] } else { self.low[k] } - o[k]) / d[k]).max(0.0);
                if end < t {
                    (t, side) = (end, k);
                }
            }
        }
        let p = o + d * t;
        let at = p - self.middle;
        let wall = match (side, d[side] > 0.0) {
            (0, false) => 1,
            (0, true) => 3,
            (1, true) => 0,
            (1, false) => 2,
            (_, down) => {
                let paint = if down { self.floor } else { self.ceiling };
                return (p, Seen { paint, shining: Vec3::zeros(), share: 0.0 });
            }
        };
        (p, self.walls[wall].seen(at[1 - side], at.z))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;
    use crate::simulation::{CaptureParams, capture};

    #[test]
    fn rays_end_on_the_wall_they_look_at() {
        let tank = Tank {
            radius_mm: 60.0,
            height_mm: 180.0,
            wall_mm: 4.0,
            water_level_mm: 14.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let params = CaptureParams { distance_mm: 1500.0, ..Default::default() };
        let stands = Stand::all(&capture(&params, &tank, 2).unwrap(), &params, 2);
        let room = RoomParams { clutter: 0.5, ..Default::default() };
        let room = Furniture::new(&room, Vec3::repeat(0.1), &tank, &stands, 3).unwrap();
        // The camera stands inside, the wall behind it is at the least distance.
        assert!((room.low.y + BEHIND_MM).abs() < 5.0, "{}", room.low.y);
        for i in 0..200u64 {
            let draw = |j: u64| uniform(hash(i, &[j])) - 0.5;
            let o = room.middle + Vec3::new(draw(0), draw(1), draw(2)) * 1000.0;
            let d = Vec3::new(draw(3), draw(4), draw(5)).normalize();
            let (p, _) = room.seen(&o, &d);
            assert!((p - o).normalize().dot(&d) > 1.0 - 1e-12);
            let inside = (0..3).map(|k| (p[k] - room.low[k]).min(room.high[k] - p[k])).fold(f64::INFINITY, f64::min);
            assert!(inside.abs() < 1e-9, "{inside}");
        }
        assert!(Furniture::new(&RoomParams::default(), Vec3::repeat(0.1), &tank, &stands, 3).is_none());
    }
}
