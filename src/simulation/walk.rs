//! One ray followed from the camera to all the light it gathers.
//!
//! At every surface the light splits into Fresnel's unpolarised shares, both of which are followed until
//! a branch would add less than [`FAINT`]. The first way, through both walls, is that of
//! [`optics::trace`]; mirrored ways use the same Snell's law.

use super::bvh::Tubes;
use super::mirror::{fresnel, mirror};
use super::room::{Stand, table_texture};
use super::scene::{BELT_MM, Scene};
use crate::optics::trace::{cylinder_hits, cylinder_normal, refract};
use crate::optics::{self, Vec3};

/// Branches that carry less than this share of the light are cut off.
const FAINT: f64 = 0.008;
/// At most so many mirrors on one way.
const MIRRORS: u32 = 3;
/// Gap between the tank's underside and the table top, mm.
const TABLE_GAP_MM: f64 = 0.5;
/// Linear brightness of the belts' white, black and inner side.
const BELT_WHITE: f64 = 0.75;
const BELT_BLACK: f64 = 0.02;
const BELT_INSIDE: f64 = 0.04;
/// Linear colour of the stem.
const STEM: [f64; 3] = [0.07, 0.3, 0.04];
/// Linear colour of dirt, and the share of light that it keeps back at its middle.
const DIRT: [f64; 3] = [0.05, 0.045, 0.035];
const DIRT_OPACITY: f64 = 0.85;
/// A bubble with a glint: where it lies for a lamp at the side, its radius (both in radii of the bubble), and the share of
/// the light behind that passes the rim.
const GLINT_AT: f64 = 0.5;
const GLINT_RADIUS: f64 = 0.4;
const RIM_PASSES: f64 = 0.3;
/// Linear brightness of the wall's cut edges (rim, floor plate).
const EDGE: f64 = 0.12;

/// What the camera saw first, as far as it decides on supersampling.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The room.
    Room,
    /// The table top.
    Table,
    /// A belt's print.
    Belt,
    /// Through the wall; a root.
    Root,
    /// Through the wall; a bit that hangs in the water.
    Bit,
    /// Through the wall; the floor.
    Floor,
    /// Through the wall; water, and the room behind it.
    Water,
    /// The wall's edges and what lies above the water.
    Edge,
}

/// Light of one ray.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    /// Linear RGB.
    pub light: Vec3,
    /// What was seen.
    pub kind: Kind,
    /// Whether the ray met a root or passed within a pixel of one.
    pub near: bool,
}

/// A ray under way.
pub struct Walker<'a> {
    scene: &'a Scene,
    tubes: &'a Tubes,
    stand: &'a Stand,
    kind: Kind,
    near: bool,
    reach_mm: f64,
}

impl<'a> Walker<'a> {
    /// Ready for a ray; roots that it passes within `reach_mm` are noted.
    pub fn new(scene: &'a Scene, tubes: &'a Tubes, stand: &'a Stand, reach_mm: f64) -> Self {
        Self { scene, tubes, stand, kind: Kind::Room, near: false, reach_mm }
    }

    /// Light that reaches the camera from `direction` (tank frame, unit).
    pub fn sample(mut self, direction: &Vec3) -> Sample {
        let light = self.gathered(&self.stand.centre_mm, direction);
        Sample { light, kind: self.kind, near: self.near }
    }

    fn gathered(&mut self, o: &Vec3, d: &Vec3) -> Vec3 {
        let tank = &self.scene.tank;
        if let Some((t, _)) = cylinder_hits(o, d, tank.radius_mm + BELT_MM) {
            let p = o + d * t;
            if t > 0.0
                && let Some(light) = self.belt(&p)
            {
                self.kind = Kind::Belt;
                return light;
            }
        }
        if let Some((t, _)) = cylinder_hits(o, d, tank.radius_mm).filter(|(t, _)| *t > 0.0) {
            let p = o + d * t;
            if p.z >= 0.0 && p.z <= tank.height_mm {
                let light = self.enter_wall(o, &p, d);
                return self.dirtied(&p, light);
            }
            if let Some(hit) = self.scene.stem.first_hit(o, d, f64::INFINITY, self.reach_mm, &mut self.near) {
                self.kind = Kind::Root;
                return Vec3::from(STEM) * self.scene.room.lit(self.stand, &hit.normal);
            }
            if p.z < 0.0 && d.z > 0.0 {
                let top = o - d * (o.z / d.z);
                let rho = (top.x * top.x + top.y * top.y).sqrt();
                if rho < tank.inner_radius_mm() {
                    self.kind = Kind::Edge;
                    return self.inside(&top, d, false, 1.0, 0);
                } else if rho < tank.radius_mm {
                    self.kind = Kind::Edge;
                    return Vec3::repeat(EDGE * self.scene.room.lit(self.stand, &-Vec3::z()));
                }
            }
        }
        self.outside(o, d)
    }

