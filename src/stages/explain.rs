//! Judges the candidates for roots by what they account for in the photographs.
//! In: pieces, evidence (undistorted) and cameras, each in the same order. Out: explained.json (stretches kept and left).

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View, ViewMap};
use crate::photo::Picture;
use crate::photo::evidence::px_per_mm;
use crate::roots::Pieces;
use crate::roots::explain::{ExplainParams, Witness, explain};
use crate::store::Artefact;
use rayon::prelude::*;
use serde::Serialize;

/// Point spread of a photograph in focus, px: the pixel's own square, interpolated colours and a good lens.
const SPREAD_PX: f64 = 0.45;

/// The judgement with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Explain {
    /// The tank between roots and cameras.
    pub tank: Tank,
    /// Deviation of the evidence's smoothing, mm at the tank's axis.
    pub blur_mm: f64,
    /// How roots are judged.
    #[serde(flatten)]
    pub params: ExplainParams,
}

impl Stage for Explain {
    const NAME: &'static str = "explain";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        // All photographs' evidence, and their looks at every bead.
        2 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let pieces: Pieces = inputs.one("pieces")?.json("pieces.json")?;
        progress.total(2);
        let seen = seen(inputs, &self.tank, self.blur_mm)?;
        progress.advance(1);
        progress.check()?;
        output.json("explained.json", &explain(&pieces.pieces, &witnesses(&seen), &self.params)?)?;
        progress.advance(1);
        Ok(())
    }
}

/// A photograph's way of seeing, its evidence, and the evidence's point spread, px.
pub(super) type Seen = (ViewMap, Picture, f64);

/// The photographs of the ports evidence and cameras.
pub(super) fn seen(inputs: &Inputs, tank: &Tank, blur_mm: f64) -> Result<Vec<Seen>> {
    let (evidence, cameras) = (inputs.many("evidence"), inputs.many("cameras"));
    if evidence.len() != cameras.len() {
        return Err(Error::failed(format!("evidence of {} photographs for {} cameras", evidence.len(), cameras.len())));
    }
    let one = |(evidence, camera): (&Artefact, &Artefact)| {
        let view = camera.json::<View>("view")?.ideal();
        let spread_px = SPREAD_PX.hypot(blur_mm * px_per_mm(&view));
        Ok((ViewMap::new(&view, tank)?, super::read3(evidence, "photo")?, spread_px))
    };
    evidence.par_iter().zip(cameras).map(one).collect()
}

/// The photographs as witnesses.
pub(super) fn witnesses(seen: &[Seen]) -> Vec<Witness<'_>> {
    seen.iter()
        .map(|(map, evidence, spread_px)| Witness { map, evidence: evidence.view(), spread_px: *spread_px })
        .collect()
}
