//! Study file (TOML) to validated settings to the graph of nodes.

pub mod document;
pub mod inputs;
