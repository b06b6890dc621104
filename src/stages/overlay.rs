//! Draws the extracted roots back onto a photograph, through the refraction.  Paper 2.5, figure 7.
//! In: photo (undistorted), camera, roots. Out: overlay.jpg.

use super::{extract, photographs};
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::optics::{Tank, Vec3, View, ViewMap};
use crate::report::overlay::{Mark, overlay};
use crate::report::palette;
use serde::Serialize;

/// One overlay picture.
#[derive(Debug, Clone, Serialize)]
pub struct Overlay {
    /// The tank between roots and camera.
    pub tank: Tank,
    /// Radius of a mark, px.
    pub mark_radius_px: f64,
}

/// JPEG quality of the overlays: pictures to look at, not to measure on.
pub(super) const QUALITY: u8 = 85;

/// A root farther than this from the nearest regular ray is out of the view's sight.
const OUT_OF_SIGHT_MM: f64 = 0.1;

/// Where the view sees the point through a regular, clear ray.
pub(super) fn seen_at(map: &ViewMap, point_mm: &Vec3) -> Option<[f64; 2]> {
    let seen = map.project(point_mm).filter(|p| p.clear && p.distance_mm <= OUT_OF_SIGHT_MM)?;
    Some([seen.u, seen.v])
}

impl Stage for Overlay {
    const NAME: &'static str = "overlay";
    const VERSION: u32 = 3;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let photo = photographs::picture(inputs.one("photo")?)?;
        let view: View = inputs.one("camera")?.json("view")?;
        let ideal = view.ideal();
        let map = ViewMap::new(&ideal, &self.tank)?;
        let roots = extract::read(inputs.one("roots")?)?;
        let marks: Vec<Mark> = roots
            .iter()
            .filter_map(|r| {
                let [x, y, z] = r.point_mm.map(f64::from);
                let [u, v] = seen_at(&map, &Vec3::new(x, y, z))?;
                Some(Mark { u, v, colour: palette::distinct(r.component as usize) })
            })
            .collect();
        let picture = overlay(photo, &ideal, &self.tank, &marks, self.mark_radius_px);
        output.bytes("overlay.jpg", &picture::jpeg(picture.view(), QUALITY)?)
    }
}
