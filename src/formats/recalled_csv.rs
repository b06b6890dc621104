//! `recalled.csv`: a row per root and day on which it was found with another day's help. Columns are told in docs/trials.md.

use super::tables;
use crate::error::Result;
use crate::growth::recall::Recalled;
use crate::roots::traits::topology::length_mm;

/// The columns of `recalled.csv`.
pub const COLUMNS: [&str; 6] = ["root_id", "day", "by_day", "length_mm", "contrast", "chance"];

/// The content of the table; `days` are the times of the days, in days: the first counts as 0.
///
/// # Errors
/// Where a row cannot be written.
pub fn write(recalled: &[Recalled], days: &[f64]) -> Result<Vec<u8>> {
    let number = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
    let rows = recalled.iter().map(|one| {
        let [day, by] = one.days.map(|n| number(days[n] - days[0]));
        (one.root.root.id, day, by, number(length_mm(&one.root.root)), number(one.contrast), number(one.chance))
    });
    tables::csv(&COLUMNS, rows)
}
