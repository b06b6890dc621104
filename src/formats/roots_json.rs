//! `roots.json`: a list of roots {id, parent (-1: none), order, points [[x, y, z] ...] mm, radii mm}.

use super::json;
use crate::error::{Error, Result};
use crate::roots::Root;

/// Reads the content of a `roots.json`.
///
/// # Errors
/// Names the root: another form, no points, as many radii as points missed, numbers that are not finite.
pub fn parse(name: &str, text: &str) -> Result<Vec<Root>> {
    let roots: Vec<Root> = json::parse(name, text)?;
    for root in &roots {
        let fault = if root.points_mm.is_empty() {
            "has no points"
        } else if root.points_mm.len() != root.radii_mm.len() {
            "has another number of radii than of points"
        } else if root.points_mm.iter().flatten().chain(&root.radii_mm).any(|x| !x.is_finite()) {
            "holds a number that is not finite"
        } else {
            continue;
        };
        return Err(Error::failed(format!("`{name}`: root {} {fault}", root.id)));
    }
    Ok(roots)
}

/// The content of a `roots.json`.
///
/// # Errors
/// Where a number is not finite.
pub fn write(roots: &[Root]) -> Result<String> {
    serde_json::to_string(roots).map_err(|e| Error::failed(format!("roots.json: {e}")))
}
