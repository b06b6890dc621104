//! Scores the extracted root voxels against the true roots.
//! In: roots, truth (a roots.json file, or a capture). Out: score (JSON), bands (JSON: near wall,
//! water surface, floor and belts).

use super::extract;
use crate::error::{Error, Result};
use crate::evaluation::{Found, ScoreParams, bands, score};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::roots_json;
use crate::optics::Tank;
use crate::roots::Root;
use crate::store::Artefact;
use serde::Serialize;

/// The score of a reconstruction.
#[derive(Debug, Clone, Serialize)]
pub struct Evaluate {
    /// The tank; its wall and water level bound the region.
    pub tank: Tank,
    /// Region and tolerances.
    pub params: ScoreParams,
}

impl Stage for Evaluate {
    const NAME: &'static str = "evaluate";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let roots = truth(inputs.one("truth")?)?;
        let points: Vec<[f64; 3]> =
            extract::read(inputs.one("roots")?)?.iter().map(|p| p.point_mm.map(f64::from)).collect();
        let score = score(&roots, &self.tank, Found::Points(&points), &self.params)?;
        output.json("bands", &bands(&roots, &self.tank, &points, self.params.z_max_mm, score.turned_deg))?;
        output.json("score", &score)
    }
}

/// The true roots, of a capture or of a file.
///
/// # Errors
/// Where the file is no `roots.json`.
pub(super) fn truth(truth: &Artefact) -> Result<Vec<Root>> {
    if truth.has("roots") {
        return truth.json("roots");
    }
    let name = truth.path("file")?.display().to_string();
    let text = String::from_utf8(truth.bytes("file")?)
        .map_err(|_| Error::failed(format!("`{name}` is no text")).help("truth.roots names a roots.json"))?;
    roots_json::parse(&name, &text)
}
