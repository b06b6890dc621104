//! 3-D grids: view rendering, robust merge, rootness, suppression, hysteresis.
//!
//! From the views' volumes on, in the order of the data:
//! [`merge`] (one colour per voxel) - [`rootness`] (gray, [`hessian`], [`sato`]) - [`suppress`] (ridges,
//! by the 13 orientations of [`orientation`]) - [`hysteresis`] (roots among the ridges). Each works on slabs of
//! planes, with the halo it declares or in their order, and gives the same bits however the volume is cut; hysteresis looks at all
//! ridges, its thresholds in units of their [`level`].

pub mod gaussian;
pub mod grid;
pub mod hessian;
pub mod hysteresis;
pub mod level;
pub mod map_error;
pub mod merge;
pub mod orientation;
pub mod patch_rbf;
pub mod plane;
pub mod pyramid;
pub mod render;
pub mod ridges;
pub mod rootness;
pub mod sato;
pub mod suppress;

pub use grid::Grid;
pub use hysteresis::{Hysteresis, Links, Pieces};
pub use merge::{Estimator, Merge, Merged, Metric};
pub use patch_rbf::{PatchMap, PatchRbf, PatchRbfRenderer};
pub use render::{RenderOptions, Sampling, ViewRenderer};
pub use ridges::Ridges;
pub use rootness::{RootVolume, Rootness};
pub use sato::Sato;
pub use suppress::Suppress;