    /// Light seen past the dirt at a point of the outer wall.
    fn dirtied(&self, p: &Vec3, light: Vec3) -> Vec3 {
        match self.scene.dirt.as_ref().and_then(|dirt| dirt.at(p)) {
            Some(mark) => {
                let opacity = DIRT_OPACITY * (1.0 - mark.out * mark.out);
                light * (1.0 - opacity) + Vec3::from(DIRT) * opacity
            }
            None => light,
        }
    }

    /// Light seen past the bubbles at a point of the inner wall: a bubble is a cap of air on the wall, at whose rim
    /// (beyond sin = n_air/n_water) the room before the tank is mirrored; or one with a glint, dark there, with a bright
    /// spot on the side of the lamps.
    fn bubbled(&self, p: &Vec3, d: &Vec3, light: Vec3) -> Vec3 {
        let Some(mark) = self.scene.bubbles.as_ref().and_then(|bubbles| bubbles.at(p)) else {
            return light;
        };
        let n = self.scene.tank.index;
        let rim = mark.out * n.water > n.air;
        let glint = self.scene.params.bubble_glint;
        if glint > 0.0 {
            let lamp = self.stand.room_from_tank.transpose() * self.stand.lamp;
            let normal = cylinder_normal(p);
            let (across, down) = (lamp.dot(&Vec3::new(-normal.y, normal.x, 0.0)), lamp.z);
            let off = (mark.across - GLINT_AT * across).hypot(mark.down - GLINT_AT * down) / GLINT_RADIUS;
            let dimmed = light * if rim { RIM_PASSES } else { 0.9 };
            return dimmed + Vec3::repeat(glint * (1.0 - off * off).max(0.0));
        }
        if rim {
            self.scene.room.light(self.stand, p, &mirror(d, &cylinder_normal(p))) * 0.9 + light * 0.1
        } else {
            light * 0.8
        }
    }

    /// The belt's light where `p` lies on one.
    fn belt(&self, p: &Vec3) -> Option<Vec3> {
        let tank = &self.scene.tank;
        let (belt, print) = tank.belts_mm.iter().zip(&self.scene.prints).find(|(b, _)| p.z >= b[0] && p.z <= b[1])?;
        let black = print.is_black_at(p.y.atan2(p.x), p.z - belt[0]);
        let paint = if black { BELT_BLACK } else { BELT_WHITE };
        Some(Vec3::repeat(paint * self.scene.room.lit(self.stand, &cylinder_normal(p))))
    }

    /// Table top or room.
    fn outside(&mut self, o: &Vec3, d: &Vec3) -> Vec3 {
        let scene = self.scene;
        let radius = scene.params.table_radii * scene.tank.radius_mm;
        let z = scene.tank.height_mm + TABLE_GAP_MM;
        if d.z > 0.0 && o.z < z && radius > 0.0 {
            let p = o + d * ((z - o.z) / d.z);
            if p.x * p.x + p.y * p.y < radius * radius {
                if self.kind == Kind::Room {
                    self.kind = Kind::Table;
                }
                let lit = scene.room.lit(self.stand, &-Vec3::z());
                return Vec3::new(1.0, 0.97, 0.93) * (0.7 * lit * table_texture(p.x, p.y));
            }
        }
        scene.room.light(self.stand, o, d)
    }

