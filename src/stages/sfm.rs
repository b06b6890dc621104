//! Structure from motion on the masked photographs, by the COLMAP program.  Paper 2.2.1.
//! In: photos (files), mask. Out: sparse (JSON: lens, poses, points with tracks), program (JSON: its version).
//!
//! Orders, numbers and the frame of COLMAP's model are normalised; for one version on one machine a fixed seed
//! repeats the model up to the rounding of sums over threads, so that two computations may differ in the last digits.

use super::colmap_run::{Job, run};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use serde::{Deserialize, Serialize};

/// How structure from motion is run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SfmParams {
    /// How many next photographs around the ring each one is matched with; 0 takes all pairs up to 40
    /// photographs, and a sixth of the ring plus 2 beyond: the belts are shared over some 60 degrees.
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
    /// How it is run.
    pub params: SfmParams,
}

impl Stage for Sfm {
    const NAME: &'static str = "sfm";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let files = inputs.many("photos");
        if files.len() != self.photos.len() || files.len() < 3 {
            return Err(Error::failed(format!(
                "structure from motion needs at least 3 photographs, not {}",
                files.len()
            )));
        }
        let photos = self
            .photos
            .iter()
            .zip(files)
            .map(|(name, f)| Ok((name.clone(), f.bytes("file")?)))
            .collect::<Result<Vec<_>>>()?;
        let n = photos.len();
        let neighbours = match self.params.neighbours {
            0 if n <= 40 => n,
            0 => n.div_ceil(6) + 2,
            given => given,
        };
        let mask_png = inputs.one("mask")?.bytes("mask.png")?;
        let job = Job { photos, mask_png: &mask_png, neighbours, seed: self.params.seed };
        let (sparse, program) = run(&job, progress)?;
        let lost: Vec<&str> =
            self.photos.iter().filter(|p| sparse.views.iter().all(|v| v.file != **p)).map(String::as_str).collect();
        if !lost.is_empty() {
            return Err(Error::failed(format!(
                "structure from motion registered {} of {n} photographs; not registered: {}",
                sparse.views.len(),
                lost.join(", ")
            ))
            .help(
                "photographs must follow each other around the tank in small steps (15 degrees or less), the belts sharp \
                 and alike; check the sfm-mask, or leave these photographs out of photos.images",
            ));
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
