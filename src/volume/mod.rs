//! 3-D grids: view rendering, robust merge, rootness, suppression, hysteresis.

pub mod grid;
pub mod pyramid;

pub use grid::Grid;
