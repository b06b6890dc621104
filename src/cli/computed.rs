//! Nodes of a study brought up to date, for commands that take something out of it.

use super::options::{MachineOptions, StoreOptions};
use super::progress::Display;
use crate::error::Result;
use crate::flow::{Engine, Graph, NodeId, Report};

/// Brings nodes up to date, showing how far they are.
pub(super) fn computed(
    graph: &Graph,
    wanted: &[NodeId],
    store: &StoreOptions,
    machine: &MachineOptions,
) -> Result<Report> {
    let store = store.open()?;
    let display = Display::new(graph.labels());
    let report = Engine::new(&store)
        .threads(machine.threads())
        .memory_bytes(machine.memory_bytes())
        .cancel(super::cancel::flag()?)
        .on_event(|event| display.show(event))
        .run(graph, wanted)?;
    display.finish();
    super::watch::complain(&store);
    Ok(report)
}
