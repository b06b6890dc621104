//! `--trace FILE`: a run as a Chrome trace, to see where time goes.
//!
//! Opens in `chrome://tracing` and <https://ui.perfetto.dev>. One row per node that runs at the same time; found nodes are
//! marks; `left` is the estimate of the time left, in seconds.

use crate::error::{Error, Result};
use crate::flow::{Event, NodeId};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Collects the events of a run.
pub struct Trace {
    path: PathBuf,
    names: Vec<String>,
    begun: Instant,
    events: Vec<Value>,
    /// The rows; a row is free or shows a node since an instant.
    rows: Vec<Option<NodeId>>,
    running: BTreeMap<NodeId, (usize, Instant, Vec<String>)>,
}

impl Trace {
    /// A trace to be written to `path`, of nodes that are called so.
    ///
    /// # Errors
    /// Where the file cannot be made: better now than when the run is done.
    pub fn new(path: PathBuf, names: Vec<String>) -> Result<Self> {
        std::fs::write(&path, "").map_err(|e| Error::io("write", &path, e).help("name another file with --trace"))?;
        let (events, rows, running) = (Vec::new(), Vec::new(), BTreeMap::new());
        Ok(Self { path, names, begun: Instant::now(), events, rows, running })
    }

    /// Takes one event, with the estimate of the time left.
    pub fn take(&mut self, event: &Event, left: Option<Duration>, now: Instant) {
        match event {
            Event::Started { node, why } => {
                let row = self.rows.iter().position(Option::is_none).unwrap_or(self.rows.len());
                self.rows.resize(self.rows.len().max(row + 1), None);
                self.rows[row] = Some(*node);
                self.running.insert(*node, (row, now, why.iter().map(ToString::to_string).collect()));
            }
            Event::Hit { node, .. } if self.running.contains_key(node) => self.end(*node, now, &json!("found")),
            Event::Hit { node, .. } => self.mark("found", *node, now),
            Event::Waiting { node } => self.mark("waiting for another process", *node, now),
            Event::Skipped { node } => self.mark("skipped", *node, now),
            Event::Finished { node, digest, .. } => self.end(*node, now, &json!(digest.to_string())),
            Event::Failed { node, error } => self.end(*node, now, &json!(error.message)),
            Event::Planned { .. } | Event::Progress { .. } => {}
        }
        if let Some(left) = left {
            let left = json!({ "name": "left", "ph": "C", "pid": 1, "ts": self.micros(now), "args": { "s": left.as_secs_f64() } });
            self.events.push(left);
        }
    }

    fn micros(&self, at: Instant) -> u64 {
        u64::try_from(at.saturating_duration_since(self.begun).as_micros()).unwrap_or(u64::MAX)
    }

    fn name(&self, node: NodeId) -> &str {
        self.names.get(node.index()).map_or("?", String::as_str)
    }

    fn mark(&mut self, what: &str, node: NodeId, now: Instant) {
        let mark = json!({ "name": format!("{}: {what}", self.name(node)), "ph": "i", "s": "g", "pid": 1, "tid": 0, "ts": self.micros(now) });
        self.events.push(mark);
    }

    fn end(&mut self, node: NodeId, now: Instant, result: &Value) {
        let Some((row, since, why)) = self.running.remove(&node) else { return };
        self.rows[row] = None;
        let (from, to) = (self.micros(since), self.micros(now));
        let stage = self.name(node).split(['/', ' ']).next().unwrap_or_default();
        let span = json!({ "name": self.name(node), "cat": stage, "ph": "X", "pid": 1, "tid": row + 1, "ts": from,
            "dur": to - from, "args": { "why": why, "result": result } });
        self.events.push(span);
    }

    /// Writes the file.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self) -> Result<()> {
        let page = json!({ "displayTimeUnit": "ms", "traceEvents": self.events });
        std::fs::write(&self.path, page.to_string()).map_err(|e| Error::io("write", &self.path, e))
    }
}
