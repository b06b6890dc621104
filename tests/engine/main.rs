//! The engine over toy stages: what runs, what is reused, what survives.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

mod care;
mod failure;
mod kill;
mod plan;
mod reuse;
mod speed;
mod streaming;
mod toy;
mod upstream;
mod workers;
