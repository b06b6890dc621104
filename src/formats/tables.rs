//! The CSV tables of the results: units stand in the headers, a dot is the decimal mark.

use crate::error::{Error, Result};
use serde::Serialize;

/// A row of `root_voxels.csv`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct RootVoxel {
    /// Tank frame, mm.
    pub x_mm: f32,
    /// Tank frame, mm.
    pub y_mm: f32,
    /// Tank frame, mm.
    pub z_mm: f32,
    /// Sato's measure at the voxel.
    pub rootness: f32,
}

/// The rows as CSV with a header; a header alone needs `columns`.
///
/// # Errors
/// Where a row cannot be written as a flat record.
pub fn csv<R: Serialize>(columns: &[&str], rows: impl IntoIterator<Item = R>) -> Result<Vec<u8>> {
    let fault = |e: &dyn std::fmt::Display| Error::failed(format!("CSV table: {e}"));
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(columns).map_err(|e| fault(&e))?;
    for row in rows {
        writer.serialize(row).map_err(|e| fault(&e))?;
    }
    writer.into_inner().map_err(|e| fault(&e))
}

/// `root_voxels.csv`.
///
/// # Errors
/// As [`csv`].
pub fn root_voxels(rows: &[RootVoxel]) -> Result<Vec<u8>> {
    csv(&["x_mm", "y_mm", "z_mm", "rootness"], rows)
}
