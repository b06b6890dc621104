//! `rootvox status`: what a run would do, and why.

use super::explain::{Line, causes_first, folded};
use super::options::{StoreOptions, StudyOptions, human_bytes};
use super::terminal::{data, dataln};
use super::trial::{TrialOptions, stale};
use crate::error::{Error, Result};
use crate::flow::{Engine, NodeState, Planned};
use crate::study::batch::{Batch, Study};
use clap::Args;
use std::fmt::Write;

/// Show each node of a study: cached, or would run, and why; with times and sizes known from earlier runs.
///
/// Nothing is computed. Causes come first, then what follows from them: "may run" is a node that is computed again only
/// if what it reads turns out to have other values. Views that are alike share a line; --all lists each node. Points of
/// a sweep whose settings are at fault come as errors, as a run reports them. Of a trial, --stale lists the captures that a
/// run would compute something for.
#[derive(Args)]
pub struct Status {
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    captures: TrialOptions,
    #[command(flatten)]
    store: StoreOptions,
    /// Write JSON, one object per node, instead of a table.
    #[arg(long)]
    json: bool,
    /// List every node on a line of its own, files and cached ones too.
    #[arg(long)]
    all: bool,
}

impl Status {
    /// Prints the plan.
    ///
    /// # Errors
    /// Faults of the study file, of single points after the plan of the others, or an unreadable store.
    pub fn run(&self) -> Result<()> {
        let batch = self.captures.load(&self.study)?;
        let store = self.store.look()?;
        let plan = Engine::new(&store).status(&batch.graph, &batch.targets())?;
        if let (true, Some(trial)) = (self.captures.stale, &batch.trial) {
            let stale = stale(&batch, &plan);
            trial.captures.iter().zip(stale).filter(|(_, stale)| *stale).for_each(|(c, _)| dataln!("{}", c.name()));
            return unsound(&batch);
        }
        if self.json {
            let all: Vec<&Planned> = plan.nodes().map(|(_, p)| p).collect();
            let text = serde_json::to_string_pretty(&all).map_err(|e| Error::failed(format!("status: {e}")))?;
            dataln!("{text}");
            return unsound(&batch);
        }
        let names = batch.names();
        let (mut lines, mut cached) = (Vec::new(), 0);
        for (node, planned) in plan.nodes() {
            let is_cached = matches!(planned.state, NodeState::Cached { .. });
            cached += usize::from(is_cached);
            if self.all || !(is_cached || matches!(planned.state, NodeState::File { .. })) {
                lines.push(line(&names[node.index()], planned));
            }
        }
        let lines = if self.all { lines } else { causes_first(folded(lines)) };
        let mut text = String::new();
        for Line { name, state, why, cost, .. } in lines {
            let cost = cost.map(|(s, b)| format!("  ({s:.2} s, {})", human_bytes(b))).unwrap_or_default();
            let _ = writeln!(text, "{name:24} {state:10} {why}{cost}");
        }
        let pending: Vec<&Planned> = plan.pending().map(|(_, planned)| planned).collect();
        let _ = writeln!(text, "{cached} nodes cached, {} would run or may", pending.len());
        let unknown = pending.iter().filter(|p| p.seconds.is_none()).count();
        if pending.len() > unknown {
            let seconds: f64 = pending.iter().filter_map(|p| p.seconds).sum();
            let bytes = human_bytes(pending.iter().filter_map(|p| p.bytes).sum());
            let rest = if unknown > 0 { format!(" and {unknown} nodes without history") } else { String::new() };
            let _ = writeln!(text, "estimated: {seconds:.1} s of work, {bytes}{rest}");
        }
        data!("{text}");
        unsound(&batch)
    }
}

/// The points of sweeps that a run would refuse.
fn unsound(batch: &Batch) -> Result<()> {
    Error::many(batch.studies.iter().flat_map(Study::faults).collect())
}

fn line(name: &str, planned: &Planned) -> Line {
    let cost = planned.seconds.zip(planned.bytes);
    match &planned.state {
        NodeState::File { .. } => Line::plain(name, "file", ""),
        NodeState::Unreadable { error } => Line::plain(name, "unreadable", error),
        NodeState::Cached { is_virtual: true, .. } => Line::plain(name, "cached", "without its values"),
        NodeState::Cached { .. } => Line::plain(name, "cached", ""),
        NodeState::WouldRun { changes, .. } => Line::new(name, "would run", changes, cost),
        NodeState::Unknown { changes } => Line::new(name, "may run", changes, cost),
    }
}
