//! `rootvox evaluate`: a result against a truth.

use super::score_table::table;
use crate::error::{Error, Result};
use crate::evaluation::{CameraErrors, Found, ScoreParams, camera_errors, detail, score};
use crate::formats::points_csv::{self, Points};
use crate::formats::{NamedView, cameras_json, roots_json, tank_json};
use crate::optics::{Tank, View};
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};

/// Score a result against the true roots: precision, recall and F1 at several tolerances.
///
/// Precision is the share of reconstructed points within the tolerance of a true centreline, recall the share
/// of the true centrelines (sampled every 0.25 mm) with a reconstructed point within it, F1 their harmonic mean.
///
/// Example:
///   rootvox evaluate results/quickstart captures/quickstart
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Evaluate {
    /// A results folder, or a CSV table with x_mm, y_mm, z_mm (with root_id: polylines; `roots.csv` of a result: roots).
    result: PathBuf,
    /// Folder with roots.json and tank.json.
    truth: PathBuf,
    /// Score only below this depth, mm; 16 mm under the water level when absent.
    #[arg(long, value_name = "MM")]
    z_min: Option<f64>,
    /// Score only above this depth, mm.
    #[arg(long, value_name = "MM", default_value_t = 178.0)]
    z_max: f64,
    /// Tolerances, mm.
    #[arg(long = "tol", value_name = "MM", num_args = 1.., default_values_t = [0.5, 1.0, 2.0])]
    tolerances: Vec<f64>,
    /// First turn the result about the tank's axis to where it fits best: cameras found from photographs alone
    /// fix the tank frame only up to that turn.
    #[arg(long)]
    free_azimuth: bool,
    /// Write JSON instead of a table.
    #[arg(long)]
    json: bool,
}

impl Evaluate {
    /// Prints the score.
    ///
    /// # Errors
    /// Where a file is missing or malformed, or no true root lies in the region.
    #[expect(clippy::print_stdout, reason = "the score is the data")]
    pub fn run(&self) -> Result<()> {
        let points_path = if self.result.is_dir() { self.result.join("root_voxels.csv") } else { self.result.clone() };
        let bytes = fs::read(&points_path).map_err(|e| missing(&points_path, &e, "a results folder or a CSV table"))?;
        let points = points_csv::parse(&points_path.display().to_string(), &bytes)?;
        let roots_path = self.truth.join("roots.json");
        let roots = roots_json::parse(&roots_path.display().to_string(), &text(&roots_path)?)?;
        let tank_path = self.truth.join("tank.json");
        let tank = tank_json::parse(&tank_path.display().to_string(), &text(&tank_path)?)?;
        let params = ScoreParams {
            z_min_mm: self.z_min,
            z_max_mm: self.z_max,
            tolerances_mm: self.tolerances.clone(),
            free_azimuth: self.free_azimuth,
        };
        let found = match &points {
            Points::Bare(points) => Found::Points(points),
            Points::Lines(lines) => Found::Lines(lines),
            Points::Roots(roots) => Found::Roots(roots),
        };
        let score = score(&roots, &tank, found, &params)?;
        let detail = detail(&roots, &tank, found, &params, score.turned_deg)?;
        let cameras = self.camera_errors(&tank)?;
        if self.json {
            let all = serde_json::json!({ "score": score, "detail": detail, "cameras": cameras });
            println!("{all:#}");
            return Ok(());
        }
        println!("{}", table(&score));
        if let Some(d) = detail.hausdorff95_mm {
            println!("95 % of all distances are within {d:.2} mm");
        }
        for (name, ends) in [("tips", detail.tips), ("branch points", detail.branch_points)] {
            if let Some(m) = ends {
                let (true_ends, found) = (m.truth, m.found);
                println!("{name}: {true_ends} true, {found} found, {} within 2 mm of each other", m.matched);
            }
        }
        if let Some(c) = cameras {
            println!(
                "cameras: {} views; axis tilted by {:.3}°, off by {:.3} mm; height {:+.3} mm; scale {:+.4} %; \
                 points in the water {:.3} px rms",
                c.views,
                c.axis_tilt_deg,
                c.axis_offset_mm,
                c.height_mm,
                c.scale * 100.0,
                c.water_rms_px
            );
        }
        Ok(())
    }

    /// Errors of the cameras, where both the result and the truth have a cameras.json.
    fn camera_errors(&self, tank: &Tank) -> Result<Option<CameraErrors>> {
        let read = |folder: &Path| -> Result<Option<Vec<NamedView>>> {
            let path = folder.join("cameras.json");
            if !path.is_file() {
                return Ok(None);
            }
            cameras_json::parse(&path.display().to_string(), &text(&path)?).map(Some)
        };
        let (Some(truth), Some(found)) = (read(&self.truth)?, read(&self.result)?) else { return Ok(None) };
        let name = |v: &NamedView| v.file.rsplit('/').next().unwrap_or_default().to_owned();
        let pairs: Vec<(View, View)> = truth
            .iter()
            .filter_map(|t| Some((t.view.clone(), found.iter().find(|f| name(f) == name(t))?.view.clone())))
            .collect();
        camera_errors(&pairs, tank, tank).map(Some)
    }
}

fn text(path: &Path) -> Result<String> {
    fs::read_to_string(path).map_err(|e| missing(path, &e, "a folder with roots.json and tank.json"))
}

fn missing(path: &Path, e: &std::io::Error, wanted: &str) -> Error {
    let mut error = Error::usage(format!("cannot read `{}`: {e}", path.display()));
    error.help = Some(format!("name {wanted}"));
    error
}
