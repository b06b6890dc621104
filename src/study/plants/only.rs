//! `--only COLUMN=VALUE`: some captures of a trial. Of one column any of the values counts, of several columns all.

use crate::error::{Error, Result};

/// One wish.
#[derive(Debug, Clone, PartialEq)]
pub struct Only {
    column: String,
    value: String,
}

impl Only {
    /// Reads `plant=7`.
    ///
    /// # Errors
    /// Where it is not of that form.
    pub fn read(text: &str) -> Result<Self> {
        match text.split_once('=').map(|(column, value)| (column.trim(), value.trim())) {
            Some((column, value)) if !column.is_empty() && !value.is_empty() => {
                Ok(Self { column: column.to_owned(), value: value.to_owned() })
            }
            _ => Err(Error::usage(format!("--only {text}: names no capture")).help("write COLUMN=VALUE, as plant=7")),
        }
    }

    pub(super) fn check<'n>(&self, columns: impl Iterator<Item = &'n str>) -> Result<()> {
        let columns: Vec<&str> = columns.collect();
        if columns.contains(&self.column.as_str()) {
            return Ok(());
        }
        let message = format!("--only {}={}: there is no column `{}`", self.column, self.value, self.column);
        Err(Error::usage(message).help(format!("the columns are {}", columns.join(", "))))
    }

    /// Whether a capture with these values is wanted.
    pub(super) fn all<'v>(only: &[Self], value: impl Fn(&str) -> Option<&'v str>) -> bool {
        let any_of = |column: &str| only.iter().filter(|o| o.column == column).any(|o| value(column) == Some(&o.value));
        only.iter().all(|wanted| any_of(&wanted.column))
    }

    pub(super) fn shown(only: &[Self]) -> String {
        only.iter().map(|o| format!("--only {}={}", o.column, o.value)).collect::<Vec<_>>().join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_one_column_add_up_and_columns_narrow_down() {
        let only: Vec<Only> = ["plant=7", "plant = 8", "date=2"].iter().map(|t| Only::read(t).unwrap()).collect();
        let wanted = |plant: &'static str, date: &'static str| {
            Only::all(&only, |column| Some(if column == "plant" { plant } else { date }))
        };
        assert!(wanted("7", "2") && wanted("8", "2") && !wanted("9", "2") && !wanted("7", "1"));
        assert!(Only::all(&[], |_| None));
        assert!(Only::read("7").is_err() && Only::read("plant=").is_err());
    }
}
