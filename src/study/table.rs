//! `sweep.csv`: one row per point, its values and what came of it.

use crate::error::{Error, Result};
use crate::formats::tables;

/// A table of texts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Table {
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The rows; a cell may be empty.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// Puts a text into the last row, with a new column where the table has none of that name yet.
    pub fn put(&mut self, column: &str, text: String) {
        let at = self.columns.iter().position(|c| c == column).unwrap_or_else(|| {
            self.columns.push(column.to_owned());
            self.columns.len() - 1
        });
        if let Some(row) = self.rows.last_mut() {
            row.resize(row.len().max(at + 1), String::new());
            row[at] = text;
        }
    }

    /// The table as CSV.
    ///
    /// # Errors
    /// Where a row cannot be written.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let columns: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        let whole = |row: &Vec<String>| {
            let mut row = row.clone();
            row.resize(self.columns.len(), String::new());
            row
        };
        tables::csv(&columns, self.rows.iter().map(whole))
    }

    /// The numbers of a column, row by row; `None` where there is no such column.
    pub fn numbers(&self, column: &str) -> Option<Vec<Option<f64>>> {
        let at = self.columns.iter().position(|c| c == column)?;
        Some(self.rows.iter().map(|row| row.get(at)?.parse().ok()).collect())
    }

    /// The row that is best by a column: distances (`rms_mm`) are best small, a bias (`length_bias`) best near 0,
    /// everything else best large. The first of equals; `None` if no row has a number there.
    ///
    /// # Errors
    /// Where there is no such column.
    pub fn best(&self, column: &str) -> Result<Option<usize>> {
        let numbers = self.numbers(column).ok_or_else(|| {
            Error::usage(format!("the sweep has no column `{column}`"))
                .help(format!("its columns are {}", self.columns.join(", ")))
        })?;
        let merit = |x: f64| match column {
            c if c.contains("rms") => -x,
            c if c.contains("bias") => -x.abs(),
            _ => x,
        };
        let mut best: Option<(usize, f64)> = None;
        for (n, value) in numbers.into_iter().enumerate() {
            let Some(value) = value.map(merit) else { continue };
            if best.is_none_or(|(_, most)| value > most) {
                best = Some((n, value));
            }
        }
        Ok(best.map(|(n, _)| n))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_row_depends_on_what_the_column_is() {
        let mut table = Table::default();
        for (f1, rms) in [("0.5", "0.4"), ("0.9", "0.3"), ("0.9", ""), ("0.8", "0.2")] {
            table.rows.push(Vec::new());
            table.put("f1_1mm", f1.into());
            table.put("rms_mm", rms.into());
        }
        assert_eq!(table.best("f1_1mm").unwrap(), Some(1));
        assert_eq!(table.best("rms_mm").unwrap(), Some(3));
        assert!(table.best("f2").unwrap_err().help.unwrap().contains("f1_1mm, rms_mm"));
    }

    #[test]
    fn short_rows_are_filled_up() {
        let mut table = Table::default();
        table.rows.push(Vec::new());
        table.put("point", "1".into());
        table.rows.push(Vec::new());
        table.put("point", "2".into());
        table.put("error", "a, b".into());
        assert_eq!(String::from_utf8(table.csv().unwrap()).unwrap(), "point,error\n1,\n2,\"a, b\"\n");
    }
}
