//! What suppression leaves: a sparse list of ridge voxels.

use super::Grid;
use crate::optics::Vec3;

/// Ridge voxels in ascending order of index; all lists have the same length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ridges {
    /// Shape (z, y, x) of the volume.
    pub shape: [usize; 3],
    /// Flat index (z * ny + y) * nx + x.
    pub index: Vec<u32>,
    /// Rootness, above 0.
    pub rootness: Vec<f32>,
    /// Unit tangent (x, y, z), sign free.
    pub tangent: Vec<[f32; 3]>,
    /// From the voxel's centre to the ridge, across the tangent, voxels (x, y, z).
    pub offset: Vec<[f32; 3]>,
    /// Index of the scale that won.
    pub scale: Vec<u8>,
}

impl Ridges {
    /// Number of ridge voxels.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.index.is_empty()
    }

    /// Voxel (k, j, i) of entry `n`.
    pub fn voxel(&self, n: usize) -> [usize; 3] {
        let [_, ny, nx] = self.shape;
        let index = self.index[n] as usize;
        [index / (ny * nx), index / nx % ny, index % nx]
    }

    /// Position of entry `n` on its ridge, between voxel centres, in the tank frame, mm.
    pub fn point_mm(&self, n: usize, grid: &Grid) -> Vec3 {
        let [k, j, i] = self.voxel(n).map(|x| x as f64);
        let [x, y, z] = self.offset[n].map(f64::from);
        grid.point_mm(k + z, j + y, i + x)
    }

    /// Adds the ridges of the next slab of the same volume.
    pub fn append(&mut self, mut next: Self) {
        self.index.append(&mut next.index);
        self.rootness.append(&mut next.rootness);
        self.tangent.append(&mut next.tangent);
        self.offset.append(&mut next.offset);
        self.scale.append(&mut next.scale);
    }
}
