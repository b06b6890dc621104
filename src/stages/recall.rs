//! Looks on one day for the roots that only other days of the plant show.
//! In: followed, evidence (undistorted) and cameras of the day, each in the same order. Out: recalled.json (roots in the frame of the first
//! day under their common numbers, with the evidence).

use super::explain::{Seen, seen, witnesses};
use super::follow::Followed;
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::growth::recall::{RecallParams, Recalled, recall, wanted};
use crate::optics::Tank;
use crate::roots::TracedRoot;
use serde::Serialize;

/// The search on one day.
#[derive(Debug, Clone, Serialize)]
pub struct Recall {
    /// Place of the day among those of the plant.
    pub day: usize,
    /// The tank on that day.
    pub tank: Tank,
    /// Deviation of the evidence's smoothing, mm at the tank's axis.
    pub blur_mm: f64,
    /// How it is decided.
    #[serde(flatten)]
    pub params: RecallParams,
}

impl Stage for Recall {
    const NAME: &'static str = "recall";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        // All photographs' evidence.
        1 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let followed = Followed::read(inputs.one("followed")?)?;
        let first_from_day = followed.first_from_day(self.day);
        let wanted = wanted(&followed.growth, &followed.days, self.day, &first_from_day);
        progress.total(2);
        let mut recalled: Vec<Recalled> = Vec::new();
        if !wanted.is_empty() {
            let seen: Vec<Seen> = seen(inputs, &self.tank, self.blur_mm)?;
            progress.advance(1);
            progress.check()?;
            let day_from_first = first_from_day.inverse();
            let own = |r: &TracedRoot| TracedRoot { root: day_from_first.root(&r.root), ..r.clone() };
            let known: Vec<TracedRoot> = followed.days[self.day].iter().map(own).collect();
            recalled = recall(self.day, &known, wanted, &witnesses(&seen), &self.tank, &self.params);
        }
        for one in &mut recalled {
            one.root.root = first_from_day.root(&one.root.root);
        }
        output.json("recalled.json", &recalled)
    }
}
