//! Where cameras and tank are: from the photographs alone, given the tank's size.  Paper 2.2.
//!
//! [`masks`] finds the printed belts, structure from motion on them gives a [`sparse::SparseModel`] in a
//! frame of its own, [`start`] lays a first tank frame through the belts' points, [`chamfer`] registers
//! the tank's silhouettes (the paper's way), and [`adjust`] adjusts cameras, lens and belt points together.

pub mod adjust;
pub mod chamfer;
pub mod check;
mod height;
pub mod masks;
pub mod outline;
pub mod patches;
pub mod quality;
pub mod register;
pub mod similarity;
pub mod sparse;
pub mod start;

pub use chamfer::Edge;
pub use register::{LensPrior, Method, RegisterParams, Registration, register};
pub use sparse::SparseModel;
