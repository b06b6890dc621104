//! 3-D grids: view rendering, robust merge, rootness, suppression, hysteresis.

pub mod grid;

pub use grid::Grid;
