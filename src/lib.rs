//! rootvox turns a ring of ordinary photographs of a plant growing in a water-filled transparent
//! cylinder into its 3D root system: centrelines, diameters, traits.
//!
//! The rooms, in the order of the data; imports run one way, down this list:
//! [`math`], [`optics`], [`photo`], [`calibration`], [`volume`], [`roots`], [`growth`], [`simulation`],
//! [`evaluation`], [`formats`], [`report`]; beside them the engine, [`store`] and [`flow`], which
//! knows nothing of roots; above them [`stages`], where domain and engine meet, [`study`], [`view`] and [`cli`].

// `eprintln!` panics where a log lies on a full disk: `cli::terminal` does not.
#![cfg_attr(not(test), warn(clippy::print_stderr))]

pub mod calibration;
pub mod cli;
pub mod error;
pub mod evaluation;
pub mod flow;
pub mod formats;
pub mod growth;
pub mod math;
pub mod optics;
pub mod photo;
pub mod report;
pub mod roots;
pub mod simulation;
pub mod stages;
pub mod store;
pub mod study;
pub mod view;
pub mod volume;

pub use error::{Error, Result};
