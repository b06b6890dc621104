//! What a worker did, counted.

use crate::flow::Event;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

#[derive(Default)]
struct Counts {
    nodes: usize,
    seconds: f64,
    vain_nodes: usize,
    vain_seconds: f64,
    failed: usize,
}

/// Counts the events of a run.
#[derive(Default)]
pub struct Tally(Mutex<Counts>);

impl Tally {
    /// Takes one event.
    pub fn take(&self, event: &Event) {
        let mut counts = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Finished { seconds, in_vain, .. } => {
                counts.nodes += 1;
                counts.seconds += seconds;
                if *in_vain {
                    counts.vain_nodes += 1;
                    counts.vain_seconds += seconds;
                }
            }
            Event::Failed { .. } => counts.failed += 1,
            _ => {}
        }
    }

    /// The counts of a worker that was there for `elapsed`.
    pub fn words(&self, elapsed: Duration) -> String {
        let c = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        format!(
            "worked {:.1} s: computed {} nodes in {:.1} s, {} of them in vain ({:.1} s) because another worker was \
             faster; {} failed",
            elapsed.as_secs_f64(),
            c.nodes,
            c.seconds,
            c.vain_nodes,
            c.vain_seconds,
            c.failed
        )
    }
}
