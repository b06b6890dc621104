//! The stages, in the order of the data: one file each, thin adapters between the engine and the rooms.
//!
//! To add one: a file here, a line below, a line in `study/graph.rs`.

pub mod align;
pub mod background;
pub mod camera;
pub mod cameras;
pub mod capture;
mod colmap_photos;
mod colmap_run;
pub mod corrections;
pub mod diameters;
pub mod evaluate;
pub mod evaluate_cameras;
pub mod evaluate_roots;
pub mod evidence;
pub mod evidence_pictures;
pub mod explain;
pub mod extract;
pub mod follow;
pub mod hierarchy;
pub mod labels;
pub mod lattice;
pub mod merge;
pub mod misjudge;
pub mod overlay;
pub mod photograph;
mod photographs;
pub mod pose;
pub mod pose_pictures;
pub mod preview;
pub mod print;
pub mod recall;
pub mod recalled;
pub mod render;
pub mod render_patch;
pub mod root_lines;
pub mod root_overlay;
pub mod rootness;
pub mod sfm;
pub mod sfm_known;
pub mod sfm_mask;
pub mod sight;
pub mod slices;
pub mod spread;
pub mod suppress;
pub mod survey;
pub mod trace;
pub mod traits;
pub mod undistort;
pub mod volume;

use crate::error::{Error, Result};
use crate::store::{Artefact, Element};
use ndarray::{Array3, Array4, ArrayD, Ix3, Ix4};
use std::ops::Range;

/// Planes that a stage holds at once at most: two layers of a stored array's chunks.
pub(crate) const SLAB_PLANES: usize = 16;
/// Bytes that a stage's slab takes at most, unless one plane is larger: memory does not grow with the grid's fineness.
pub(crate) const SLAB_BYTES: usize = 512 << 20;

/// Cuts `0..depth` into slabs of planes that take `plane_bytes` each: per slab its own planes, and those with `halo`
/// planes beyond them where the volume has them.
pub(crate) fn slabs(
    depth: usize,
    halo: usize,
    plane_bytes: usize,
) -> impl Iterator<Item = (Range<usize>, Range<usize>)> {
    let mut planes = SLAB_PLANES;
    while planes > 1 && (planes + 2 * halo) * plane_bytes > SLAB_BYTES {
        planes /= 2;
    }
    (0..depth).step_by(planes).map(move |start| {
        let end = (start + planes).min(depth);
        (start..end, start.saturating_sub(halo)..(end + halo).min(depth))
    })
}

/// The values of an array in its order.
pub(crate) fn flat<T: Element>(array: ArrayD<T>) -> Vec<T> {
    // Copied as a whole where they lie so: an iterator over any axes takes ten times as long.
    array.as_slice().map_or_else(|| array.iter().copied().collect(), <[T]>::to_vec)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slabs_cover_the_volume_within_their_bytes() {
        for (plane_bytes, halo) in [(0, 0), (100 << 20, 0), (30 << 20, 3), (1 << 30, 1)] {
            let all: Vec<_> = slabs(45, halo, plane_bytes).collect();
            assert_eq!((all[0].0.start, all[all.len() - 1].0.end), (0, 45));
            assert!(all.windows(2).all(|w| w[0].0.end == w[1].0.start));
            for (own, with_halo) in all {
                assert_eq!(with_halo, own.start.saturating_sub(halo)..(own.end + halo).min(45));
                assert!(own.len() == 1 || with_halo.len() * plane_bytes <= SLAB_BYTES);
            }
        }
    }
}
