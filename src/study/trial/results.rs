//! The results of a trial as a whole, in the folder `trial` beside those of its captures.
//!
//! Written beside itself and swapped in by rename, as the results of a single study. Captures that failed are in `quality.csv` with
//! their reason, and on the page.

use super::tried::Tried;
use super::{Trial, gather, page, tables};
use crate::error::Result;
use crate::formats::gltf;
use crate::roots::ink;
use crate::study::batch::{Point, Study};
use crate::study::crate_metadata::Made;
use crate::study::folder::Fresh;
use crate::study::lock::Lock;
use crate::study::sweep_results::Swept;
use crate::study::table::Table;
use std::path::Path;

/// Reads the tables and draws the figures.
const ANALYSIS: &str = include_str!("analysis.R");

/// Sides of a root's tube in 3D.
const SIDES: usize = 6;

impl Tried<'_> {
    /// Brings `folder/trial` up to date and tells whether it had to be written.
    ///
    /// # Errors
    /// Where the folder cannot be written; the old results then stay as they were.
    pub fn write(&self, folder: &Path) -> Result<bool> {
        let study = self.together();
        let targets = self.batch.targets();
        let lock = Lock::of_nodes(self.batch, &study, &targets, self.report, &folder.join(Trial::FOLDER))?;
        let Some(fresh) = Fresh::begin(folder, &lock)? else { return Ok(false) };
        if self.is_sweep() {
            fresh.write("sweep.csv", &self.swept()?.csv()?)?;
        } else {
            let all = gather::all(self)?;
            for (name, bytes) in tables::of(self, &all)? {
                fresh.write(name, &bytes)?;
            }
            fresh.write("report.html", page::html(self, &all)?.as_bytes())?;
            fresh.write("analysis.R", ANALYSIS.as_bytes())?;
            self.put_days(&fresh)?;
        }
        fresh.publish(&lock, &Made::of(self.batch, &study, self.report))?;
        Ok(true)
    }

    /// Puts a file of roots per plant and day, in one frame and under common numbers, and one in 3D of all its days.
    fn put_days(&self, fresh: &Fresh) -> Result<()> {
        for days in self.followed() {
            let scene = gltf::write_days(&self.roots_over_days(days)?, SIDES, ink::by_root)?;
            fresh.write(&format!("days/{}.glb", days.plant), &scene)?;
            let followed = self.report.artefact(days.follow)?;
            for (n, &capture) in days.captures.iter().enumerate() {
                let member = format!("day-{}.rsml", n + 1);
                if followed.has(&member) {
                    let name = self.trial.captures[capture].name();
                    fresh.put(self.report, days.follow, &member, &format!("days/{name}.rsml"))?;
                }
            }
        }
        Ok(())
    }

    /// The captures as the points of one study, as its lock has them.
    fn together(&self) -> Study {
        let parameters = self.trial.columns().map(str::to_owned).collect();
        let points =
            self.batch.studies.iter().zip(&self.trial.captures).enumerate().flat_map(|(n, (study, capture))| {
                study.points.iter().map(move |point| Point {
                    number: n + 1,
                    values: capture.values(),
                    planned: point.planned.clone(),
                })
            });
        let points = points.collect();
        Study { name: Trial::FOLDER.to_owned(), parameters, fastest: 1, traits: true, points }
    }

    /// The tables of all captures' sweeps as one.
    fn swept(&self) -> Result<Table> {
        let mut all = Table::default();
        for (study, capture) in self.batch.studies.iter().zip(&self.trial.captures) {
            let table = Swept::new(self.batch, study, self.report, self.failures).table()?;
            for row in &table.rows {
                all.rows.push(Vec::new());
                for (name, value) in self.trial.columns().zip(capture.values()) {
                    all.put(name, value);
                }
                for (column, text) in table.columns.iter().zip(row) {
                    all.put(column, text.clone());
                }
            }
        }
        Ok(all)
    }
}
