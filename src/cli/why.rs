//! `rootvox why`: what changed at a node against the nearest earlier run.

use super::options::{StoreOptions, StudyOptions};
use crate::error::Result;
use crate::flow::{Change, Engine};
use crate::store::Store;
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
    /// Label of the node, as `rootvox status --all` shows it.
    node: String,
    #[command(flatten)]
    store: StoreOptions,
}

impl Why {
    /// Prints one line per node on the way from the cause.
    ///
    /// # Errors
    /// Faults of the study file, an unknown node, or an unreadable store.
    #[expect(clippy::print_stdout, reason = "the explanation is the data")]
    pub fn run(&self) -> Result<()> {
        let batch = Batch::load(&self.study.study, &self.study.set)?;
        let store = Store::open(&self.store.cache)?;
        let node = batch.find(&self.node).map_err(|e| e.help("`rootvox status STUDY --all` lists the nodes"))?;
        for step in Engine::new(&store).why(&batch.graph, node)? {
            let against = step.against.map(|when| format!("  (against the run of {when})")).unwrap_or_default();
            let changes = if step.changes.is_empty() { "nothing changed".into() } else { sentence(&step.changes) };
            println!("{}: {changes}{against}", step.label);
        }
        Ok(())
    }
}

/// Changes in words.
pub fn sentence(changes: &[Change]) -> String {
    const SHOWN: usize = 3;
    let mut words: Vec<String> = changes.iter().take(SHOWN).map(ToString::to_string).collect();
    if changes.len() > SHOWN {
        words.push(format!("{} more changes", changes.len() - SHOWN));
    }
    words.join("; ")
}
