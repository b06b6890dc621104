//! `rootvox evaluate`: a result against a truth.

use super::score_table::{cameras_line, detail_table, table, traits_table};
use super::terminal::{dataln, talkln};
use crate::error::{Error, Result};
use crate::evaluation::{CameraErrors, ScoreParams, camera_errors, detail, hits, score, trait_errors};
use crate::formats::points_csv::{self, Points};
use crate::formats::{NamedView, cameras_json, picture, roots_json, tank_json};
use crate::optics::Tank;
use crate::report::hits::hits_picture;
use clap::Args;
use std::fs;
use std::path::{Path, PathBuf};

/// Score a result against the true roots: precision, recall and F1 at several tolerances, and where it is right.
///
/// Precision is the share of reconstructed points within the tolerance of a true centreline, recall the share
/// of the true centrelines (sampled every 0.25 mm) with a reconstructed point within it, F1 their harmonic mean.
/// Classes of diameter, depth and distance to the wall count points within 1 mm, tips and branch points within 2 mm.
/// Of a results folder both the root voxels and the traced roots are scored, and the cameras where the truth has some.
///
/// Example:
///   rootvox evaluate results/quickstart captures/quickstart --picture hits.png
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Evaluate {
    /// A results folder, or a CSV table with x_mm, y_mm, z_mm (with root_id: polylines; as roots.csv: roots).
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
    /// Draw truth and result (PNG): light grey what was found, red what was missed, blue what is not there.
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write JSON instead of a table.
    #[arg(long)]
    json: bool,
}

/// Scale of the picture.
const PX_PER_MM: f64 = 4.0;

impl Evaluate {
    /// Prints the score.
    ///
    /// # Errors
    /// Where a file is missing or malformed, no true root lies in the region, or the picture cannot be written.
    pub fn run(&self) -> Result<()> {
        let roots_path = self.truth.join("roots.json");
        let truth = roots_json::parse(&roots_path.display().to_string(), &text(&roots_path)?)?;
        let tank_path = self.truth.join("tank.json");
        let tank = tank_json::parse(&tank_path.display().to_string(), &text(&tank_path)?)?;
        let params = ScoreParams {
            z_min_mm: self.z_min,
            z_max_mm: self.z_max,
            tolerances_mm: self.tolerances.clone(),
            free_azimuth: self.free_azimuth,
        };
        let tables = if self.result.is_dir() {
            vec![("root voxels", self.result.join("root_voxels.csv")), ("traced roots", self.result.join("roots.csv"))]
        } else {
            vec![("result", self.result.clone())]
        };
        let mut all = serde_json::Map::new();
        let mut lines = Vec::new();
        for (n, (what, path)) in tables.into_iter().enumerate() {
            // A result without traced roots is one still.
            if n > 0 && !path.is_file() {
                continue;
            }
            let bytes = fs::read(&path).map_err(|e| missing(&path, &e, "a results folder or a CSV table"))?;
            let points = points_csv::parse(&path.display().to_string(), &bytes)?;
            let score = score(&truth, &tank, points.found(), &params)?;
            let detail = detail(&truth, &tank, points.found(), &params, score.turned_deg)?;
            lines.push(format!("{what}\n{}\n{}", table(&score), detail_table(&detail)));
            let mut judged = serde_json::json!({ "score": score, "detail": detail });
            if let Points::Roots(roots) = &points {
                let traits = trait_errors(&truth, &tank, roots, &params, score.turned_deg)?;
                lines.push(traits_table(&traits));
                judged["traits"] = serde_json::json!(traits);
            }
            all.insert(what.replace(' ', "_"), judged);
            if n == 0
                && let Some(picture) = &self.picture
            {
                let hits = hits(&truth, &tank, points.found(), &params, score.turned_deg)?;
                let png = picture::png(hits_picture(&hits, &tank, PX_PER_MM).view())?;
                fs::write(picture, png).map_err(|e| Error::io("write", picture, e))?;
            }
        }
        let cameras = self.camera_errors(&tank)?;
        if self.json {
            all.insert("cameras".into(), serde_json::json!(cameras));
            dataln!("{:#}", serde_json::Value::Object(all));
            return Ok(());
        }
        lines.extend(cameras.map(|c| cameras_line(&c)));
        dataln!("{}", lines.join("\n\n"));
        Ok(())
    }

    /// Errors of the cameras, where both the result and the truth have a cameras.json, with three cameras or more in both.
    fn camera_errors(&self, tank: &Tank) -> Result<Option<CameraErrors>> {
        let read = |folder: &Path| -> Result<Option<Vec<NamedView>>> {
            let path = folder.join("cameras.json");
            if !path.is_file() {
                return Ok(None);
            }
            cameras_json::parse(&path.display().to_string(), &text(&path)?).map(Some)
        };
        let (Some(truth), Some(found)) = (read(&self.truth)?, read(&self.result)?) else { return Ok(None) };
        let pairs = cameras_json::in_pairs(&truth, &found);
        if pairs.len() < 3 {
            talkln!("cameras: {} of the same file name in both, too few to compare (three fix a frame)", pairs.len());
            return Ok(None);
        }
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
