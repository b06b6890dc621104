//! Reads lens and poses from a camera file and checks them against the tank.
//! In: file. Out: cameras (JSON, one entry per photograph), lens (JSON).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::cameras_json;
use crate::optics::Tank;
use serde::Serialize;

/// The cameras of a study, from a `cameras.json` in the tank frame.
#[derive(Debug, Clone, Serialize)]
pub struct Cameras {
    /// The tank that the cameras must stand outside of.
    pub tank: Tank,
}

impl Stage for Cameras {
    const NAME: &'static str = "cameras";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let file = inputs.one("file")?;
        let name = file.path("file")?.display().to_string();
        let text = String::from_utf8(file.bytes("file")?)
            .map_err(|_| Error::failed(format!("`{name}` is no text")).help("cameras.path names a cameras.json"))?;
        let views = cameras_json::parse(&name, &text)?;
        let inside = views.iter().filter_map(|v| {
            let centre = v.view.centre_in_tank();
            let distance = centre.x.hypot(centre.y);
            (distance <= self.tank.radius_mm).then(|| {
                Error::failed(format!(
                    "`{name}`, view `{}`: the camera stands inside the tank ({distance:.1} mm from its axis, the radius is {} mm)",
                    v.file, self.tank.radius_mm
                ))
                .help("poses are x_cam = R x_tank + t in mm with the tank's axis as z; the camera centre is -Rᵀ t")
            })
        });
        Error::many(inside.collect())?;
        output.json("lens", &views[0].view.lens)?;
        output.json("cameras", &views)
    }
}
