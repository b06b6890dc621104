//! Shows a run: a bar per running node and one for the whole on a terminal, a line per node otherwise.

use crate::flow::{Event, NodeId};
use indicatif::{MultiProgress, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};

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
}

impl Display {
    /// A display for runs of a graph whose nodes are called so.
    pub fn new(labels: Vec<String>) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        Self { labels, terminal, bars: MultiProgress::with_draw_target(target), state: Mutex::default() }
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
                if !self.terminal {
                    let same = if *same_output { ", same values as before" } else { "" };
                    self.say(&format!("{}: {seconds:.2} s{same}", self.label(*node)));
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
        let ran = state.done.saturating_sub(state.hits);
        eprintln!("{} nodes: {} cached, {ran} computed", state.total, state.hits);
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
            bar.set_message(format!("({} cached)", state.hits));
        }
    }

    fn warn(&self, node: NodeId, warnings: &[String]) {
        for warning in warnings {
            self.say(&format!("warning: {}: {warning}", self.label(node)));
        }
    }

    fn say(&self, line: &str) {
        self.bars.suspend(|| eprintln!("{line}"));
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
