//! `study.lock`: which work, on which inputs, gave a result; JSON that a person can read.
//!
//! It holds the program's version and, for every node, its name, stage, key and digest, and of a sweep the points; no
//! times and no paths, so that two runs of one study on two machines write the same text.

use super::batch::{Batch, Study};
use crate::error::{Error, Result};
use crate::flow::Report;
use serde::Serialize;
use std::collections::BTreeMap;

#[derive(Serialize)]
struct Lock<'a> {
    rootvox: &'static str,
    study: &'a str,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    points: Vec<LockedPoint<'a>>,
    nodes: Vec<LockedNode>,
}

#[derive(Serialize)]
struct LockedPoint<'a> {
    point: usize,
    values: BTreeMap<&'a str, &'a str>,
}

#[derive(Serialize)]
struct LockedNode {
    node: String,
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
pub fn text(batch: &Batch, study: &Study, report: &Report) -> Result<String> {
    let reached = batch.graph.upstream(&study.targets());
    let nodes = batch.graph.nodes().zip(batch.names()).filter(|(n, _)| reached[n.index()]);
    let nodes = nodes.map(|(n, name)| LockedNode {
        node: name,
        stage: batch.graph.stage(n),
        key: report.key(n).map(|k| k.to_string()),
        digest: report.digest(n).map(|d| d.to_string()),
    });
    let points = study.points.iter().filter(|_| study.is_sweep()).map(|point| LockedPoint {
        point: point.number,
        values: study.parameters.iter().map(String::as_str).zip(point.values.iter().map(String::as_str)).collect(),
    });
    let lock = Lock {
        rootvox: env!("CARGO_PKG_VERSION"),
        study: &study.name,
        points: points.collect(),
        nodes: nodes.collect(),
    };
    serde_json::to_string_pretty(&lock).map(|t| t + "\n").map_err(|e| Error::failed(format!("study.lock: {e}")))
}
