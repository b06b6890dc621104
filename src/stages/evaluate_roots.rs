//! Scores the traced roots against the true ones: centrelines, tips and branch points, diameters, traits.
//! In: system, truth (a roots.json file, or a capture). Out: judgement (JSON: score, detail, traits).

use super::evaluate::truth;
use crate::error::Result;
use crate::evaluation::{Detail, Found, Score, ScoreParams, TraitError, detail, score, trait_errors};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::Tank;
use crate::roots::RootSystem;
use serde::{Deserialize, Serialize};

/// The score of traced roots.
#[derive(Debug, Clone, Serialize)]
pub struct EvaluateRoots {
    /// The tank; its wall and water level bound the region.
    pub tank: Tank,
    /// Region and tolerances.
    pub params: ScoreParams,
}

/// What is said of traced roots.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Judgement {
    /// Of the centrelines.
    pub score: Score,
    /// Where they are right.
    pub detail: Detail,
    /// What is measured on them.
    pub traits: Vec<TraitError>,
}

impl Stage for EvaluateRoots {
    const NAME: &'static str = "evaluate-roots";
    const VERSION: u32 = 2;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let truth = truth(inputs.one("truth")?)?;
        let roots = inputs.one("system")?.json::<RootSystem>("system.json")?.plain();
        let score = score(&truth, &self.tank, Found::Roots(&roots), &self.params)?;
        let turn = score.turned_deg;
        let detail = detail(&truth, &self.tank, Found::Roots(&roots), &self.params, turn)?;
        let traits = trait_errors(&truth, &self.tank, &roots, &self.params, turn)?;
        output.json("judgement", &Judgement { score, detail, traits })
    }
}
