//! A trial that was run: which captures went through, and the roots that were followed.

use super::{Days, Trial};
use crate::error::{Error, Result};
use crate::flow::{NodeId, Report};
use crate::roots::{Root, TracedRoot};
use crate::study::batch::{Batch, Study};
use std::collections::BTreeMap;

/// A trial that was run.
pub struct Tried<'a> {
    pub(super) batch: &'a Batch,
    pub(super) trial: &'a Trial,
    pub(super) report: &'a Report,
    pub(super) failures: &'a [(NodeId, Error)],
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
}
