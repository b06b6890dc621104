//! Brings the cameras of structure from motion into the tank frame.  Paper 2.2.3, and the joint adjustment.
//! In: sparse, photos (files). Out: cameras (JSON, one entry per photograph), lens (JSON), registration (JSON: quality,
//! belt points).

use crate::calibration::{RegisterParams, SparseModel, register};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::optics::Tank;
use crate::photo;
use ndarray::Array2;
use serde::Serialize;

/// Cameras in the tank frame.
#[derive(Debug, Clone, Serialize)]
pub struct Pose {
    /// The tank.
    pub tank: Tank,
    /// File name of each photograph, without folders, in capture order.
    pub photos: Vec<String>,
    /// How cameras and tank are brought together.
    pub params: RegisterParams,
}

impl Stage for Pose {
    const NAME: &'static str = "pose";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let sparse: SparseModel = inputs.one("sparse")?.json("sparse")?;
        let files = inputs.many("photos");
        progress.total(sparse.views.len() as u64 + 1);
        let mut photos: Vec<Array2<u8>> = Vec::with_capacity(sparse.views.len());
        for view in &sparse.views {
            progress.check()?;
            let file = self.photos.iter().position(|p| *p == view.file).and_then(|k| files.get(k));
            let file = file.ok_or_else(|| {
                Error::failed(format!("the sparse model names the photograph `{}`, which the study lacks", view.file))
            })?;
            photos.push(photo::gray(&photo::decode(&file.bytes("file")?, &view.file)?));
            progress.advance(1);
        }
        let photos: Vec<_> = photos.iter().map(|p| p.view()).collect();
        let registration = register(&sparse, &photos, &self.tank, None, &self.params)?;
        registration.warnings.iter().for_each(|w| output.warn(w.as_str()));
        let named = sparse.views.iter().zip(&registration.views);
        let views: Vec<NamedView> = named.map(|(s, v)| NamedView { file: s.file.clone(), view: v.clone() }).collect();
        output.json("lens", &registration.views[0].lens)?;
        output.json("cameras", &views)?;
        output.json("registration", &registration)
    }

    fn peak_bytes(&self) -> u64 {
        1 << 30
    }
}
