//! Study file (TOML) to validated settings to the graph of nodes, and the results folder.

pub mod batch;
mod clean_path;
pub mod command;
pub mod cost;
pub mod crate_metadata;
pub mod document;
mod evident;
pub mod folder;
pub mod graph;
pub mod inputs;
mod kept;
pub mod lock;
pub mod nodes;
pub mod page;
mod photographs;
pub mod render;
pub mod rerun;
pub mod results;
mod scale;
pub mod settings;
mod shown;
pub mod sweep;
pub mod sweep_curves;
pub mod sweep_results;
pub mod table;
mod upstream;
