//! Draws the roots back onto a photograph, through the refraction: one picture coloured by root, one by order.
//! In: photo (undistorted), camera, system. Out: roots.jpg, orders.jpg.

use super::overlay::{QUALITY, seen_at};
use super::photographs;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::optics::{Tank, View, ViewMap};
use crate::report::overlay::{Mark, overlay};
use crate::roots::{Root, RootSystem, ink};
use serde::Serialize;

/// The pictures of one photograph.
#[derive(Debug, Clone, Serialize)]
pub struct RootOverlay {
    /// The tank between roots and camera.
    pub tank: Tank,
    /// Radius of a line, px.
    pub line_radius_px: f64,
}

/// Steps of a drawn line, px.
const STEP_PX: f64 = 0.7;

impl Stage for RootOverlay {
    const NAME: &'static str = "root-overlay";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let photo = photographs::picture(inputs.one("photo")?)?;
        let view: View = inputs.one("camera")?.json("view")?;
        let ideal = view.ideal();
        let map = ViewMap::new(&ideal, &self.tank)?;
        let roots = inputs.one("system")?.json::<RootSystem>("system.json")?.plain();
        for (name, colour) in [("roots.jpg", ink::by_root as fn(&Root) -> [u8; 3]), ("orders.jpg", ink::by_order)] {
            let marks: Vec<Mark> = ink::lines(&roots, |p| seen_at(&map, p), colour).iter().flat_map(dots).collect();
            let picture = overlay(photo.clone(), &ideal, &self.tank, &marks, self.line_radius_px);
            output.bytes(name, &picture::jpeg(picture.view(), QUALITY)?)?;
        }
        Ok(())
    }
}

/// Marks along a line, close enough to look like one.
fn dots(line: &ink::Ink) -> Vec<Mark> {
    let mut marks = Vec::new();
    for pair in line.pixels.windows(2) {
        let [[u0, v0], [u1, v1]] = [pair[0], pair[1]];
        let n = ((u1 - u0).hypot(v1 - v0) / STEP_PX).ceil().max(1.0) as usize;
        marks.extend((0..n).map(|k| {
            let f = k as f64 / n as f64;
            Mark { u: u0 + f * (u1 - u0), v: v0 + f * (v1 - v0), colour: line.colour }
        }));
    }
    marks
}
