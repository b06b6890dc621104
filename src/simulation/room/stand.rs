//! Where a view's camera stands in the room, and from where the lamps shine on it.
//!
//! The room's frame is the level frame of the camera as it first stood: x to the right, y away from the camera, z down.
//! Before a turning table the camera keeps its place in it and the tank turns; a carried camera walks about in it and the
//! tank keeps its place.

use crate::optics::{Mat3, Vec3, View};
use crate::simulation::CaptureParams;
use crate::simulation::bump::Bump;

/// A view's stand in the room.
#[derive(Debug, Clone)]
pub struct Stand {
    /// Camera centre in the tank frame, mm.
    pub centre_mm: Vec3,
    /// Origin of the room's frame in the tank frame, mm.
    pub origin_mm: Vec3,
    /// Turns tank directions into the room's frame.
    pub room_from_tank: Mat3,
    /// Unit direction towards the lamps, in the room's frame.
    pub lamp: Vec3,
}

impl Stand {
    /// The stands of all views.
    pub fn all(views: &[View], params: &CaptureParams, seed: u64) -> Vec<Self> {
        let bump = Bump::of(params, seed);
        let stand = |(i, view): (usize, &View)| {
            let steady = match &bump {
                _ if params.carried => views[0].clone(),
                Some(bump) => bump.undone(i, view),
                None => view.clone(),
            };
            let light = params.other_light.iter().find(|l| l.views.contains(&i));
            let lamp = light.and_then(|l| l.lamp_direction).unwrap_or(params.lamp_direction);
            Self {
                centre_mm: view.centre_in_tank(),
                origin_mm: steady.centre_in_tank(),
                room_from_tank: level(&steady),
                lamp: Vec3::from(lamp).normalize(),
            }
        };
        views.iter().enumerate().map(stand).collect()
    }
}

/// Turns tank directions into the view's level frame.
fn level(view: &View) -> Mat3 {
    let forward = view.rotation.row(2).transpose();
    // A camera that looks straight down has no "away": any will do.
    let away = Vec3::new(forward.x, forward.y, 0.0).try_normalize(1e-9).unwrap_or_else(Vec3::x);
    let right = away.cross(&Vec3::z()) * -1.0;
    Mat3::from_rows(&[right.transpose(), away.transpose(), Vec3::z().transpose()])
}
