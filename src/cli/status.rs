//! `rootvox status`: what a run would do, and why.

use super::options::{StoreOptions, StudyOptions, human_bytes};
use crate::error::{Error, Result};
use crate::flow::{Engine, NodeState, Planned};
use crate::store::Store;
use crate::study::batch::Batch;
use clap::Args;
use std::fmt::Write;

/// Show each node of a study: cached, or would run, and why; with times and sizes known from earlier runs.
///
/// Nothing is computed and nothing is written.
#[derive(Args)]
pub struct Status {
    #[command(flatten)]
    study: StudyOptions,
    #[command(flatten)]
    store: StoreOptions,
    /// Write JSON, one object per node, instead of a table.
    #[arg(long)]
    json: bool,
    /// List cached nodes too.
    #[arg(long)]
    all: bool,
}

impl Status {
    /// Prints the plan.
    ///
    /// # Errors
    /// Faults of the study file or an unreadable store.
    #[expect(clippy::print_stdout, reason = "the plan is the data")]
    pub fn run(&self) -> Result<()> {
        let batch = Batch::load(&self.study.study, &self.study.set)?;
        let store = Store::open(&self.store.cache)?;
        let plan = Engine::new(&store).status(&batch.graph, &batch.targets())?;
        if self.json {
            let all: Vec<&Planned> = plan.nodes().map(|(_, p)| p).collect();
            let text = serde_json::to_string_pretty(&all).map_err(|e| Error::failed(format!("status: {e}")))?;
            println!("{text}");
            return Ok(());
        }
        let mut text = String::new();
        let (mut cached, mut pending, mut seconds, mut unknown) = (0, 0, 0.0, 0);
        let names = batch.names();
        for (node, planned) in plan.nodes() {
            let waits = matches!(planned.state, NodeState::WouldRun { .. } | NodeState::Unknown { .. });
            if waits {
                pending += 1;
                seconds += planned.seconds.unwrap_or(0.0);
                unknown += usize::from(planned.seconds.is_none());
            } else if matches!(planned.state, NodeState::Cached { .. }) {
                cached += 1;
            }
            if self.all || waits || matches!(planned.state, NodeState::Unreadable { .. }) {
                let _ = writeln!(text, "{}", line(&names[node.index()], planned));
            }
        }
        print!("{text}");
        println!("{cached} nodes cached, {pending} would run or may");
        if pending > unknown {
            let rest = if unknown > 0 { format!(" and {unknown} nodes without history") } else { String::new() };
            println!("estimated: {seconds:.1} s of work{rest}");
        }
        Ok(())
    }
}

fn line(name: &str, planned: &Planned) -> String {
    let (state, why) = match &planned.state {
        NodeState::File { .. } => ("file", String::new()),
        NodeState::Unreadable { error } => ("unreadable", error.clone()),
        NodeState::Cached { is_virtual: true, .. } => ("cached", "streamed when read".into()),
        NodeState::Cached { .. } => ("cached", String::new()),
        NodeState::WouldRun { changes, .. } => ("would run", super::why::sentence(changes)),
        NodeState::Unknown { changes } => ("may run", super::why::sentence(changes)),
    };
    let cost = match (planned.seconds, planned.bytes) {
        (Some(s), Some(b)) => format!("  ({s:.2} s, {})", human_bytes(b)),
        _ => String::new(),
    };
    format!("{name:24} {state:10} {why}{cost}")
}
