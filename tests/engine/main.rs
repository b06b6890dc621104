//! The engine over toy stages: what runs, what is reused, what survives.

mod reuse;
mod toy;
