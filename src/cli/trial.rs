//! What `run` and `status` do with the captures of a trial.

use super::options::StudyOptions;
use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::flow::{Engine, NodeId, NodeState, Plan, Report};
use crate::store::Store;
use crate::study::batch::Batch;
use crate::study::plants::Only;
use crate::study::sweep_results::Swept;
use crate::study::trial::Trial;
use crate::study::trial::tried::Tried;
use crate::study::{command, results};
use clap::Args;
use std::path::Path;

/// Which captures of a trial.
#[derive(Args)]
pub struct TrialOptions {
    /// Of a trial, only captures with that value in a column of its list, such as plant=7; as often as needed.
    #[arg(long, value_name = "COLUMN=VALUE")]
    only: Vec<String>,
    /// Of a trial, only captures that something is to be computed for.
    #[arg(long)]
    pub stale: bool,
}

impl TrialOptions {
    /// Reads the study, of a trial the captures that are wanted.
    ///
    /// # Errors
    /// Faults of the study file and of the list of captures, all at once.
    pub fn load(&self, study: &StudyOptions) -> Result<Batch> {
        let only: Vec<Only> = self.only.iter().map(|text| Only::read(text)).collect::<Result<_>>()?;
        let batch = Batch::load_only(&study.study, &study.set, &only)?;
        if self.stale && batch.trial.is_none() {
            return Err(Error::usage(format!("--stale: `{}` is no trial", study.study.display()))
                .help("a trial has a [plants] section that lists its captures"));
        }
        Ok(batch)
    }

    /// Per study, whether its results are wanted.
    ///
    /// # Errors
    /// Where the store cannot be read.
    pub fn wanted(&self, batch: &Batch, store: &Store) -> Result<Vec<bool>> {
        match self.stale {
            true => Ok(stale(batch, &Engine::new(store).status(&batch.graph, &batch.targets())?)),
            false => Ok(vec![true; batch.studies.len()]),
        }
    }
}

/// Per study, whether something is to be computed for it.
pub fn stale(batch: &Batch, plan: &Plan) -> Vec<bool> {
    let mut cached = vec![true; batch.graph.nodes().count()];
    for (node, planned) in plan.nodes() {
        cached[node.index()] = matches!(planned.state, NodeState::Cached { .. } | NodeState::File { .. });
    }
    let mut walk = batch.graph.walk();
    let is_stale = |targets: Vec<NodeId>| walk.upstream(&targets).iter().any(|node| !cached[node.index()]);
    batch.studies.iter().map(|study| study.targets()).map(is_stale).collect()
}

/// Writes the results of a trial's captures, and those of the trial where the run was of all; hands back what failed.
///
/// # Errors
/// Where results cannot be written.
pub fn write(
    to: &Path,
    (batch, trial): (&Batch, &Trial),
    wanted: &[bool],
    (report, failures): (&Report, &[(NodeId, Error)]),
    study: &StudyOptions,
) -> Result<Vec<Error>> {
    let folder = to.join(&trial.name);
    let tried = Tried::new(batch, trial, report, failures);
    let (mut written, mut swept_faults) = (0, Vec::new());
    for ((one, fault), _) in batch.studies.iter().zip(&tried.failed).zip(wanted).filter(|(_, wanted)| **wanted) {
        if one.is_sweep() {
            let swept = Swept::new(batch, one, report, failures);
            let title = |fault: Error| fault.at(tried.title(one));
            swept_faults.extend(swept.failures().into_iter().map(title));
            written += usize::from(swept.write(&folder)?);
        } else if fault.is_none() {
            let made_by = command::run(&study.study, &study.set);
            written += usize::from(results::write(&folder, batch, one, report, &made_by)?);
        }
    }
    let (failed, unfollowed) = (tried.failures(), tried.unfollowed());
    let count = batch.studies.len();
    talkln!(
        "{}: {count} capture{}, {} failed; results of {written} written: {}",
        trial.name,
        if count == 1 { "" } else { "s" },
        failed.len(),
        folder.display()
    );
    if trial.is_whole {
        let state = if tried.write(&folder)? { "written" } else { "unchanged" };
        let page = if tried.is_sweep() { "sweep.csv" } else { "report.html" };
        talkln!("results of the trial {state}; look at: {}", folder.join(Trial::FOLDER).join(page).display());
    } else {
        talkln!("results of the trial are left as they are: run without --only for those");
    }
    Ok(failed.into_iter().chain(unfollowed).chain(swept_faults).collect())
}
