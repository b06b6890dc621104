//! Measures the roots' diameters in the photographs as taken, and moves the centrelines to where they show the roots.
//! In: pieces, photos (files) and cameras, each in the same order, background (gray tells roots where there is
//! none). Out: pieces.json.

use super::photographs::decoded;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::{Tank, View, ViewMap};
use crate::photo::colour::GRAY;
use crate::roots::Pieces;
use crate::roots::diameter::sight::Sight;
use crate::roots::diameter::{DiameterParams, Measurement, measure};
use rayon::prelude::*;
use serde::Serialize;

/// The measurement with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Diameters {
    /// The tank between roots and cameras.
    pub tank: Tank,
    /// How diameters are measured.
    #[serde(flatten)]
    pub params: DiameterParams,
}

impl Stage for Diameters {
    const NAME: &'static str = "diameters";
    const VERSION: u32 = 11;

    fn peak_bytes(&self) -> u64 {
        // All photographs in linear light, and which roots cover which pixels.
        2 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let mut pieces: Pieces = inputs.one("pieces")?.json("pieces.json")?;
        let (photos, cameras) = (inputs.many("photos"), inputs.many("cameras"));
        if photos.len() != cameras.len() {
            return Err(Error::failed(format!("{} photographs for {} cameras", photos.len(), cameras.len())));
        }
        let axis = match inputs.many("background") {
            [background, ..] => super::background::room(background)?.weights,
            [] => GRAY.map(f64::from),
        };
        progress.total(2);
        let maps: Vec<ViewMap> = cameras
            .iter()
            .map(|camera| ViewMap::new(&camera.json::<View>("view")?, &self.tank))
            .collect::<Result<_>>()?;
        let sights: Vec<Sight<'_>> = photos
            .par_iter()
            .zip(&maps)
            .map(|(file, map)| Ok(Sight::new(map, &decoded(file)?, axis)))
            .collect::<Result<_>>()?;
        progress.advance(1);
        progress.check()?;
        // What the photographs need hides what is behind it; of the others the weak ones do not.
        let strengths = if pieces.explained { vec![1.0; pieces.pieces.len()] } else { pieces.strengths.clone() };
        let Measurement { looks, spread_px } = measure(&mut pieces.pieces, &strengths, &sights, &self.params)?;
        (pieces.looks, pieces.spread_px) = (looks, Some(spread_px));
        progress.advance(1);
        output.json("pieces.json", &pieces)
    }
}
