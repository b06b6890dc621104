//! `growth.csv`: a row per root and interval. Columns are told in docs/trials.md.

use super::tables;
use crate::error::Result;
use crate::growth::follow::{Growth, State};
use crate::growth::recall::Recalled;

/// The columns of `growth.csv`.
pub const COLUMNS: [&str; 16] = [
    "root_id",
    "parent_id",
    "order",
    "from_day",
    "to_day",
    "days",
    "state",
    "length_from_mm",
    "length_to_mm",
    "overlap",
    "elongation_mm",
    "elongation_mm_per_day",
    "new_laterals",
    "diameter_change_mm",
    "diameter_change_mm_per_day",
    "recalled",
];

/// The content of the table; `days` are the times of the days, in days: the first counts as 0; `recalled` are the roots that were found on
/// a day with another day's help.
///
/// # Errors
/// Where a row cannot be written.
pub fn write(growth: &Growth, days: &[f64], recalled: &[Recalled]) -> Result<Vec<u8>> {
    let number = |x: f64| (x * 1e4).round() / 1e4 + 0.0;
    let rows = growth.intervals.iter().map(|i| {
        let [from, to] = i.days.map(|n| days[n] - days[0]);
        let state = match i.state {
            State::Followed => "followed",
            State::Appeared => "appeared",
            State::Vanished => "vanished",
        };
        let track = growth.tracks.iter().find(|t| t.id == i.root);
        let (parent, order) = track.map_or((-1, 0), |t| (t.parent, t.order));
        let with_rate = |x: Option<f64>| [x, x.map(|x| x / (to - from))].map(|x| x.map(number));
        let helped = i.days.map(|day| recalled.iter().any(|r| r.root.root.id == i.root && r.days[0] == day));
        let helped = match helped {
            [false, false] => "",
            [true, false] => "from",
            [false, true] => "to",
            [true, true] => "both",
        };
        (
            (i.root, parent, order, number(from), number(to), number(to - from), state),
            i.length_mm.map(|x| x.map(number)),
            i.overlap.map(number),
            with_rate(i.elongation_mm),
            i.new_laterals,
            with_rate(i.diameter_change_mm),
            helped,
        )
    });
    tables::csv(&COLUMNS, rows)
}
