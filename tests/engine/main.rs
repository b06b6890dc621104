//! The engine over toy stages: what runs, what is reused, what survives.

mod care;
mod failure;
mod kill;
mod plan;
mod reuse;
mod speed;
mod streaming;
mod toy;
mod upstream;
