//! `rootvox why`: what changed at a node against the nearest earlier run.

use super::explain::{Line, causes_first, folded};
use super::options::{StoreOptions, StudyOptions};
use super::terminal::dataln;
use crate::error::{Error, Result};
use crate::flow::{Engine, NodeState, Step};
use crate::study::batch::Batch;
use clap::Args;

/// Explain why a node would run, or would have: root cause first, old value -> new value.
///
/// Example:
///   rootvox why pipelines/quickstart.toml extract --set extract.high=1.5
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Why {
    #[command(flatten)]
    study: StudyOptions,
    /// Name of the node, as `rootvox status --all` shows it.
    node: String,
    #[command(flatten)]
    store: StoreOptions,
    /// Write JSON, one object per node on the way.
    #[arg(long)]
    json: bool,
}

impl Why {
    /// Prints the way from the causes to the node.
    ///
    /// # Errors
    /// Faults of the study file, an unknown node, or an unreadable store.
    pub fn run(&self) -> Result<()> {
        let batch = Batch::load(&self.study.study, &self.study.set)?;
        let store = self.store.look()?;
        let node = batch.find(&self.node).map_err(|e| e.help("`rootvox status STUDY --all` lists the nodes"))?;
        let engine = Engine::new(&store);
        let steps = engine.why(&batch.graph, node)?;
        if self.json {
            let text = serde_json::to_string_pretty(&steps).map_err(|e| Error::failed(format!("why: {e}")))?;
            dataln!("{text}");
            return Ok(());
        }
        let plan = engine.status(&batch.graph, &[node])?;
        if plan.node(node).is_some_and(|planned| matches!(planned.state, NodeState::Cached { .. })) {
            dataln!("`{}` is in the store. Against the nearest other run:", self.node);
        }
        let mut lines: Vec<Line> = steps.iter().map(line).collect();
        let asked = lines.pop();
        for line in causes_first(folded(lines)).into_iter().chain(asked) {
            let why = if line.why.is_empty() { "nothing changed" } else { &line.why };
            dataln!("{}: {why}", line.name);
        }
        Ok(())
    }
}

fn line(step: &Step) -> Line {
    let mut line = Line::new(&step.label, "", &step.changes, None);
    // The second is enough for a person.
    if let Some(when) = step.against.as_ref().and_then(|when| when.get(..19)) {
        line.why += &format!("  (against the run of {when}Z)");
    }
    line
}
