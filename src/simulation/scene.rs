//! Everything that a photograph needs, made ready once.

use super::bvh::Tubes;
use super::drifting::Drifting;
use super::gains::gains;
use super::marks::Marks;
use super::room::{Room, Stand, linear_rgb};
use super::sway::swayed;
use super::{BeltPrint, CaptureParams, noise};
use crate::error::{Error, Result};
use crate::optics::{Tank, Vec3, View};
use crate::roots::Root;
use std::borrow::Cow;

/// Roots in a tank in a room, and the views from which they are photographed.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(super) tank: Tank,
    pub(super) views: Vec<View>,
    /// Where each view's camera stands in the room.
    pub(super) stands: Vec<Stand>,
    /// Gain of each view's picture, per channel.
    pub(super) gains: Vec<[f64; 3]>,
    pub(super) params: CaptureParams,
    roots: Vec<Root>,
    tubes: Tubes,
    /// The stem above the crown.
    pub(super) stem: Tubes,
    pub(super) dirt: Option<Marks>,
    pub(super) bubbles: Option<Marks>,
    pub(super) drifting: Drifting,
    /// Rays that pass a root within this need a closer look, mm.
    pub(super) reach_mm: f64,
    pub(super) room: Room,
    /// Linear colour of each root.
    pub(super) root_colours: Vec<Vec3>,
    pub(super) floor_colour: Vec3,
    pub(super) prints: Vec<BeltPrint>,
    pub(super) seed: u64,
}

impl Scene {
    /// Makes the scene ready. The views may be those of [`capture`](super::capture) with the same parameters and seed, or
    /// any others of a camera that stood still (or was `carried`): what stands in the room is placed relative to the
    /// camera as it first stood.
    ///
    /// # Errors
    /// Where a parameter, the tank or a view is unusable, a root has not a radius for each point, or there is no view.
    pub fn new(tank: &Tank, roots: &[Root], views: &[View], params: &CaptureParams, seed: u64) -> Result<Self> {
        params.check()?;
        tank.check()?;
        for (i, view) in views.iter().enumerate() {
            view.check().map_err(|e| e.at(format!("view {i}")))?;
            let centre = view.centre_in_tank();
            if centre.x.hypot(centre.y) <= tank.radius_mm {
                return Err(Error::failed(format!("view {i}: the camera lies inside the tank's cylinder"))
                    .help("cameras must stand farther from the axis than the tank's outer radius"));
            }
        }
        let Some(first) = views.first() else {
            return Err(Error::failed("no view to photograph from").help("give at least one camera"));
        };
        for root in roots {
            let sound = root.points_mm.iter().flatten().chain(&root.radii_mm).all(|x| x.is_finite());
            if root.points_mm.len() != root.radii_mm.len() || !sound || root.radii_mm.iter().any(|&r| r <= 0.0) {
                return Err(Error::failed(format!("root {}: unusable points or radii", root.id))
                    .help("every point needs a positive radius, and all numbers must be finite"));
            }
        }
        // A pixel's footprint in the middle of the tank: rays that pass a root that near need a closer look.
        let centre = first.centre_in_tank();
        let focal_px = views.iter().map(|view| view.lens.focal_px).fold(f64::INFINITY, f64::min);
        let reach_mm = centre.x.hypot(centre.y) / focal_px;
        let colour = linear_rgb(params.root_rgb);
        let root_colours = (0..roots.len() as u64)
            .map(|i| colour * (1.0 + params.root_variation * (2.0 * noise::uniform(noise::hash(seed, &[13, i])) - 1.0)))
            .collect();
        let prints = tank
            .belts_mm
            .iter()
            .enumerate()
            .map(|(i, b)| BeltPrint::new(tank.radius_mm + BELT_MM, b[1] - b[0], params.belt_seed + i as u64))
            .collect();
        let marks = |radius_mm: f64, count: usize, size_mm: f64, kind: u64| {
            (count > 0).then(|| Marks::new(tank, radius_mm, count, size_mm, noise::hash(seed, &[kind])))
        };
        let stands = Stand::all(views, params, seed);
        Ok(Self {
            tank: tank.clone(),
            views: views.to_vec(),
            gains: gains(params, views.len(), seed),
            params: params.clone(),
            roots: roots.to_vec(),
            tubes: Tubes::new(roots),
            stem: Tubes::new(&stem(roots, tank, params.stem)),
            dirt: marks(tank.radius_mm, params.dirt, params.dirt_mm, 1),
            bubbles: marks(tank.inner_radius_mm(), params.bubbles, params.bubble_mm, 2),
            reach_mm,
            drifting: Drifting::new(tank, params.drifting, params.drifting_mm, seed),
            room: Room::new(params, tank, &stands, seed),
            stands,
            root_colours,
            floor_colour: linear_rgb(params.floor_rgb),
            prints,
            seed,
        })
    }

    /// The roots as they hang in that view.
    pub(super) fn tubes(&self, view: usize) -> Cow<'_, Tubes> {
        let CaptureParams { sway_mm, sway_views, .. } = &self.params;
        if *sway_mm > 0.0 && (sway_views.is_empty() || sway_views.contains(&view)) {
            Cow::Owned(Tubes::new(&swayed(&self.roots, &self.tank, *sway_mm, self.seed, view)))
        } else {
            Cow::Borrowed(&self.tubes)
        }
    }

    /// The views, in order.
    pub fn views(&self) -> &[View] {
        &self.views
    }
}

/// A stem that rises from the first main root's crown to 0.6 of the tank's height above the rim, leaning a little.
fn stem(roots: &[Root], tank: &Tank, wanted: bool) -> Vec<Root> {
    let crown = roots.iter().find(|r| wanted && r.parent < 0 && !r.points_mm.is_empty());
    crown
        .map(|root| {
            let [x, y, z] = root.points_mm[0];
            let rise = 0.6 * tank.height_mm;
            let points_mm = (0..=20)
                .map(|i| {
                    let s = f64::from(i) / 20.0;
                    [x + 0.05 * rise * s * s, y + 0.03 * rise * s, z - rise * s]
                })
                .collect();
            let radii_mm = vec![(1.2 * root.radii_mm[0]).max(1.0); 21];
            Root { id: -1, parent: -1, order: 0, points_mm, radii_mm }
        })
        .into_iter()
        .collect()
}

/// The belts' distance from the outer wall, mm.
pub(super) const BELT_MM: f64 = 0.1;
