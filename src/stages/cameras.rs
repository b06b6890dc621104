//! Reads lens and poses from a camera file and checks them against the tank.
//! In: file (one, or the three of a COLMAP model). Out: cameras (JSON, one entry per photograph).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{NamedView, camera_file};
use crate::optics::{Tank, View};
use crate::store::Artefact;
use serde::Serialize;

/// The cameras of a study, from a camera file in the tank frame.
#[derive(Debug, Clone, Serialize)]
pub struct Cameras {
    /// The tank that the cameras must stand outside of.
    pub tank: Tank,
}

impl Stage for Cameras {
    const NAME: &'static str = "cameras";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let files = files(inputs)?;
        let name = &files[0].0;
        let model = camera_file::parse(&files)?;
        let views: Vec<NamedView> = model
            .views
            .into_iter()
            .map(|v| NamedView {
                file: v.file,
                view: View { lens: v.lens, rotation: v.rotation, translation_mm: v.translation },
            })
            .collect();
        let inside = views.iter().filter_map(|v| {
            let centre = v.view.centre_in_tank();
            let distance = centre.x.hypot(centre.y);
            (distance <= self.tank.radius_mm).then(|| {
                Error::failed(format!(
                    "`{name}`, view `{}`: the camera stands inside the tank ({distance:.1} mm from its axis, the radius is {} mm)",
                    v.file, self.tank.radius_mm
                ))
                .help(
                    "poses are x_cam = R x_tank + t in mm with the tank's axis as z; the camera centre is -Rᵀ t. Where the \
                     file has a frame of its own, say cameras.frame = \"free\"",
                )
            })
        });
        Error::many(inside.collect())?;
        output.json("cameras", &views)
    }
}

/// Names and contents of the camera file's parts.
pub(super) fn files(inputs: &Inputs) -> Result<Vec<(String, Vec<u8>)>> {
    let of = |f: &Artefact| Ok((f.path("file")?.display().to_string(), f.bytes("file")?));
    let files = inputs.many("file").iter().map(of).collect::<Result<Vec<_>>>()?;
    if files.is_empty() { Err(Error::failed("no camera file is given")) } else { Ok(files) }
}
