//! How the traits vary over reconstructions from random halves of the photographs.
//! In: traits (of all photographs), draws (traits of each half). Out: trait_spread.csv.

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::tables;
use crate::roots::traits::spread::spread;
use serde::Serialize;

/// The spread.
#[derive(Debug, Clone, Serialize)]
pub struct Spread {}

impl Stage for Spread {
    const NAME: &'static str = "spread";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let all = tables::read_traits(&inputs.one("traits")?.bytes("traits.csv")?)?;
        let draws: Vec<_> = inputs
            .many("draws")
            .iter()
            .map(|draw| tables::read_traits(&draw.bytes("traits.csv")?))
            .collect::<Result<_>>()?;
        if draws.len() < 2 {
            return Err(Error::failed("a spread needs two draws at least"));
        }
        output.bytes("trait_spread.csv", &tables::trait_spread(&spread(&all, &draws))?)
    }
}
