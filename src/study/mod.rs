//! Study file (TOML) to validated settings to the graph of nodes, and the results folder.

pub mod document;
pub mod graph;
pub mod inputs;
pub mod lock;
pub mod render;
pub mod results;
pub mod settings;
