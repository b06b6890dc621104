//! `rootvox evaluate`: a result against a truth.

use super::score_table::table;
use crate::error::{Error, Result};
use crate::evaluation::{Found, ScoreParams, score};
use crate::formats::points_csv::{self, Points};
use crate::formats::{roots_json, tank_json};
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
    /// A results folder, or a CSV table with x_mm, y_mm, z_mm (with root_id: polylines).
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
        };
        let score = score(&roots, &tank, found, &params)?;
        if self.json {
            let json = serde_json::to_string_pretty(&score).map_err(|e| Error::failed(format!("score: {e}")))?;
            println!("{json}");
        } else {
            println!("{}", table(&score));
        }
        Ok(())
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
