//! Shows a run: a bar per running node and one for the whole on a terminal, a line per node otherwise.

use super::terminal::talkln;
use crate::flow::{Event, NodeId};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Shows events as they come.
pub struct Display {
    labels: Vec<String>,
    terminal: bool,
    bars: MultiProgress,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    whole: Option<ProgressBar>,
    running: BTreeMap<NodeId, ProgressBar>,
    total: usize,
    hits: usize,
    done: usize,
    ran: usize,
    /// The time left in words; empty where it is not known.
    left: String,
}

impl Display {
    /// A display for runs of a graph whose nodes are called so.
    pub fn new(labels: Vec<String>) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        Self { labels, terminal, bars: MultiProgress::with_draw_target(target), state: Mutex::default() }
    }

    /// Takes a new estimate of the time left, and whether it covers all nodes.
    pub fn left(&self, left: Option<(Duration, bool)>) {
        let Some((left, all_known)) = left else { return };
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.left = in_words(left, all_known);
    }

    /// Takes one event.
    pub fn show(&self, event: &Event) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        match event {
            Event::Planned { total } => {
                state.total = *total;
                let bar = self.bars.add(ProgressBar::new(*total as u64));
                bar.set_style(style("{bar:30} {pos}/{len} nodes  {elapsed} {msg}"));
                state.whole = Some(bar);
            }
            Event::Hit { node, warnings, .. } => {
                state.hits += 1;
                self.step(&mut state);
                self.warn(*node, warnings);
            }
            Event::Started { node, .. } => {
                if self.terminal {
                    let bar = self.bars.insert_from_back(1, ProgressBar::new(0));
                    bar.set_style(style("  {msg:24} {bar:20} {percent:>3}%  {elapsed}"));
                    bar.set_message(self.label(*node).to_owned());
                    state.running.insert(*node, bar);
                }
            }
            Event::Progress { node, done, total } => {
                if let Some(bar) = state.running.get(node) {
                    bar.set_length(*total);
                    bar.set_position(*done);
                }
            }
            Event::Waiting { node } => {
                self.say(&format!("{}: another process computes it, waiting", self.label(*node)))
            }
            Event::Finished { node, seconds, same_output, warnings, .. } => {
                self.end(&mut state, *node);
                state.ran += 1;
                if !self.terminal {
                    let same = if *same_output { ", same values as before" } else { "" };
                    let left = if state.left.is_empty() { String::new() } else { format!(" ({})", state.left) };
                    self.say(&format!("{}: {seconds:.2} s{same}{left}", self.label(*node)));
                }
                self.warn(*node, warnings);
            }
            Event::Failed { node, .. } => {
                self.end(&mut state, *node);
                self.say(&format!("{}: failed", self.label(*node)));
            }
            Event::Skipped { .. } => self.step(&mut state),
        }
    }

    /// Takes the bars away and says in one line what was done.
    pub fn finish(&self) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(bar) = &state.whole {
            bar.finish_and_clear();
        }
        talkln!("{} nodes: {} cached, {} computed", state.total, state.hits, state.ran);
    }

    fn label(&self, node: NodeId) -> &str {
        self.labels.get(node.index()).map_or("?", String::as_str)
    }

    fn end(&self, state: &mut State, node: NodeId) {
        if let Some(bar) = state.running.remove(&node) {
            bar.finish_and_clear();
            self.bars.remove(&bar);
        }
        self.step(state);
    }

    fn step(&self, state: &mut State) {
        state.done += 1;
        if let Some(bar) = &state.whole {
            bar.set_position(state.done as u64);
            bar.set_message(format!("({} cached) {}", state.hits, state.left));
        }
    }

    fn warn(&self, node: NodeId, warnings: &[String]) {
        for warning in warnings {
            self.say(&format!("warning: {}: {warning}", self.label(node)));
        }
    }

    fn say(&self, line: &str) {
        self.bars.suspend(|| talkln!("{line}"));
    }
}

/// A time that is still to come, as precisely as an estimate is; short ones are not worth a word.
fn in_words(left: Duration, all_known: bool) -> String {
    let about = if all_known { "about" } else { "more than" };
    match left.as_secs() {
        0..5 => String::new(),
        s @ 5..100 => format!("{about} {} s left", s.div_ceil(5) * 5),
        s @ 100..6000 => format!("{about} {} min left", (s + 30) / 60),
        s => format!("{about} {:.1} h left", s as f64 / 3600.0),
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
