//! Follows a plant's roots over days.
//! In: systems (of each day, in order), alignments (of each day after the first, where belts were looked at). Out: growth.json,
//! alignments (JSON, of each day after the first), days.json (the roots of each day in the first day's frame, under their common numbers),
//! growth.csv, day-N.rsml.

use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{growth_csv, rsml};
use crate::growth::align::Alignment;
use crate::growth::by_roots;
use crate::growth::follow::{FollowParams, Growth, emerged, follow};
use crate::growth::motion::Motion;
use crate::growth::recall::Recalled;
use crate::roots::{RootSystem, TracedRoot};
use crate::store::Artefact;
use serde::Serialize;

/// The days of one plant.
#[derive(Debug, Clone, Serialize)]
pub struct Follow {
    /// The times of the days, in days, rising.
    pub days: Vec<f64>,
    /// How roots are followed.
    #[serde(flatten)]
    pub params: FollowParams,
}

impl Stage for Follow {
    const NAME: &'static str = "follow";
    const VERSION: u32 = 3;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let systems: Vec<RootSystem> =
            inputs.many("systems").iter().map(|s| s.json("system.json")).collect::<Result<_>>()?;
        let (Some(first), true) = (systems.first(), systems.len() == self.days.len()) else {
            return Err(Error::failed("there is not a root system for each day"));
        };
        let by_belts: Vec<Option<Alignment>> =
            inputs.many("alignments").iter().map(|a| a.json("alignment")).collect::<Result<_>>()?;
        let mut alignments = Vec::new();
        for (n, system) in systems.iter().enumerate().skip(1) {
            let alignment = match by_belts.get(n - 1).cloned().flatten() {
                Some(found) => found,
                None => by_roots::align(&first.plain(), &system.plain()).ok_or_else(|| {
                    Error::failed(format!("neither belts nor roots tell how day {} stands to the first", n + 1))
                        .help("print the belts (`rootvox belt`), or leave the day out")
                })?,
            };
            if !alignment.by_belts {
                output.warn(format!(
                    "day {} stands where its roots fit those of the first day best, not by printed belts: azimuth ± {:.2}°, places ± {:.2} mm, \
                     {:.0} % of the roots fit",
                    n + 1,
                    alignment.azimuth_sd_deg,
                    alignment.place_sd_mm,
                    100.0 * alignment.agreement
                ));
            }
            alignments.push(alignment);
        }
        let moved = |(n, system): (usize, &RootSystem)| {
            let motion = n.checked_sub(1).map_or_else(Motion::identity, |k| alignments[k].motion);
            let one = |r: &TracedRoot| TracedRoot { root: motion.root(&r.root), ..r.clone() };
            (self.days[n], system.roots.iter().map(one).collect::<Vec<_>>())
        };
        let mut days: Vec<(f64, Vec<TracedRoot>)> = systems.iter().enumerate().map(moved).collect();
        let growth = follow(&mut days, &self.params);
        let named: Vec<Vec<TracedRoot>> = days.iter().enumerate().map(|(n, (_, roots))| growth.day(n, roots)).collect();
        let followed = Followed { growth, days: named, alignments };
        followed.write(output, &self.days, &[])
    }
}

/// What is known of a plant over days.
pub(super) struct Followed {
    pub growth: Growth,
    /// The roots of each day in the frame of the first, under their common numbers.
    pub days: Vec<Vec<TracedRoot>>,
    /// Of each day after the first.
    pub alignments: Vec<Alignment>,
}

impl Followed {
    pub fn read(artefact: &Artefact) -> Result<Self> {
        Ok(Self {
            growth: artefact.json("growth.json")?,
            days: artefact.json("days.json")?,
            alignments: artefact.json("alignments")?,
        })
    }

    /// From a day's frame to that of the first.
    pub fn first_from_day(&self, day: usize) -> Motion {
        day.checked_sub(1).and_then(|k| self.alignments.get(k)).map_or_else(Motion::identity, |a| a.motion)
    }

    /// Writes it, at these times in days; `recalled` are roots that were found with another day's help.
    pub fn write(&self, output: &mut Output, times: &[f64], recalled: &[Recalled]) -> Result<()> {
        let since: Vec<f64> = times.iter().map(|time| time - times[0]).collect();
        for (n, roots) in self.days.iter().enumerate().filter(|(_, roots)| !roots.is_empty()) {
            let about = rsml::About {
                last_modified: rsml::PROFILE_DATE.to_owned(),
                software: concat!("rootvox ", env!("CARGO_PKG_VERSION")).to_owned(),
                user: "rootvox".to_owned(),
                file_key: format!("day-{}", n + 1),
                image: None,
                sequence: Some(rsml::Sequence {
                    label: "days".to_owned(),
                    index: n,
                    created_days: emerged(&self.days, &since, n),
                }),
            };
            output.bytes(&format!("day-{}.rsml", n + 1), rsml::write(roots, &about)?.as_bytes())?;
        }
        output.bytes("growth.csv", &growth_csv::write(&self.growth, times, recalled)?)?;
        output.json("alignments", &self.alignments)?;
        output.json("days.json", &self.days)?;
        output.json("growth.json", &self.growth)
    }
}
