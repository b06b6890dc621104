//! The CSV tables of the results: units stand in the headers, a dot is the decimal mark.

use crate::error::{Error, Result};
use crate::roots::correction::Outcome;
use crate::roots::traits::Trait;
use crate::roots::traits::depth::Layer;
use crate::roots::traits::per_root::{COLUMNS, PerRoot};
use crate::roots::traits::spread::Spread;
use crate::roots::{Repair, TracedRoot};
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
/// As `csv`.
pub fn root_voxels(rows: &[RootVoxel]) -> Result<Vec<u8>> {
    csv(&["x_mm", "y_mm", "z_mm", "rootness"], rows)
}

/// A row of `roots.csv`: one centreline point; a root's rows stand together, base first.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct CentrelinePoint {
    root_id: i64,
    parent_id: i64,
    order: u32,
    x_mm: f64,
    y_mm: f64,
    z_mm: f64,
    diameter_mm: f64,
    diameter_sd_mm: f64,
    views: u32,
    confidence: f64,
}

/// `roots.csv`.
///
/// # Errors
/// As `csv`.
pub fn roots(roots: &[TracedRoot]) -> Result<Vec<u8>> {
    // A tenth of a micrometre is finer than any photograph.
    let round = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
    let rows = roots.iter().flat_map(|traced| {
        let root = &traced.root;
        root.points_mm.iter().enumerate().map(move |(k, p)| CentrelinePoint {
            root_id: root.id,
            parent_id: root.parent,
            order: root.order,
            x_mm: round(p[0]),
            y_mm: round(p[1]),
            z_mm: round(p[2]),
            diameter_mm: round(2.0 * root.radii_mm[k]),
            diameter_sd_mm: round(2.0 * traced.radius_sd_mm[k]),
            views: traced.views[k],
            confidence: round(traced.confidence[k]),
        })
    });
    let columns = [
        "root_id",
        "parent_id",
        "order",
        "x_mm",
        "y_mm",
        "z_mm",
        "diameter_mm",
        "diameter_sd_mm",
        "views",
        "confidence",
    ];
    csv(&columns, rows)
}

/// `repairs.csv`: what the tracing changed against the bare ridge, and why.
///
/// # Errors
/// As `csv`.
pub fn repairs(repairs: &[Repair]) -> Result<Vec<u8>> {
    let round = |x: f64| (x * 1e3).round() / 1e3 + 0.0;
    let rows = repairs.iter().map(|r| {
        let [x, y, z] = r.place_mm.map(round);
        (r.kind.name(), x, y, z, round(r.length_mm), r.reason.as_str())
    });
    csv(&["repair", "x_mm", "y_mm", "z_mm", "length_mm", "reason"], rows)
}

/// `corrections.csv`: what became of each correction.
///
/// # Errors
/// As `csv`.
pub fn corrections(outcomes: &[Outcome]) -> Result<Vec<u8>> {
    let round = |x: f64| (x * 1e3).round() / 1e3 + 0.0;
    let rows = outcomes.iter().enumerate().map(|(n, o)| {
        let place = o.place_mm.map_or([None; 3], |p| p.map(|x| Some(round(x))));
        (n + 1, &o.kind, if o.applied { "yes" } else { "no" }, place, &o.found, &o.by, &o.when, &o.note)
    });
    csv(&["correction", "kind", "applied", "x_mm", "y_mm", "z_mm", "found", "by", "when", "note"], rows)
}

/// `traits.csv`: one trait per row; the name ends in its unit, a trait that is not defined has no value.
///
/// # Errors
/// As `csv`.
pub fn traits(traits: &[Trait]) -> Result<Vec<u8>> {
    csv(&["trait", "value"], traits.iter().map(|t| (t.name.as_str(), finite(t.value))))
}

/// `per_root.csv`.
///
/// # Errors
/// As `csv`.
pub fn per_root(rows: &[PerRoot]) -> Result<Vec<u8>> {
    csv(&COLUMNS, rows)
}

/// `depth_profile.csv`.
///
/// # Errors
/// As `csv`.
pub fn depth_profile(layers: &[Layer]) -> Result<Vec<u8>> {
    csv(&["depth_from_mm", "depth_to_mm", "length_mm", "volume_mm3", "tips", "width_mm"], layers)
}

/// `trait_spread.csv`.
///
/// # Errors
/// As `csv`.
pub fn trait_spread(rows: &[Spread]) -> Result<Vec<u8>> {
    let row = |s: &Spread| {
        let numbers = [s.mean, s.sd, s.low_2_5, s.high_97_5].map(finite);
        (s.name.clone(), finite(s.value), s.count, numbers)
    };
    csv(&["trait", "value", "draws", "mean", "sd", "quantile_2.5", "quantile_97.5"], rows.iter().map(row))
}

/// The rows of a `traits.csv`; an empty value is NaN.
///
/// # Errors
/// Where the table is not of that form.
pub fn read_traits(bytes: &[u8]) -> Result<Vec<Trait>> {
    let fault = |why: &dyn std::fmt::Display| Error::failed(format!("traits.csv: {why}"));
    let mut reader = csv::Reader::from_reader(bytes);
    reader
        .records()
        .map(|row| {
            let row = row.map_err(|e| fault(&e))?;
            let cell = row.get(1).unwrap_or_default();
            let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
            Ok(Trait {
                name: row.get(0).unwrap_or_default().to_owned(),
                value: value.map_err(|e| fault(&format!("`{cell}`: {e}")))?,
            })
        })
        .collect()
}

/// A table as it stands in its file: the cells as text.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

/// Reads any of the tables; `name` is the file's, for messages.
///
/// # Errors
/// Where the rows differ in length or are no UTF-8.
pub fn read(name: &str, bytes: &[u8]) -> Result<Table> {
    let fault = |e: csv::Error| Error::failed(format!("{name}: {e}"));
    let cells = |row: &csv::StringRecord| row.iter().map(str::to_owned).collect();
    let mut reader = csv::Reader::from_reader(bytes);
    let columns = cells(reader.headers().map_err(fault)?);
    let rows = reader.records().map(|row| Ok(cells(&row.map_err(fault)?))).collect::<Result<_>>()?;
    Ok(Table { columns, rows })
}

/// An empty cell instead of NaN or infinity.
fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}
