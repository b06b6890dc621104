//! From a point in the water to the pixel that sees it: the exact inverse of the ray's refraction.
//! Paper 2.3.2, without the search over rays; the equations stand in `path`.
//!
//! A [`ViewMap`] finds the **regular** ray (paper 2.3.3) through a point by Newton's method in the ray's
//! two invariants (b, s), kept within the regular rays: regular rays do not cross in the water, so the
//! point's side of the ray, the sign of F₁, changes once between the two folds and there is one solution or
//! none. Where there is none the point lies beyond the fold on one side, and the solution is the fold's
//! own ray at the point's height: the closest regular ray, at the distance |F₁|.
//!
//! Where Newton has not settled (close to the fold the equations are flat) bisection in s takes over, with b
//! bisected between the folds inside; it cannot stray.
//!
//! Rays that carry no evidence are told by the heights at which they meet the walls: over the rim, below
//! the floor's underside, through an opaque belt, or into the water above its surface or below the inner
//! floor. Rays steeper than 48 degrees against the horizontal are left out: cameras look from the side, and such
//! rays may cross in the water although each is regular by its exit point.

mod fold;
mod irregular;
mod march;
mod path;
mod solve;
mod stack;

use super::{Mat3, Tank, Vec3, View};
use crate::error::{Error, Result};
use fold::{Fold, LowerBound};
pub use march::{LANES, Lanes, March};
use path::Path;
pub use stack::Stack;

/// Rays steeper than this (sine against the horizontal, in air; 48 degrees) are not followed.
const STEEPEST_SINE: f64 = 0.75;

/// The map from the water to one view's pixels.
#[derive(Debug, Clone)]
pub struct ViewMap {
    view: View,
    tank: Tank,
    path: Path,
    fold: Fold,
    /// cos and sin of the camera's azimuth.
    turn: (f64, f64),
    /// Range of s of the rays that meet the outer wall between rim and underside and are not too steep.
    s_range: (f64, f64),
    /// Below the fold everywhere.
    within_fold: LowerBound,
    /// Rotation to the camera's frame from (out, along, down) at the camera in the turned frame.
    cam_from_turned: Mat3,
}

/// Where a point in the water is seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projection {
    /// Pixel column of the ray.
    pub u: f64,
    /// Pixel row of the ray.
    pub v: f64,
    /// Distance of the point from the ray, mm: zero (to rounding) where a regular ray goes through the point.
    pub distance_mm: f64,
    /// Whether the ray reaches the water unhindered: through clear wall, below the water surface and
    /// above the inner floor.
    pub clear: bool,
    /// Where the ray meets the outer wall, z in mm.
    pub wall_z_mm: f64,
    /// Where the ray enters the water, z in mm.
    pub water_z_mm: f64,
}

/// Where [`LANES`] points are seen.
#[derive(Debug, Clone, Copy)]
pub struct Pixels {
    /// Pixel columns; NaN where nothing is seen.
    pub u: [f64; LANES],
    /// Pixel rows.
    pub v: [f64; LANES],
    /// Local magnification: the root of the picture's area, px², per area of water across the ray, mm².
    pub px_per_mm: [f64; LANES],
}

/// Rays of N points by their invariants in the camera's turned frame.
#[derive(Debug, Clone, Copy)]
pub struct Rays<const N: usize> {
    /// Moments b about the axis.
    pub b: [f64; N],
    /// Axial invariants s.
    pub s: [f64; N],
    /// Distance of each point from its ray, mm; NaN where no ray can be given.
    pub distance: [f64; N],
    /// |∂(b, s) / ∂(across, z)| at the point, 1/mm²: how many rays a patch of water holds.
    pub density: [f64; N],
    /// Heights at which the rays meet the outer wall, mm, to 1e-6.
    pub wall_z: [f64; N],
    /// Heights at which they meet the inner wall, mm, to 1e-6.
    pub water_z: [f64; N],
}

impl<const N: usize> Rays<N> {
    /// Rays along the camera's height straight at the axis, at points on them.
    const ZERO: Self =
        Self { b: [0.0; N], s: [0.0; N], distance: [0.0; N], density: [0.0; N], wall_z: [0.0; N], water_z: [0.0; N] };
}

/// A ray by its invariants in the camera's turned frame, and how it misses the point it was solved for.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Solved {
    b: f64,
    s: f64,
    distance: f64,
}

