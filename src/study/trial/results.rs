//! The results of a trial as a whole, in the folder `trial` beside those of its captures.
//!
//! Written beside itself and swapped in by rename, as the results of a single study. Captures that failed are in `quality.csv` with
//! their reason, and on the page.

use super::{Days, Trial, gather, page, tables};
use crate::error::{Error, Result};
use crate::flow::{NodeId, Report};
use crate::formats::gltf;
use crate::roots::{Root, TracedRoot, ink};
use crate::study::batch::{Batch, Point, Study};
use crate::study::crate_metadata::Made;
use crate::study::folder::Fresh;
use crate::study::lock::Lock;
use crate::study::sweep_results::Swept;
use crate::study::table::Table;
use std::collections::BTreeMap;
use std::path::Path;

/// Reads the tables and draws the figures.
const ANALYSIS: &str = include_str!("analysis.R");

/// Sides of a root's tube in 3D.
const SIDES: usize = 6;

/// A trial that was run.
pub struct Tried<'a> {
    pub(super) batch: &'a Batch,
    pub(super) trial: &'a Trial,
    pub(super) report: &'a Report,
    failures: &'a [(NodeId, Error)],
    /// With each capture, why it failed.
    pub failed: Vec<Option<Error>>,
    /// With each plant of several days, why its roots could not be followed.
    unfollowed: Vec<Option<Error>>,
}

impl<'a> Tried<'a> {
    /// What a run made of the trial; `failures` are those of all nodes.
    pub fn new(batch: &'a Batch, trial: &'a Trial, report: &'a Report, failures: &'a [(NodeId, Error)]) -> Self {
        let faults: BTreeMap<NodeId, &Error> = failures.iter().rev().map(|(node, error)| (*node, error)).collect();
        let mut walk = batch.graph.walk();
        let mut fault = |targets: Vec<NodeId>| {
            let reached = if faults.is_empty() { Vec::new() } else { walk.upstream(&targets) };
            let first = reached.iter().filter_map(|node| faults.get_key_value(node)).min_by_key(|(node, _)| **node);
            first.map(|(_, error)| (*error).clone())
        };
        // The points of a sweep fail one by one.
        let failed = batch.studies.iter().map(|s| if s.is_sweep() { None } else { fault(s.targets()) }).collect();
        let unfollowed = trial.days.iter().map(|days| fault(vec![days.follow])).collect();
        Self { batch, trial, report, failures, failed, unfollowed }
    }

    /// Whether the captures are swept.
    pub fn is_sweep(&self) -> bool {
        self.batch.studies.iter().any(Study::is_sweep)
    }

    /// The capture of a study, for people.
    pub fn title(&self, study: &Study) -> String {
        let at = self.batch.studies.iter().position(|s| std::ptr::eq(s, study));
        at.and_then(|at| self.trial.captures.get(at)).map_or_else(|| study.name.clone(), |c| c.title())
    }

    /// The failures, each naming its capture.
    pub fn failures(&self) -> Vec<Error> {
        let captures = self.trial.captures.iter().zip(&self.failed);
        captures.filter_map(|(capture, fault)| Some(fault.clone()?.at(capture.title()))).collect()
    }

    /// Plants whose captures went through and whose roots still could not be followed, each named.
    pub fn unfollowed(&self) -> Vec<Error> {
        let is_sound = |days: &Days| !days.captures.iter().any(|n| self.failed[*n].is_some());
        let days = self.trial.days.iter().zip(&self.unfollowed).filter(|(days, _)| is_sound(days));
        days.filter_map(|(days, fault)| Some(fault.clone()?.at(format!("plant {}", days.plant)))).collect()
    }

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

    /// The plants whose roots were followed.
    pub(super) fn followed(&self) -> impl Iterator<Item = &'a Days> + '_ {
        self.trial.days.iter().zip(&self.unfollowed).filter(|(_, fault)| fault.is_none()).map(|(days, _)| days)
    }

    /// Of each day of a plant the days since its first, and the roots in one frame under common numbers.
    ///
    /// # Errors
    /// Where the result cannot be read.
    pub(super) fn roots_over_days(&self, days: &Days) -> Result<Vec<(f64, Vec<Root>)>> {
        let roots: Vec<Vec<TracedRoot>> = self.report.artefact(days.follow)?.json("days.json")?;
        let time = |n: usize| self.trial.captures[days.captures[n]].date.as_ref().map_or(0.0, |d| d.days);
        let plain = |of: Vec<TracedRoot>| of.into_iter().map(|traced| traced.root).collect();
        Ok(roots.into_iter().enumerate().map(|(n, of)| (time(n) - time(0), plain(of))).collect())
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
