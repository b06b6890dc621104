//! What a person looks at to trust the cameras: outlines on the photographs, the ring of cameras.
//! In: pose, photos (files). Out: `outline/<photograph>.jpg` each, ring.svg.

use crate::calibration::Registration;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::picture;
use crate::optics::Tank;
use crate::photo;
use crate::report::{outline, ring};
use serde::Serialize;

/// Pictures of a registration.
#[derive(Debug, Clone, Serialize)]
pub struct PosePictures {
    /// The tank.
    pub tank: Tank,
    /// Thickness of the printed belts, mm.
    pub print_thickness_mm: f64,
    /// File name of each photograph, without folders, in capture order.
    pub photos: Vec<String>,
}

/// Name under which a photograph's outline is kept.
pub fn outline_name(photo: &str) -> String {
    let stem = photo.rsplit_once('.').map_or(photo, |(stem, _)| stem);
    format!("outline-{stem}.jpg")
}

impl Stage for PosePictures {
    const NAME: &'static str = "pose-pictures";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let registration: Registration = inputs.one("pose")?.json("registration")?;
        let files = inputs.many("photos");
        if files.len() != registration.views.len() {
            return Err(Error::failed(format!("{} photographs for {} views", files.len(), registration.views.len())));
        }
        output.bytes("ring.svg", ring::svg(&registration.views, &self.tank).as_bytes())?;
        let radius_mm = self.tank.radius_mm + self.print_thickness_mm;
        progress.total(files.len() as u64);
        for (k, (file, view)) in files.iter().zip(&registration.views).enumerate() {
            progress.check()?;
            let mut picture = photo::decode(&file.bytes("file")?, &self.photos[k])?.into_picture();
            let edges: Vec<_> = registration.edges.iter().filter(|e| e.view == k).cloned().collect();
            outline::draw(&mut picture, view, &self.tank, radius_mm, &edges);
            output.bytes(&outline_name(&self.photos[k]), &picture::jpeg(picture.view(), 90)?)?;
            progress.advance(1);
        }
        Ok(())
    }

    fn peak_bytes(&self) -> u64 {
        512 << 20
    }
}