    /// From air into the clear outer wall at `p`.
    fn enter_wall(&mut self, o: &Vec3, p: &Vec3, d: &Vec3) -> Vec3 {
        let tank = &self.scene.tank;
        let n = tank.index;
        self.kind = Kind::Water;
        let mirrored = fresnel(d, &cylinder_normal(p), n.air, n.wall);
        let mut light = Vec3::zeros();
        if self.scene.params.reflections {
            light += self.outside(p, &mirror(d, &cylinder_normal(p))) * mirrored;
        }
        let passed = 1.0 - mirrored;
        let Some(ray) = optics::trace(tank, o, d) else {
            // Past the water, through the wall alone.
            self.kind = Kind::Edge;
            return light + self.through_wall(p, d) * passed;
        };
        if ray.p2_mm.z >= tank.floor_mm() {
            self.kind = Kind::Floor;
            return light + Vec3::repeat(EDGE) * (passed * 0.5);
        }
        let normal = cylinder_normal(&ray.p2_mm);
        let in_water = ray.p2_mm.z > tank.water_level_mm;
        let (n_in, v) = if in_water {
            (n.water, Some(ray.v2))
        } else {
            self.kind = Kind::Edge;
            (n.air, refract(&ray.v1, &normal, n.wall, n.air))
        };
        let Some(v) = v else {
            return light + self.through_wall(p, d) * passed;
        };
        let passed = passed * (1.0 - fresnel(&ray.v1, &normal, n.wall, n_in));
        let within = self.inside(&ray.p2_mm, &v, in_water, passed, 0);
        light + self.bubbled(&ray.p2_mm, d, within) * passed
    }

    /// The way of a ray that crosses only the wall.
    fn through_wall(&mut self, p: &Vec3, d: &Vec3) -> Vec3 {
        let tank = &self.scene.tank;
        let Some(v) = refract(d, &cylinder_normal(p), tank.index.air, tank.index.wall) else {
            return self.outside(p, d);
        };
        let Some((_, t)) = cylinder_hits(p, &v, tank.radius_mm) else {
            return self.outside(p, d);
        };
        let q = p + v * t;
        match refract(&v, &cylinder_normal(&q), tank.index.wall, tank.index.air) {
            Some(out) if tank.is_clear(q.z) => self.outside(&q, &out),
            _ => Vec3::repeat(BELT_INSIDE),
        }
    }

    /// Light along a way inside the inner wall, from `o` towards `d`; `weight` is the share of it that reaches the
    /// camera.
    fn inside(&mut self, o: &Vec3, d: &Vec3, in_water: bool, weight: f64, mirrors: u32) -> Vec3 {
        let scene = self.scene;
        let tank = &scene.tank;
        let Some((_, t_wall)) = cylinder_hits(o, d, tank.inner_radius_mm()) else {
            return self.plane(o, d, in_water, weight, mirrors);
        };
        let plane_z =
            if in_water == (d.z > 0.0) { if in_water { tank.floor_mm() } else { 0.0 } } else { tank.water_level_mm };
        let t_plane = if d.z == 0.0 { f64::INFINITY } else { ((plane_z - o.z) / d.z).max(0.0) };
        let t_end = t_wall.min(t_plane);
        let hit = self.tubes.first_hit(o, d, t_end, self.reach_mm, &mut self.near);
        let mut length = hit.map_or(t_end, |h| h.t_mm);
        let bit = if in_water { scene.drifting.first_hit(o, d, length, self.reach_mm, &mut self.near) } else { None };
        let seen = if let Some(bit) = bit {
            length = bit.t_mm;
            if mirrors == 0 {
                self.kind = Kind::Bit;
            }
            bit.colour * scene.room.lit(self.stand, &bit.normal)
        } else if let Some(hit) = hit {
            if mirrors == 0 {
                self.kind = Kind::Root;
            }
            scene.root_colours[hit.root] * scene.room.lit(self.stand, &hit.normal)
        } else if t_plane < t_wall {
            self.plane(&(o + d * t_plane), d, in_water, weight, mirrors)
        } else {
            self.leave(&(o + d * t_wall), d, in_water, weight, mirrors)
        };
        if in_water { self.dimmed(seen, length) } else { seen }
    }

    fn dimmed(&self, light: Vec3, length_mm: f64) -> Vec3 {
        let loss = self.scene.params.water_loss_per_mm;
        if loss == [0.0; 3] {
            return light;
        }
        light.component_mul(&Vec3::from(loss).map(|x| (-x * length_mm).exp()))
    }

