//! A wall of a furnished room: shelves with coloured things on them, windows, lamps.
//!
//! Places on a wall are (u, v), mm: u along it from its middle, v down from the middle of the tank. Edges are as soft as an
//! ordinary lens that is focused on the tank leaves them at that distance.

use crate::optics::Vec3;
use crate::photo::colour::linear_of_srgb;
use crate::simulation::noise::{hash, uniform};

/// Width over which an edge fades, mm: the disc of confusion of a lens of about 2 mm aperture.
pub const SOFT_MM: f64 = 6.0;
/// Thickness of a shelf's board, mm.
const BOARD_MM: f64 = 22.0;
/// Linear colour of the boards and of the windows' frames.
const BOARD: [f64; 3] = [0.22, 0.20, 0.18];
/// Colour of daylight and of the lamps.
const DAYLIGHT: [f64; 3] = [0.93, 0.97, 1.0];
const LAMPLIGHT: [f64; 3] = [1.0, 0.86, 0.66];

/// What is seen of a wall at a place.
pub struct Seen {
    /// Linear colour of what is lit there.
    pub paint: Vec3,
    /// Light that shines by itself, and the share in which it hides the paint.
    pub shining: Vec3,
    /// 0..1.
    pub share: f64,
}

#[derive(Debug, Clone)]
struct Thing {
    u: [f64; 2],
    height: f64,
    colour: Vec3,
    /// A bottle darkens towards its sides, a box does not.
    round: bool,
}

#[derive(Debug, Clone)]
struct Shelf {
    /// Depth of the board's upper edge.
    v: f64,
    /// Free height above it.
    height: f64,
    /// Sorted along u, none over another.
    things: Vec<Thing>,
}

#[derive(Debug, Clone)]
struct Window {
    u: [f64; 2],
    v: [f64; 2],
    level: f64,
}

#[derive(Debug, Clone)]
struct Lamp {
    u: f64,
    v: f64,
    radius: f64,
}

/// A wall.
#[derive(Debug, Clone)]
pub struct Wall {
    paint: Vec3,
    shelves: Vec<Shelf>,
    window: Option<Window>,
    lamp: Option<Lamp>,
}

impl Wall {
    /// A wall of that paint, furnished from -`half` to `half` and from `v[0]` to `v[1]`: shelves that are full of things to the
    /// share `clutter` (none at 0), a window of that linear light, a lamp.
    pub fn new(paint: Vec3, half: f64, v: [f64; 2], clutter: f64, window: Option<f64>, lamp: bool, seed: u64) -> Self {
        let draw = |j: u64| uniform(hash(seed, &[j]));
        // A window lies to one side of the middle, a lamp to the other, so that both are seen through the tank's sides and
        // past it.
        let side = if draw(0) < 0.5 { -1.0 } else { 1.0 };
        let window = window.map(|level| {
            let (width, middle) = (320.0 + 240.0 * draw(1), side * (230.0 + 200.0 * draw(2)));
            let sill = 20.0 + 160.0 * draw(3);
            let u = [middle - width / 2.0, middle + width / 2.0];
            Window { u, v: [sill - 420.0 - 240.0 * draw(4), sill], level }
        });
        let lamp = lamp.then(|| Lamp {
            u: -side * (180.0 + 250.0 * draw(5)),
            v: -60.0 - 160.0 * draw(6),
            radius: 28.0 + 25.0 * draw(7),
        });
        let shelves = if clutter > 0.0 { shelves(half, [v[0] + 120.0 * draw(8), v[1]], clutter, seed) } else { vec![] };
        Self { paint, shelves, window, lamp }
    }

    /// What is seen at a place.
    pub fn seen(&self, u: f64, v: f64) -> Seen {
        let mut paint = self.paint;
        let at = self.shelves.partition_point(|shelf| shelf.v + BOARD_MM + SOFT_MM / 2.0 < v);
        if let Some(shelf) = self.shelves.get(at) {
            shelf.cover(&mut paint, u, v);
        }
        let (mut shining, mut share) = (Vec3::zeros(), 0.0);
        if let Some(window) = &self.window {
            let frame = 25.0;
            let cover = within(u, [window.u[0] - frame, window.u[1] + frame])
                * within(v, [window.v[0] - frame, window.v[1] + frame]);
            paint += (Vec3::from(BOARD) - paint) * cover;
            let (middle, transom) = ((window.u[0] + window.u[1]) / 2.0, window.v[0] * 0.7 + window.v[1] * 0.3);
            let bars =
                (1.0 - within(u, [middle - 12.0, middle + 12.0])) * (1.0 - within(v, [transom - 12.0, transom + 12.0]));
            share = within(u, window.u) * within(v, window.v) * bars;
            // The sky is brighter than what lies below it.
            let up = ((window.v[1] - v) / (window.v[1] - window.v[0])).clamp(0.0, 1.0);
            shining = Vec3::from(DAYLIGHT) * (window.level * (0.7 + 0.3 * up));
        }
        if let Some(lamp) = &self.lamp {
            let distance = (u - lamp.u).hypot(v - lamp.v);
            paint += paint.component_mul(&Vec3::from(LAMPLIGHT)) * (3.0 * (-distance / (3.0 * lamp.radius)).exp());
            let disc = step((lamp.radius - distance) / SOFT_MM);
            if disc > 0.0 {
                shining = (shining * share * (1.0 - disc) + Vec3::from(LAMPLIGHT) * (1.3 * disc))
                    / (share * (1.0 - disc) + disc);
                share += (1.0 - share) * disc;
            }
        }
        Seen { paint, shining, share }
    }
}

