//! A plant's roots over days with those that were found with another day's help.
//! In: followed, recalled (of each day). Out: as of `follow`, and recalled.csv.

use super::follow::Followed;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::recalled_csv;
use crate::growth::follow::FollowParams;
use crate::growth::recall::{self, joined};
use serde::Serialize;

/// The days of one plant.
#[derive(Debug, Clone, Serialize)]
pub struct Recalled {
    /// The times of the days, in days, rising.
    pub days: Vec<f64>,
    /// How roots are followed.
    #[serde(flatten)]
    pub params: FollowParams,
}

impl Stage for Recalled {
    const NAME: &'static str = "recalled";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let Followed { growth, days, alignments } = Followed::read(inputs.one("followed")?)?;
        let mut recalled: Vec<recall::Recalled> = Vec::new();
        for of_day in inputs.many("recalled") {
            recalled.extend(of_day.json::<Vec<recall::Recalled>>("recalled.json")?);
        }
        let mut timed = self.days.iter().copied().zip(days).collect::<Vec<_>>();
        let growth = joined(growth, &mut timed, &recalled, &self.params);
        let days = timed.into_iter().map(|(_, roots)| roots).collect();
        output.bytes("recalled.csv", &recalled_csv::write(&recalled, &self.days)?)?;
        Followed { growth, days, alignments }.write(output, &self.days, &recalled)
    }
}
