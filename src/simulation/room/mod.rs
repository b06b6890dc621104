//! What stands around the tank: the room (which stands still with the camera), the lamps, the table top.
//!
//! Directions of the room are given in its own frame ([`Stand`]): x to the right of the camera, y away from it, z down. A
//! plain room is a far sphere (1.5 m) with a gradient and blotches; where a ray leaves the tank its end on that
//! sphere is looked up, so that direct, refracted and mirrored views agree. A furnished room is a box about a metre away
//! ([`Furniture`]) under the same gradient, blotches and glow.

mod furniture;
mod stand;
mod wall;

pub use furniture::RoomParams;
pub use stand::Stand;

use super::CaptureParams;
use super::noise;
use crate::optics::{Tank, Vec3};
use crate::photo::colour::linear_of_srgb;
use furniture::Furniture;

/// Distance of the room's walls, mm.
const FAR_MM: f64 = 1500.0;
/// Sharpness of the lamps' glow: exp(this (cos angle - 1)).
const GLOW: f64 = 10.0;

/// The room's light.
#[derive(Debug, Clone)]
pub struct Room {
    base: Vec3,
    variation: f64,
    waves: [(Vec3, f64, f64); 3],
    lamp_level: f64,
    front_level: f64,
    ambient: f64,
    furniture: Option<Furniture>,
}

/// Linear light of an sRGB colour.
pub fn linear_rgb(srgb: [f64; 3]) -> Vec3 {
    Vec3::from(srgb.map(|c| f64::from(linear_of_srgb(c as f32))))
}

impl Room {
    /// The room of a capture whose cameras stand there.
    pub fn new(params: &CaptureParams, tank: &Tank, stands: &[Stand], seed: u64) -> Self {
        let wave = |i: u64| {
            let value = |j: u64| noise::uniform(noise::hash(seed, &[77, i, j]));
            let direction = Vec3::new(value(0) - 0.5, value(1) - 0.5, value(2) - 0.5).normalize();
            (direction * (3.0 + 3.0 * i as f64), value(3) * std::f64::consts::TAU, 0.5 / (i + 1) as f64)
        };
        let base = linear_rgb(params.background_rgb);
        Self {
            base,
            variation: params.background_variation,
            waves: [wave(0), wave(1), wave(2)],
            lamp_level: params.lamp_level,
            front_level: params.front_level,
            ambient: params.ambient,
            furniture: Furniture::new(&params.room, base, tank, stands, seed),
        }
    }

    /// Light that comes from the room along `-direction` to `from_mm` (tank frame).
    pub fn light(&self, stand: &Stand, from_mm: &Vec3, direction: &Vec3) -> Vec3 {
        let Some(furniture) = &self.furniture else {
            let far = stand.room_from_tank * (from_mm - stand.origin_mm + direction * FAR_MM);
            return self.lit_paint(stand, self.base, &(far / far.norm()));
        };
        let from = stand.room_from_tank * (from_mm - stand.origin_mm);
        let (place, seen) = furniture.seen(&from, &(stand.room_from_tank * direction));
        let lit = self.lit_paint(stand, seen.paint, &(place - furniture.middle).normalize());
        lit * (1.0 - seen.share) + seen.shining * seen.share
    }

    /// Whether a pixel of that width, radians, that sees nothing but the room, sees no detail in it. A plain room's pixels
    /// are judged by their light alone.
    pub fn is_smooth(&self, pixel: f64) -> bool {
        self.furniture.as_ref().is_some_and(|furniture| furniture.is_smooth(pixel))
    }

    /// Light from a far surface of that colour in the direction `q` (room's frame, unit), with the lamps' glow.
    fn lit_paint(&self, stand: &Stand, paint: Vec3, q: &Vec3) -> Vec3 {
        let blotches: f64 = self.waves.iter().map(|(k, phase, strength)| strength * (k.dot(q) + phase).sin()).sum();
        // Brighter above than below.
        let factor = 1.0 + self.variation * (blotches - q.z);
        let glow = self.lamp_level * (GLOW * (q.dot(&stand.lamp) - 1.0)).exp();
        let front = self.front_level * (-q.y).max(0.0);
        paint * factor.max(0.0) + Vec3::repeat(glow + front)
    }

    /// Share of full light that a matt surface with that outward normal (tank frame) sends back.
    pub fn lit(&self, stand: &Stand, normal: &Vec3) -> f64 {
        let n = stand.room_from_tank * normal;
        // The light from all around comes rather from above.
        let around = self.ambient * (0.75 - 0.25 * n.z);
        around + (1.0 - self.ambient) * n.dot(&stand.lamp).max(0.0)
    }
}

/// Mottled brightness of the table top at a point, 0..1.
pub fn table_texture(x_mm: f64, y_mm: f64) -> f64 {
    let blots = noise::value_2d(41, x_mm / 7.0, y_mm / 7.0) + 0.6 * noise::value_2d(43, x_mm / 2.5, y_mm / 2.5);
    (0.42 + 0.28 * blots).clamp(0.05, 0.9)
}
