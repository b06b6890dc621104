//! Follows the traced roots onto a photograph, through the refraction, as lines for the report.
//! In: camera, system. Out: lines (JSON).

use super::overlay::seen_at;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View, ViewMap};
use crate::report::lines::{Dot, root_lines};
use crate::roots::RootSystem;
use serde::Serialize;

/// The lines of one photograph.
#[derive(Debug, Clone, Serialize)]
pub struct RootLines {
    /// The tank between roots and camera.
    pub tank: Tank,
}

impl Stage for RootLines {
    const NAME: &'static str = "root-lines";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let view: View = inputs.one("camera")?.json("view")?;
        let ideal = view.ideal();
        let map = ViewMap::new(&ideal, &self.tank)?;
        let roots = inputs.one("system")?.json::<RootSystem>("system.json")?.plain();
        let centre = ideal.centre_in_tank();
        // Widths only tell roots apart here: what refraction adds to them does not matter.
        let lines = root_lines(&roots, |p| {
            let pixel = seen_at(&map, p)?;
            Some(Dot { pixel, px_per_mm: ideal.lens.focal_px / (p - centre).norm() })
        });
        output.json("lines", &lines)
    }
}