impl ViewMap {
    /// The map of `view` into `tank`. Pixels are those of the view's own lens: give [`View::ideal`] for
    /// undistorted photographs.
    ///
    /// # Errors
    /// Where view or tank are faulty, the camera is not outside the tank's wall, or light crosses within the
    /// water already on the axis (no ray is regular).
    pub fn new(view: &View, tank: &Tank) -> Result<Self> {
        view.check()?;
        tank.check()?;
        let c = view.centre_in_tank();
        let r0 = c.x.hypot(c.y);
        if r0 <= tank.radius_mm * (1.0 + 1e-6) {
            return Err(Error::failed(format!(
                "the camera stands {r0:.1} mm from the tank's axis, inside its outer wall (radius {} mm)",
                tank.radius_mm
            ))
            .help("cameras look from the side; check the cameras' unit (mm), R and t, and tank.radius"));
        }
        let index = tank.index;
        let path = Path {
            r0,
            z0: c.z,
            outer: tank.radius_mm,
            inner: tank.inner_radius_mm(),
            n_squared: [index.air, index.wall, index.water].map(|n| n * n),
        };
        if path.exit_determinant(0.0, 0.0) >= 0.0 {
            return Err(Error::failed(format!(
                "with tank.index air {}, wall {}, water {} the rays cross before they leave the water, so none is regular",
                index.air, index.wall, index.water
            ))
            .help("check tank.index; water has 1.333"));
        }
        // The steepest ray to a height of the wall is the one straight at the axis.
        let s_to = |z: f64| index.air * (z - c.z) / (z - c.z).hypot(r0 - tank.radius_mm);
        let bound = steepest(&path);
        let s_range = (s_to(0.0).min(0.0).max(-bound), s_to(tank.height_mm).max(0.0).min(bound));
        let fold = Fold::new(&path, s_range.0.abs().max(s_range.1).max(1e-3));
        let (cos, sin) = (c.x / r0, c.y / r0);
        let tank_from_turned = Mat3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        Ok(Self {
            view: view.clone(),
            tank: tank.clone(),
            path,
            within_fold: fold.lower_bound(),
            fold,
            turn: (cos, sin),
            s_range,
            cam_from_turned: view.rotation * tank_from_turned,
        })
    }

    /// The view this map belongs to.
    pub fn view(&self) -> &View {
        &self.view
    }

    /// The tank this map looks into.
    pub fn tank(&self) -> &Tank {
        &self.tank
    }

    /// Pixel of the regular ray closest to a point in the water (tank frame, mm).
    ///
    /// `None` outside the inner wall, behind the camera, or where the ray would have to pass over the rim or
    /// below the floor. The height of the point is not judged: the caller asks the tank.
    pub fn project(&self, point_in_tank: &Vec3) -> Option<Projection> {
        let (x, y) = self.turned(point_in_tank.x, point_in_tank.y);
        if x * x + y * y > self.path.inner * self.path.inner * (1.0 + 1e-12) {
            return None;
        }
        let solved = self.solve(x, y, point_in_tank.z)?;
        let (u, v) = self.view.pixel_of_direction(&self.direction(solved.b, solved.s))?;
        let (wall_z_mm, water_z_mm) = self.path.entry_heights(solved.b, solved.s);
        Some(Projection {
            u,
            v,
            distance_mm: solved.distance,
            clear: self.are_clear(&[wall_z_mm], &[water_z_mm]) == [true],
            wall_z_mm,
            water_z_mm,
        })
    }

    /// Replaces the ray of each wanted lane that no regular ray meets by the closest irregular one, where that is
    /// closer. `x`, `y`, `z` are the points in the tank frame, mm.
    pub fn admit_irregular(&self, x: f64, y: &[f64; LANES], z: f64, wanted: &[bool; LANES], lanes: &mut Lanes) {
        for l in (0..LANES).filter(|&l| wanted[l]) {
            if lanes.distance[l] > 0.0 {
                let (px, py) = self.turned(x, y[l]);
                let found = self.irregular(px, py, z, (lanes.b[l], lanes.s[l]));
                if found.distance < lanes.distance[l] {
                    (lanes.b[l], lanes.s[l], lanes.distance[l]) = (found.b, found.s, found.distance);
                    (lanes.wall_z[l], lanes.water_z[l]) = self.path.entry_heights(found.b, found.s);
                }
            }
        }
    }

