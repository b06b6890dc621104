//! 3-D grids: view rendering, robust merge, rootness, suppression, hysteresis.

pub mod grid;
pub mod render;

pub use grid::Grid;
pub use render::ViewRenderer;
