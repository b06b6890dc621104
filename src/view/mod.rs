//! A study, looked at and changed in a browser: the report's page, live, served on this machine alone.
//!
//! - **Page**: the report's own ([`crate::report::page`]) with a panel of settings and a section of slices; `page/` holds what is added.
//! - **Changes** (`session.rs`): the page asks for settings, the engine computes what they touch in the order in which it is looked
//!   at (root voxels, roots and traits, roots on photographs), and each is told to all open pages as it is there. A
//!   newer change cancels the one before. What finished is in the store, as after any run.
//! - **Keeping** (`keeper.rs`): settings are written into the study file, whose comments and order stay; undo puts the text back.
//! - **Correcting** (`correct`): a correction made by click is added to the study's file of corrections.
//! - **Guard** (`guard.rs`): only this machine's addresses are served, to those who know the token; what a foreign page asks for is
//!   refused; bodies are small; no file is served by its path.

mod correct;
mod fields;
mod guard;
mod keeper;
mod message;
mod page;
mod server;
mod session;
mod slice;
mod work;

pub use server::{Served, serve};
pub use session::Session;
pub use work::Opening;
