//! Belt points for cameras that a file gives in a frame of its own.  Paper 2.2.1.
//! In: file (the camera file's parts), photos (files), mask. Out: sparse (JSON: lenses, poses, points with tracks), program
//! (JSON: version of the program that found the points, or that none was needed).
//!
//! A COLMAP model brings its points; for other files the COLMAP program triangulates some between the known poses.

use super::colmap_photos::Photographs;
use super::colmap_run::{Job, run};
use super::sfm::{SfmParams, check_registered};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::camera_file;
use crate::formats::colmap::command::Features;
use serde::Serialize;

/// Cameras from a file, not yet in the tank frame.
#[derive(Debug, Clone, Serialize)]
pub struct SfmKnown {
    /// File name of each photograph, without folders, in capture order.
    pub photos: Vec<String>,
    /// How points are found where the file has none.
    pub params: SfmParams,
}

impl Stage for SfmKnown {
    const NAME: &'static str = "sfm-known";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let mut known = camera_file::parse(&super::cameras::files(inputs)?)?;
        // Views by the names and in the order of the photographs; others are left out.
        let mut from = vec![None; known.views.len()];
        let mut views = Vec::new();
        for photo in &self.photos {
            let Some(k) = known.views.iter().position(|v| camera_file::means(&v.file, photo)) else { continue };
            from[k] = Some(views.len());
            views.push(known.views[k].clone());
            if let Some(view) = views.last_mut() {
                view.file.clone_from(photo);
            }
        }
        known.views = views;
        for p in &mut known.points {
            p.seen.retain_mut(|s| from[s.view].map(|k| s.view = k).is_some());
        }
        known.points.retain(|p| p.seen.len() >= 2);
        check_registered(&self.photos, &known)?;
        if !known.points.is_empty() {
            output.json("program", &"none")?;
            return output.json("sparse", &known.normalised());
        }
        known.one_lens()?;
        let handed = Photographs::of(&self.photos, inputs)?;
        let n = handed.photos.len();
        let mask_png = inputs.one("mask")?.bytes("mask.png")?;
        let neighbours = if self.params.neighbours == 0 { n.div_ceil(6) + 2 } else { self.params.neighbours };
        let features = Features { affine: n < 20, seed: self.params.seed };
        let job = Job { handed: &handed, mask_png: &mask_png, neighbours, features, known: Some(&known) };
        let (sparse, program) = run(&job, progress)?;
        if sparse.points.len() < 30 {
            return Err(Error::failed(format!("only {} points fit the camera file's poses", sparse.points.len()))
                .help("do lens and poses belong to these photographs? Poses are x_cam = R x + t"));
        }
        output.json("program", &program)?;
        output.json("sparse", &sparse)
    }

    fn peak_bytes(&self) -> u64 {
        2 << 30
    }
}
