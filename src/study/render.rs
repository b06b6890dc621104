//! `[render]`: how photographs become the views' volumes, and whether these are kept.

use crate::error::Result;
use crate::volume::{Grid, PatchRbf, RenderOptions, Sampling};
use serde::{Deserialize, Serialize};

/// How the pixel of a voxel is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// By the exact inverse of the ray's path.
    #[default]
    Exact,
    /// By the paper's two-step search and interpolation (2.3.2), point sampled.
    PatchRbf,
}

/// Whether the views' volumes are kept in the store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Keep {
    /// As long as all views together stay under [`MOST_STORED_BYTES`].
    #[default]
    Auto,
    /// Always: a changed merge reads them instead of rendering again.
    Always,
    /// Never: they are rendered slab by slab into the merge.
    Never,
}

/// Views' volumes larger than this together are not stored: writing and reading them would take longer than
/// rendering them again, and a lab's disk is finite.
pub const MOST_STORED_BYTES: u64 = 2 << 30;

/// `[render]`: the views' volumes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSection {
    /// exact or patch-rbf (the paper's).
    pub method: Method,
    /// Leave out the rays beyond the fold.  Paper 2.3.3.
    pub exclude_irregular: bool,
    /// footprint (the mean over the voxel's share of the picture) or point (the paper's).
    pub sampling: Sampling,
    /// With patch-rbf: side of the picture's patches, px.  Paper: 64.
    pub patch: usize,
    /// With patch-rbf: distance of the searched voxels, voxels.  Paper: 10.
    pub every: usize,
    /// auto, always or never; no result depends on it.
    pub store: Keep,
}

impl Default for RenderSection {
    fn default() -> Self {
        let (options, sizes) = (RenderOptions::default(), PatchRbf::default());
        Self {
            method: Method::Exact,
            exclude_irregular: options.exclude_irregular,
            sampling: options.sampling,
            patch: sizes.patch_px,
            every: sizes.every,
            store: Keep::Auto,
        }
    }
}

impl RenderSection {
    /// Options of the exact inverse.
    pub fn options(&self) -> RenderOptions {
        RenderOptions { exclude_irregular: self.exclude_irregular, sampling: self.sampling }
    }

    /// Sizes of the paper's search.
    pub fn sizes(&self) -> PatchRbf {
        PatchRbf { patch_px: self.patch, every: self.every, exclude_irregular: self.exclude_irregular }
    }

    /// Fails where a size is zero.
    ///
    /// # Errors
    /// As [`PatchRbf::check`].
    pub fn check(&self) -> Result<()> {
        self.sizes().check()
    }

    /// Whether `views` volumes of that grid are streamed rather than stored.
    pub fn is_virtual(&self, grid: &Grid, views: usize) -> bool {
        match self.store {
            Keep::Auto => (grid.len() * views * 4) as u64 > MOST_STORED_BYTES,
            Keep::Always => false,
            Keep::Never => true,
        }
    }
}
