//! Picks one photograph's view out of the cameras, so that a changed pose re-runs that view alone.
//! In: cameras. Out: view (JSON).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{NamedView, camera_file};
use serde::Serialize;

/// One view of the cameras.
#[derive(Debug, Clone, Serialize)]
pub struct Camera {
    /// File name of the photograph, without folders.
    pub photo: String,
}

impl Stage for Camera {
    const NAME: &'static str = "camera";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let views: Vec<NamedView> = inputs.one("cameras")?.json("cameras")?;
        let mut found = views.iter().filter(|v| camera_file::means(&v.file, &self.photo));
        match (found.next(), found.next()) {
            (Some(v), None) => output.json("view", &v.view),
            (None, _) => Err(Error::failed(format!("the cameras hold no view of the photograph `{}`", self.photo))
                .help("`file` of each view must name its photograph; leave photographs without a camera out of photos.images")),
            (Some(a), Some(b)) => {
                Err(Error::failed(format!("the cameras name `{}` twice: `{}` and `{}`", self.photo, a.file, b.file)))
            }
        }
    }
}
