//! Holds what the photographs say of themselves against each other, and warns.
//! In: photos (files). Out: photographs (JSON, one entry per photograph: name, format, width and height upright, EXIF
//! orientation, time).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::photo::sequence::{Told, doubts};
use serde::Serialize;
use serde_json::json;

/// A look at all photographs.
#[derive(Debug, Clone, Serialize)]
pub struct Survey {
    /// File name of each photograph, without folders, in capture order.
    pub photos: Vec<String>,
    /// Whether lens and poses come from a file, which could mean the pixels as stored.
    pub has_camera_file: bool,
}

impl Stage for Survey {
    const NAME: &'static str = "survey";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let files = inputs.many("photos");
        if files.len() != self.photos.len() {
            return Err(Error::failed(format!("{} photographs for {} names", files.len(), self.photos.len())));
        }
        progress.total(files.len() as u64);
        let mut all = Vec::with_capacity(files.len());
        for (name, file) in self.photos.iter().zip(files) {
            progress.check()?;
            let bytes = file.bytes("file")?;
            // What cannot be read is complained of where its pixels are wanted.
            all.extend(Told::of(&bytes, name.as_ref()));
            progress.advance(1);
        }
        doubts(&all, self.has_camera_file).into_iter().for_each(|doubt| output.warn(doubt));
        let listed: Vec<_> = all
            .iter()
            .map(|Told { name, head, taken }| {
                let (width, height) = head.size;
                let taken = taken.map(|taken| taken.to_string());
                json!({ "name": name, "format": head.format, "width": width, "height": height,
                    "orientation": head.orientation, "taken": taken })
            })
            .collect();
        output.json("photographs", &listed)
    }
}
