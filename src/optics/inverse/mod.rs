//! From a point in the water to the pixel that sees it: the exact inverse of the ray's refraction.
//! Paper 2.3.2, without the search over rays; the equations stand in [`path`].
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
mod path;
mod solve;

use super::{Tank, Vec3, View};
use crate::error::{Error, Result};
use fold::Fold;
use path::Path;
pub use solve::{LANES, Lanes};

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
        Ok(Self { view: view.clone(), tank: tank.clone(), path, fold, turn: (c.x / r0, c.y / r0), s_range })
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
            clear: self.is_clear(wall_z_mm, water_z_mm),
            wall_z_mm,
            water_z_mm,
        })
    }

    /// Pixel of ray (b, s), where it carries evidence.
    #[inline]
    pub fn clear_pixel(&self, b: f64, s: f64) -> Option<(f64, f64)> {
        let (wall_z_mm, water_z_mm) = self.path.entry_heights(b, s);
        if self.is_clear(wall_z_mm, water_z_mm) { self.view.pixel_of_direction(&self.direction(b, s)) } else { None }
    }

    /// Whether a ray that meets the walls at these heights carries evidence.
    #[inline]
    pub fn is_clear(&self, wall_z_mm: f64, water_z_mm: f64) -> bool {
        self.tank.is_clear(wall_z_mm) && water_z_mm > self.tank.water_level_mm && water_z_mm < self.tank.floor_mm()
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
