//! Arrays and groups outside of the store's own members: inside a folder that a stage fills.

use std::path::Path;

use super::array::SlabWriter;
use super::element::Element;
use super::files;
use crate::error::{Error, Result};

/// Begins an array at `folder`, laid out as the store's own.
///
/// # Errors
/// Where the folder cannot be written or shape and names of the axes disagree.
pub fn write_array<T: Element>(folder: &Path, shape: &[usize], dimensions: &[&str]) -> Result<SlabWriter<T>> {
    SlabWriter::create(folder, shape, dimensions, Box::new(|_| Ok(())))
}

/// Makes `folder` a Zarr group with these attributes.
///
/// # Errors
/// Where the folder cannot be written.
pub fn write_group(folder: &Path, attributes: &serde_json::Value) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    let group = serde_json::json!({ "zarr_format": 3, "node_type": "group", "attributes": attributes });
    files::write_synced(&folder.join("zarr.json"), format!("{group:#}\n").as_bytes())
}
