//! What watches a run: the display, the estimate of the time left, and the trace.

use super::progress::Display;
use super::terminal::talkln;
use super::trace::Trace;
use crate::error::Result;
use crate::flow::{Event, NodeId, Remaining};
use crate::store::Store;
use crate::study::batch::Batch;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often the time left is estimated.
const EVERY: Duration = Duration::from_millis(250);

/// Watches one run.
pub struct Watch<'a> {
    display: Display,
    store: &'a Store,
    state: Mutex<State<'a>>,
}

struct State<'a> {
    remaining: Remaining<'a>,
    trace: Option<Trace>,
    estimated: Option<Instant>,
}

impl<'a> Watch<'a> {
    /// A watch over a run of `targets`, which begins with what is to be said of the studies; with `trace`, the trace is
    /// written there.
    ///
    /// # Errors
    /// Where the trace cannot be written.
    pub fn new(
        batch: &'a Batch,
        store: &'a Store,
        targets: &[NodeId],
        threads: usize,
        trace: Option<PathBuf>,
    ) -> Result<Self> {
        for note in batch.notes() {
            talkln!("note: {note}");
        }
        let (graph, names) = (&batch.graph, batch.names());
        let trace = trace.map(|path| Trace::new(path, names.clone())).transpose()?;
        let remaining = Remaining::new(graph, store, targets, threads);
        Ok(Self { display: Display::new(names), store, state: Mutex::new(State { remaining, trace, estimated: None }) })
    }

    /// Takes one event.
    pub fn see(&self, event: &Event) {
        let now = Instant::now();
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.remaining.take(event, now);
        let due = state.estimated.is_none_or(|last| now.saturating_duration_since(last) >= EVERY);
        let left = if due { state.remaining.left(now) } else { None };
        if left.is_some() {
            state.estimated = Some(now);
        }
        if let Some(trace) = &mut state.trace {
            trace.take(event, left.map(|(left, _)| left), now);
        }
        drop(state);
        self.display.left(left);
        self.display.show(event);
    }

    /// Ends the display and writes the trace; to be called however the run ended.
    ///
    /// # Errors
    /// Where the trace cannot be written.
    pub fn finish(&self) -> Result<()> {
        self.display.finish();
        complain(self.store);
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.trace.as_ref().map_or(Ok(()), Trace::write)
    }
}

/// Tells what was noticed of the store behind.
pub fn complain(store: &Store) {
    store.complaints().iter().for_each(|text| talkln!("warning: {text}"));
}
