//! The stages, in the order of the data: one file each, thin adapters between the engine and the rooms.
//!
//! To add one: a file here, a line below, a line in `study/graph.rs`.

pub mod axis;
pub mod camera;
pub mod cameras;
pub mod capture;
mod colmap_run;
pub mod contrast;
pub mod diameters;
pub mod evaluate;
pub mod extract;
pub mod feature;
pub mod labels;
pub mod lattice;
pub mod merge;
pub mod overlay;
pub mod photograph;
pub mod pose;
pub mod pose_pictures;
pub mod render;
pub mod render_patch;
pub mod rootness;
pub mod sfm;
pub mod sfm_known;
pub mod sfm_mask;
pub mod slices;
pub mod suppress;
pub mod trace;
pub mod traits;
pub mod undistort;
pub mod volume;

use crate::error::{Error, Result};
use crate::store::{Artefact, Element};
use ndarray::{Array3, Array4, ArrayD, Ix3, Ix4};
use std::ops::Range;

/// Planes of a volume that a stage holds at once, so that memory does not grow with depth.
pub(crate) const SLAB_PLANES: usize = 16;

/// Cuts `0..depth` into slabs of [`SLAB_PLANES`]: per slab its own planes, and those with `halo` planes
/// beyond them where the volume has them.
pub(crate) fn slabs(depth: usize, halo: usize) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    (0..depth).step_by(SLAB_PLANES).map(move |start| {
        let end = (start + SLAB_PLANES).min(depth);
        (start..end, start.saturating_sub(halo)..(end + halo).min(depth))
    })
}

/// A whole array of three axes.
pub(crate) fn read3<T: Element>(artefact: &Artefact, name: &str) -> Result<Array3<T>> {
    three(artefact.array::<T>(name)?.read()?)
}

/// As an array of three axes.
pub(crate) fn three<T>(array: ArrayD<T>) -> Result<Array3<T>> {
    array.into_dimensionality::<Ix3>().map_err(|e| Error::failed(format!("an array of the store has other axes: {e}")))
}

/// As an array of four axes.
pub(crate) fn four<T>(array: ArrayD<T>) -> Result<Array4<T>> {
    array.into_dimensionality::<Ix4>().map_err(|e| Error::failed(format!("an array of the store has other axes: {e}")))
}
