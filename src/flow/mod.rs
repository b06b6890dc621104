//! The engine: an incremental dataflow over the store; knows nothing of roots.
//!
//! A [`Graph`] of files and [`Stage`]s is brought up to date by an [`Engine`]: every node whose key the store knows is
//! a hit, all others run, as many at once as threads and memory allow. A node's key holds the *digests* of its inputs:
//! a stage that runs again and gives the same values leaves everything downstream untouched.

mod change;
mod engine;
mod event;
mod found;
mod graph;
mod key;
mod layout;
mod plan;
mod remaining;
mod resident;
mod run;
mod schedule;
mod stage;
mod streaming;
mod urgency;

pub use crate::store::{Artefact, Output};
pub use change::Change;
pub use engine::{Engine, Report};
pub use event::Event;
pub use graph::{Graph, NodeId, Walk};
pub use layout::lay_out;
pub use plan::{NodeState, Plan, Planned, Step};
pub use remaining::Remaining;
pub use stage::{Inputs, Progress, Stage, Streamed};
pub use streaming::store_streamed;
