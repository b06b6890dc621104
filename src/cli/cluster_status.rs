//! `rootvox cluster status`: how far the workers are.

use super::options::{StoreOptions, StudiesOptions};
use super::terminal::data;
use crate::error::Result;
use crate::flow::{Engine, Graph, NodeState, Plan, lay_out};
use crate::store::{Key, Past, Store};
use clap::Args;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// Rates are of the last so many seconds.
const LATELY_S: f64 = 600.0;

/// Show how far the workers of a study are: nodes done, what runs where, rate, time left, failures with their logs.
#[derive(Args)]
pub struct Status {
    #[command(flatten)]
    studies: StudiesOptions,
    #[command(flatten)]
    store: StoreOptions,
}

impl Status {
    /// Prints how far they are.
    ///
    /// # Errors
    /// Faults of the studies, or no store.
    pub fn run(&self) -> Result<()> {
        let batch = self.studies.load()?;
        let store = self.store.existing()?;
        let plan = Engine::new(&store).status(&batch.graph, &batch.targets())?;
        let names = batch.names();
        let (mut done, mut of_key, mut pending) = (0, BTreeMap::new(), BTreeSet::new());
        for (node, planned) in plan.nodes() {
            done += usize::from(matches!(planned.state, NodeState::Cached { .. }));
            if let NodeState::WouldRun { key, .. } = planned.state {
                of_key.insert(key, names[node.index()].as_str());
            }
        }
        plan.pending().for_each(|(_, planned)| _ = pending.insert(planned.label.as_str()));
        let to_do = plan.pending().count();
        // Other studies may use the store too.
        let of_claim = |key: &Key, what: &str| {
            of_key.get(key).map(|name| (*name).to_owned()).or_else(|| pending.contains(what).then(|| what.to_owned()))
        };
        let running: Vec<_> =
            store.claims()?.into_iter().filter_map(|(key, h)| Some((of_claim(&key, &h.what)?, h))).collect();
        let failed: Vec<_> =
            store.failures().into_iter().filter_map(|(key, f)| Some((of_claim(&key, &f.label)?, f))).collect();
        let mut text = format!(
            "{done} of {} nodes done, {to_do} to do: {} running, {} failed\n",
            done + to_do,
            running.len(),
            failed.len()
        );
        let _ = write!(text, "{}", pace(&store, &batch.graph));
        let workers: BTreeSet<_> = running.iter().map(|(_, h)| (&h.host, h.process)).collect();
        if to_do > 0 {
            let _ = writeln!(text, "{}", left(&batch.graph, &plan, workers.len()));
        }
        for (name, holder) in &running {
            let since = holder.since.parse::<jiff::Timestamp>().map_or(0.0, age_s);
            let _ = writeln!(text, "running: {name:32} {}:{} for {since:.0} s", holder.host, holder.process);
        }
        for (name, failure) in &failed {
            let _ = writeln!(text, "failed: {name} on {} at {}: {}", failure.by, failure.at, failure.error);
            if let Some(log) = &failure.log {
                let _ = writeln!(text, "  log: {log}");
            }
        }
        data!("{text}");
        Ok(())
    }
}

fn age_s(time: jiff::Timestamp) -> f64 {
    jiff::Timestamp::now().duration_since(time).as_secs_f64()
}

/// How fast nodes were computed lately, and how many more than once.
fn pace(store: &Store, graph: &Graph) -> String {
    let stages: BTreeSet<&str> = graph.nodes().filter_map(|node| graph.stage(node)).collect();
    let past: Vec<Past> = stages.iter().flat_map(|stage| store.history(stage)).collect();
    let lately: Vec<(&Past, f64)> =
        past.iter().filter_map(|p| Some((p, age_s(p.at.parse().ok()?)))).filter(|(_, age)| *age < LATELY_S).collect();
    let mut text = String::new();
    if let Some(span) = lately.iter().map(|(p, age)| age + p.seconds).reduce(f64::max) {
        let (minutes, seconds) = (span.max(1.0) / 60.0, lately.iter().map(|(p, _)| p.seconds).sum::<f64>());
        let (rate, at_once) = (lately.len() as f64 / minutes, seconds / (60.0 * minutes));
        let _ = writeln!(text, "rate: {rate:.0} nodes a minute over {minutes:.1} min, {at_once:.1} at once");
    }
    let (mut seen, mut all, mut again, mut count) = (BTreeSet::new(), 0.0, 0.0, 0);
    for p in &past {
        all += p.seconds;
        if !seen.insert((p.key, p.label.as_str())) && p.seconds > 0.0 {
            again += p.seconds;
            count += 1;
        }
    }
    let share = 100.0 * again / f64::max(all, f64::MIN_POSITIVE);
    let _ = writeln!(text, "computed more than once: {count} nodes, {again:.1} s of {all:.1} s ({share:.1} %)");
    text
}

/// How long it will take, by experience.
fn left(graph: &Graph, plan: &Plan, workers: usize) -> String {
    let (mut open, mut cost) = (vec![false; graph.nodes().count()], vec![0.0; graph.nodes().count()]);
    let mut unknown = 0;
    for (node, planned) in plan.pending() {
        open[node.index()] = true;
        cost[node.index()] = planned.seconds.unwrap_or_default();
        unknown += usize::from(planned.seconds.is_none());
    }
    let seconds = lay_out(graph, &open, &cost, &[], workers.max(1));
    let rest = if unknown > 0 { format!(" and {unknown} nodes without history") } else { String::new() };
    format!("time left: about {:.1} min on {} workers{rest}", seconds / 60.0, workers.max(1))
}
