//! Brings the cameras of structure from motion into the tank frame.  Paper 2.2.3, and the joint adjustment.
//! In: sparse, photos (files), lens (a file, where the lens is known). Out: cameras (JSON, one entry per photograph), registration (JSON: quality,
//! belt points).

use super::photographs::check_size;
use crate::calibration::{LensPrior, Method, RegisterParams, SparseModel, chamfer, register};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::NamedView;
use crate::optics::Tank;
use crate::photo::{self, Metadata};
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
    const VERSION: u32 = 5;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let sparse: SparseModel = inputs.one("sparse")?.json("sparse")?;
        let files = inputs.many("photos");
        progress.total(sparse.views.len() as u64 + 1);
        let mut photos: Vec<Array2<u8>> = Vec::with_capacity(sparse.views.len());
        let mut shrunken = Vec::new();
        let mut focal_prior_px = None;
        for view in &sparse.views {
            progress.check()?;
            let file = self.photos.iter().position(|p| *p == view.file).and_then(|k| files.get(k));
            let file = file.ok_or_else(|| {
                Error::failed(format!("the sparse model names the photograph `{}`, which the study lacks", view.file))
            })?;
            let bytes = file.bytes("file")?;
            let photo = photo::decode(&bytes, &view.file)?;
            let lens = &view.lens;
            check_size(&view.file, &bytes, &photo, lens)?;
            let of_camera = || Metadata::of(&bytes)?.focal_px(lens.width, lens.height);
            focal_prior_px = focal_prior_px.or_else(of_camera);
            let photo = photo.into_picture();
            if self.params.method == Method::Chamfer {
                shrunken.push(chamfer::shrunken(&photo, lens, self.params.chamfer.shrink.clamp(1, 16)));
            }
            photos.push(photo::gray(&photo));
            progress.advance(1);
        }
        let photos: Vec<_> = photos.iter().map(|p| p.view()).collect();
        let prior = match (inputs.many("lens"), focal_prior_px) {
            ([_, ..], _) => LensPrior::Known,
            ([], Some(focal_px)) => LensPrior::Focal(focal_px),
            ([], None) => LensPrior::None,
        };
        let registration = register(&sparse, &photos, &shrunken, &self.tank, prior, &self.params)?;
        registration.warnings.iter().for_each(|w| output.warn(w.as_str()));
        let named = sparse.views.iter().zip(&registration.views);
        let views: Vec<NamedView> = named.map(|(s, v)| NamedView { file: s.file.clone(), view: v.clone() }).collect();
        if views.is_empty() {
            return Err(Error::failed("no view was registered"));
        }
        output.json("cameras", &views)?;
        output.json("registration", &registration)
    }

    fn peak_bytes(&self) -> u64 {
        1 << 30
    }
}
