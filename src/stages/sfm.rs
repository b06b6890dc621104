//! Structure from motion on the masked photographs, by the COLMAP program.  Paper 2.2.1.
//! In: photos (files), mask, lens (a file, where the lens is known). Out: sparse (JSON: lenses, poses, points with tracks), program (JSON: its version).
//!
//! Orders, numbers and the frame of COLMAP's model are normalised; for one version on one machine a fixed seed
//! repeats the model up to the rounding of sums over threads, so that two computations may differ in the last digits.

use super::colmap_photos::Photographs;
use super::colmap_run::{Job, run};
use crate::calibration::SparseModel;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::colmap::camera_model;
use crate::formats::colmap::command::{Features, Intrinsics};
use crate::formats::opencv_lens;
use crate::optics::Lens;
use serde::{Deserialize, Serialize};

/// How structure from motion is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SfmParams {
    /// How many next photographs around the ring each one is matched with. 0 takes a sixth of the ring and two more,
    /// for the belts are shared over some 60 degrees. Where not all photographs register so, features are looked for
    /// anew that match over larger steps, in a quarter of the ring and one more.
    pub neighbours: usize,
    /// COLMAP's random seed.
    pub seed: u32,
}

impl Default for SfmParams {
    fn default() -> Self {
        Self { neighbours: 0, seed: 1 }
    }
}

/// Structure from motion.
#[derive(Debug, Clone, Serialize)]
pub struct Sfm {
    /// File name of each photograph, without folders, in capture order.
    pub photos: Vec<String>,
    /// The program's name and version, as [`installed`] tells: another version may find another model.
    pub program: String,
    /// How it is run.
    pub params: SfmParams,
}

/// Name and version of the COLMAP program; empty where it is missing (the run then says how to get it).
pub fn installed() -> String {
    super::colmap_run::program().unwrap_or_default()
}

impl Stage for Sfm {
    const NAME: &'static str = "sfm";
    const VERSION: u32 = 3;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let files = inputs.many("photos");
        if files.len() != self.photos.len() || files.len() < 3 {
            return Err(Error::failed(format!(
                "structure from motion needs at least 3 photographs, not {}",
                files.len()
            )));
        }
        let mut handed = Photographs::of(&self.photos, inputs)?;
        let lens = known_lens(inputs)?;
        if let Some(lens) = &lens {
            let (model, params) = camera_model(lens)?;
            handed.lens = Intrinsics::Known(model, params);
        }
        let n = files.len();
        let mask_png = inputs.one("mask")?.bytes("mask.png")?;
        let plain = Features { affine: false, seed: self.params.seed };
        let affine = Features { affine: true, ..plain };
        let attempts = match self.params.neighbours {
            0 => [(n.div_ceil(6) + 2, plain), (n.div_ceil(4) + 1, affine)],
            given => [(given, plain), (given, affine)],
        };
        let mut job = Job { handed: &handed, mask_png: &mask_png, neighbours: 0, features: plain, known: None };
        let mut found = None;
        for (neighbours, features) in attempts {
            (job.neighbours, job.features) = (neighbours, features);
            found = Some(run(&job, progress));
            if found.as_ref().is_some_and(|f| f.as_ref().is_ok_and(|(sparse, _)| sparse.views.len() == n)) {
                break;
            }
            progress.check()?;
        }
        let (mut sparse, program) = found.unwrap_or_else(|| Err(Error::failed("structure from motion was not run")))?;
        check_registered(&self.photos, &sparse)?;
        if let Some(lens) = lens {
            sparse.views.iter_mut().for_each(|view| view.lens = lens);
        }
        let rms = sparse.reprojection_rms_px().unwrap_or(f64::INFINITY);
        if rms > 1.5 {
            output.warn(format!("structure from motion reprojects its points with {rms:.2} px root mean square"));
        }
        output.json("program", &program)?;
        output.json("sparse", &sparse)
    }

    fn peak_bytes(&self) -> u64 {
        2 << 30
    }
}

/// The lens of the port `lens`, where there is one.
pub(super) fn known_lens(inputs: &Inputs) -> Result<Option<Lens>> {
    let [file, ..] = inputs.many("lens") else { return Ok(None) };
    let name = file.path("file")?.display().to_string();
    opencv_lens::parse(&name, &String::from_utf8_lossy(&file.bytes("file")?)).map(Some)
}

/// Every photograph of a study needs its camera.
pub(super) fn check_registered(photos: &[String], sparse: &SparseModel) -> Result<()> {
    let lost: Vec<&str> =
        photos.iter().filter(|p| sparse.views.iter().all(|v| v.file != **p)).map(String::as_str).collect();
    if lost.is_empty() {
        return Ok(());
    }
    Err(Error::failed(format!(
        "structure from motion registered {} of {} photographs; not registered: {}",
        sparse.views.len(),
        photos.len(),
        lost.join(", ")
    ))
    .help(
        "photographs must follow each other around the tank in small steps (15 degrees or less), the belts sharp \
         and alike; check the sfm-mask, or leave these photographs out of photos.images",
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::sparse::SparseView;
    use crate::optics::{Distortion, Lens, Mat3, Vec3};

    #[test]
    fn photographs_that_did_not_register_are_named() {
        let lens = Lens { width: 9, height: 9, focal_px: 9.0, cx: 4.0, cy: 4.0, distortion: Distortion::default() };
        let view =
            |file: &str| SparseView { file: file.into(), lens, rotation: Mat3::identity(), translation: Vec3::zeros() };
        let sparse = SparseModel { views: vec![view("a.jpg"), view("c.jpg")], points: Vec::new() };
        let names = ["a.jpg", "b.jpg", "c.jpg"].map(str::to_owned);
        let e = check_registered(&names, &sparse).unwrap_err();
        assert!(e.message.contains("2 of 3") && e.message.contains("b.jpg") && e.help.is_some(), "{e}");
        assert!(check_registered(&names[..1], &sparse).is_ok());
    }
}