    /// At a horizontal surface: floor, water surface, or the open top.
    fn plane(&mut self, p: &Vec3, d: &Vec3, in_water: bool, weight: f64, mirrors: u32) -> Vec3 {
        let scene = self.scene;
        if in_water && d.z > 0.0 {
            if mirrors == 0 {
                self.kind = Kind::Floor;
            }
            return scene.floor_colour * scene.room.lit(self.stand, &-Vec3::z());
        }
        if !in_water && d.z <= 0.0 {
            return scene.room.light(self.stand, p, d);
        }
        let n = scene.tank.index;
        let (n_from, n_to) = if in_water { (n.water, n.air) } else { (n.air, n.water) };
        let back = fresnel(d, &Vec3::z(), n_from, n_to);
        let mut light = Vec3::zeros();
        if let Some(v) = refract(d, &Vec3::z(), n_from, n_to) {
            light += self.inside(p, &v, !in_water, weight * (1.0 - back), mirrors) * (1.0 - back);
        }
        if self.follows(weight * back, mirrors) {
            let d = mirror(d, &Vec3::z());
            light += self.inside(p, &d, in_water, weight * back, mirrors + 1) * back;
        }
        light
    }

    fn follows(&self, weight: f64, mirrors: u32) -> bool {
        self.scene.params.reflections && weight >= FAINT && mirrors < MIRRORS
    }

    /// At the inner wall, from inside: mirrored there, or into the wall, and there mirrored by the outer side or
    /// out into the room.
    fn leave(&mut self, p: &Vec3, d: &Vec3, in_water: bool, weight: f64, mirrors: u32) -> Vec3 {
        let tank = &self.scene.tank;
        let n = tank.index;
        let n_in = if in_water { n.water } else { n.air };
        let normal = cylinder_normal(p);
        let back = fresnel(d, &normal, n_in, n.wall);
        let mut light = Vec3::zeros();
        if self.follows(weight * back, mirrors) {
            light += self.inside(p, &mirror(d, &normal), in_water, weight * back, mirrors + 1) * back;
        }
        let Some(v) = refract(d, &normal, n_in, n.wall) else {
            return light;
        };
        let passed = 1.0 - back;
        let Some((_, t)) = cylinder_hits(p, &v, tank.radius_mm) else {
            return light;
        };
        let q = p + v * t;
        let normal = cylinder_normal(&q);
        let back = fresnel(&v, &normal, n.wall, n.air);
        if back < 1.0 {
            let behind = if !tank.is_clear(q.z) {
                Vec3::repeat(BELT_INSIDE)
            } else if let Some(out) = refract(&v, &normal, n.wall, n.air) {
                let light = self.outside(&q, &out);
                self.dirtied(&q, light)
            } else {
                Vec3::zeros()
            };
            light += behind * (passed * (1.0 - back));
        }
        let share = passed * back;
        if self.follows(weight * share, mirrors) {
            light += self.back_from_wall(&q, &mirror(&v, &normal), weight * share, mirrors) * share;
        }
        light
    }

    /// From the outer wall's inner side back into the tank.
    fn back_from_wall(&mut self, q: &Vec3, v: &Vec3, weight: f64, mirrors: u32) -> Vec3 {
        let tank = &self.scene.tank;
        let n = tank.index;
        // Rays that run around within the wall gather the room's light somewhere: as good as straight on.
        let astray = |walker: &Self| walker.scene.room.light(walker.stand, q, v);
        let Some((t, _)) = cylinder_hits(q, v, tank.inner_radius_mm()).filter(|(t, _)| *t > 0.0) else {
            return astray(self);
        };
        let p = q + v * t;
        if p.z < 0.0 || p.z > tank.floor_mm() {
            return Vec3::repeat(BELT_INSIDE);
        }
        let in_water = p.z > tank.water_level_mm;
        let n_in = if in_water { n.water } else { n.air };
        match refract(v, &cylinder_normal(&p), n.wall, n_in) {
            Some(d) => self.inside(&p, &d, in_water, weight, mirrors + 1),
            None => astray(self),
        }
    }
}