    /// Ideal-lens pixels of the rays of `lanes`; NaN where the ray carries no evidence or lies behind the camera.
    #[inline(always)]
    pub fn clear_pixels(&self, lanes: &Lanes) -> Pixels {
        let mut out = self.pixels(lanes);
        for (u, is_clear) in out.u.iter_mut().zip(self.are_clear(&lanes.wall_z, &lanes.water_z)) {
            *u = if is_clear { *u } else { f64::NAN };
        }
        out
    }

    /// Ideal-lens pixels of the rays of `lanes`; NaN where the ray lies behind the camera.
    #[inline(always)]
    fn pixels(&self, lanes: &Lanes) -> Pixels {
        let mut out = Pixels { u: [0.0; LANES], v: [0.0; LANES], px_per_mm: [0.0; LANES] };
        let lens = &self.view.lens;
        let inverse_n = 1.0 / self.path.n_squared[0].sqrt();
        let inverse_moment = inverse_n / self.path.r0;
        let inverse_water = 1.0 / self.path.n_squared[2];
        let m = &self.cam_from_turned;
        for l in 0..LANES {
            let (along, down) = (lanes.b[l] * inverse_moment, lanes.s[l] * inverse_n);
            let inward = (1.0 - along * along - down * down).sqrt();
            let x = m.m12 * along + m.m13 * down - m.m11 * inward;
            let y = m.m22 * along + m.m23 * down - m.m21 * inward;
            let z = m.m32 * along + m.m33 * down - m.m31 * inward;
            let level = (1.0 - lanes.s[l] * lanes.s[l] * inverse_water).sqrt();
            // One division for 1/z and 1/(inward level).
            let slant = inward * level;
            let of_both = 1.0 / (z * slant);
            let per_z = of_both * slant;
            let scale = lens.focal_px * per_z;
            let seen = if z > 1e-12 { 0.0 } else { f64::NAN };
            out.u[l] = x * scale + lens.cx + seen;
            out.v[l] = y * scale + lens.cy;
            // Solid angle in air of a patch of water across the ray, and its area on the picture.
            let solid_angle = lanes.density[l] * inverse_moment * inverse_n * (z * of_both);
            out.px_per_mm[l] = (scale * scale * per_z * solid_angle).sqrt();
        }
        out
    }

    /// Which rays, that meet the outer and the inner wall at these heights, carry evidence.
    #[inline(always)]
    fn are_clear<const N: usize>(&self, wall_z: &[f64; N], water_z: &[f64; N]) -> [bool; N] {
        let tank = &self.tank;
        let (level, floor) = (tank.water_level_mm, tank.floor_mm());
        let mut clear = [false; N];
        for (l, clear) in clear.iter_mut().enumerate() {
            *clear = (wall_z[l] >= 0.0) & (wall_z[l] <= tank.height_mm) & (water_z[l] > level) & (water_z[l] < floor);
        }
        for &[from, to] in &tank.belts_mm {
            for (clear, z) in clear.iter_mut().zip(wall_z) {
                *clear &= !((*z >= from) & (*z <= to));
            }
        }
        clear
    }

    /// Plan coordinates in the frame in which the camera stands on +x.
    #[inline(always)]
    fn turned(&self, x: f64, y: f64) -> (f64, f64) {
        (x * self.turn.0 + y * self.turn.1, y * self.turn.0 - x * self.turn.1)
    }

    /// Unit direction, in the tank frame, in which ray (b, s) leaves the camera.
    fn direction(&self, b: f64, s: f64) -> Vec3 {
        let n = self.path.n_squared[0].sqrt();
        let (along, z) = (b / (n * self.path.r0), s / n);
        let out = -(1.0 - along * along - z * z).sqrt();
        Vec3::new(out * self.turn.0 - along * self.turn.1, out * self.turn.1 + along * self.turn.0, z)
    }
}

/// Largest |s| in use. Very steep rays cross each other: on the axis from the s on at which the exit
/// determinant vanishes for b = 0, beside it somewhat earlier.
fn steepest(path: &Path) -> f64 {
    let [n1, n2, n3] = path.n_squared.map(f64::sqrt);
    let most = STEEPEST_SINE * n1.min(n2).min(n3);
    let steps = 1000.0;
    let crossing = (1..1000).map(|i| most * f64::from(i) / steps).find(|&s| path.exit_determinant(0.0, s) >= 0.0);
    crossing.map_or(most, |s| STEEPEST_SINE * s)
}

#[cfg(test)]
mod tests;
