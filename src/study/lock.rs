//! `study.lock`: which work, on which inputs, gave a result; JSON that a person can read.
//!
//! It holds the program's version and, for every node, its label, stage, key and digest; no times and no
//! paths, so that two runs of one study on two machines write the same text.

use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::{Graph, Report};
use serde::Serialize;

#[derive(Serialize)]
struct Lock<'a> {
    rootvox: &'static str,
    study: &'a str,
    nodes: Vec<LockedNode<'a>>,
}

#[derive(Serialize)]
struct LockedNode<'a> {
    node: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    stage: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    key: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    digest: Option<String>,
}

/// The text of the lock file.
///
/// # Errors
/// Where it cannot be written as JSON.
pub fn text(settings: &Settings, graph: &Graph, report: &Report) -> Result<String> {
    let nodes = graph
        .nodes()
        .map(|n| LockedNode {
            node: graph.label(n),
            stage: graph.stage(n),
            key: report.key(n).map(|k| k.to_string()),
            digest: report.digest(n).map(|d| d.to_string()),
        })
        .collect();
    let lock = Lock { rootvox: env!("CARGO_PKG_VERSION"), study: &settings.name, nodes };
    serde_json::to_string_pretty(&lock).map(|t| t + "\n").map_err(|e| Error::failed(format!("study.lock: {e}")))
}