impl Shelf {
    /// Lays board, things and the shadow under the board above over the wall's paint.
    fn cover(&self, paint: &mut Vec3, u: f64, v: f64) {
        let below_top = ((v - self.v + self.height) / self.height).clamp(0.0, 1.0);
        *paint *= 0.7 + 0.3 * below_top.sqrt();
        let next = self.things.partition_point(|thing| thing.u[1] + SOFT_MM / 2.0 < u);
        for thing in self.things[next..].iter().take_while(|thing| thing.u[0] - SOFT_MM / 2.0 < u) {
            let cover = within(u, thing.u) * within(v, [self.v - thing.height, self.v + BOARD_MM / 2.0]);
            let across = (2.0 * (u - thing.u[0]) / (thing.u[1] - thing.u[0]) - 1.0).clamp(-1.0, 1.0);
            let shade = if thing.round { 0.35 + 0.65 * (1.0 - across * across).sqrt() } else { 1.0 };
            *paint += (thing.colour * shade - *paint) * cover;
        }
        *paint += (Vec3::from(BOARD) - *paint) * within(v, [self.v, self.v + BOARD_MM]);
    }
}

/// Shelves one above the other as far as they go.
fn shelves(half: f64, v: [f64; 2], clutter: f64, seed: u64) -> Vec<Shelf> {
    let mut shelves = Vec::new();
    let mut bottom = v[0];
    loop {
        let row = shelves.len() as u64;
        let height = 210.0 + 90.0 * uniform(hash(seed, &[20, row]));
        bottom += height;
        if bottom > v[1] {
            return shelves;
        }
        shelves.push(Shelf { v: bottom, height, things: things(half, height, clutter, hash(seed, &[21, row])) });
        bottom += BOARD_MM;
    }
}

/// Things side by side until they fill about that share of a shelf.
fn things(half: f64, height: f64, clutter: f64, seed: u64) -> Vec<Thing> {
    let mut things: Vec<Thing> = Vec::new();
    let mut u = -half;
    for i in 0.. {
        let draw = |j: u64| uniform(hash(seed, &[i, j]));
        let width = 22.0 + 90.0 * draw(0) * draw(0);
        // A gap's mean is what leaves the share free.
        u += 2.0 * draw(1) * width * (1.0 - clutter) / clutter;
        if u + width > half {
            break;
        }
        let colour = thing_colour(draw(2), draw(3), draw(4));
        let height = height * (0.25 + 0.6 * draw(5));
        things.push(Thing { u: [u, u + width], height, colour, round: draw(6) < 0.4 });
        u += width;
    }
    things
}

/// Linear colour of a thing: hue, saturation and value from numbers in 0..1.
fn thing_colour(hue: f64, saturation: f64, value: f64) -> Vec3 {
    let (saturation, value) = (0.7 * saturation, 0.2 + 0.6 * value);
    let channel = |shift: f64| {
        let k = (shift + 6.0 * hue).rem_euclid(6.0);
        value * (1.0 - saturation * k.min(4.0 - k).clamp(0.0, 1.0))
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0)).map(|c| f64::from(linear_of_srgb(c as f32)))
}

/// Share of the soft spot at x that lies within [a, b].
fn within(x: f64, [a, b]: [f64; 2]) -> f64 {
    step((x - a) / SOFT_MM) * step((b - x) / SOFT_MM)
}

/// From 0 at -1/2 to 1 at 1/2, smoothly.
fn step(t: f64) -> f64 {
    let t = (t + 0.5).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wall(clutter: f64, window: Option<f64>, lamp: bool) -> Wall {
        Wall::new(Vec3::repeat(0.1), 1000.0, [-900.0, 700.0], clutter, window, lamp, 7)
    }

    #[test]
    fn shelves_are_as_full_as_asked_for() {
        for clutter in [0.3, 0.7, 1.0] {
            let wall = wall(clutter, None, false);
            assert!(wall.shelves.len() >= 4);
            let things = wall.shelves.iter().flat_map(|s| &s.things);
            let share = things.map(|t| t.u[1] - t.u[0]).sum::<f64>() / (2000.0 * wall.shelves.len() as f64);
            assert!((share - clutter).abs() < 0.12, "{clutter}: {share}");
        }
        assert!(wall(0.0, None, false).shelves.is_empty());
    }

    #[test]
    fn a_window_shines_within_its_frame_and_a_lamp_too() {
        let wall = wall(0.5, Some(0.9), true);
        let (window, lamp) = (wall.window.clone().unwrap(), wall.lamp.clone().unwrap());
        let pane = wall.seen(window.u[0] + 40.0, window.v[1] - 40.0);
        assert!(pane.share == 1.0 && pane.shining.z > 0.6 && pane.shining.z < 0.9);
        assert_eq!(wall.seen(window.u[1] + 30.0, window.v[1] + 30.0).share, 0.0);
        assert_eq!(wall.seen((window.u[0] + window.u[1]) / 2.0, window.v[1] - 40.0).share, 0.0);
        let shining = wall.seen(lamp.u, lamp.v);
        assert!(shining.share == 1.0 && (shining.shining - Vec3::from(LAMPLIGHT) * 1.3).norm() < 1e-12);
    }

    #[test]
    fn colours_are_those_of_the_wheel() {
        let close = |a: Vec3, srgb: [f64; 3]| (a - super::super::linear_rgb(srgb)).norm() < 1e-6;
        assert!(close(thing_colour(0.0, 1.0, 1.0), [0.8, 0.24, 0.24]));
        assert!(close(thing_colour(1.0 / 3.0, 1.0, 1.0), [0.24, 0.8, 0.24]));
        assert!(close(thing_colour(0.7, 0.0, 0.5), [0.5, 0.5, 0.5]));
    }
}
