//! A text of the list of captures: what it says as TOML, and where it stands.

use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// One text with its place.
#[derive(Debug, Clone)]
pub struct Cell {
    /// The text as it stands.
    pub text: String,
    /// The text as a value of TOML.
    toml: String,
    /// Its place, for people: `plants.csv` line 3, column 14 (tank.radius).
    pub place: String,
    /// Where it stands in the text of the list: offset and length in bytes.
    pub spot: Option<(usize, usize)>,
}

impl Cell {
    /// The text at a place.
    pub fn new(text: &str, place: String, spot: Option<(usize, usize)>) -> Self {
        let text = text.trim();
        // TOML wants figures on both sides of the point, people do not.
        let number = text.parse::<f64>().ok().filter(|n| n.is_finite());
        let toml = match number {
            Some(number) if DeValue::parse(text).is_err() => format!("{number:?}"),
            _ if !text.is_empty() && DeValue::parse(text).is_ok() => text.to_owned(),
            _ => toml::Value::String(text.to_owned()).to_string(),
        };
        Self { text: text.to_owned(), toml, place, spot }
    }

    /// The cell as a text whatever it looks like: a folder may be called `7`.
    pub fn into_text(mut self) -> Self {
        self.toml = toml::Value::String(self.text.clone()).to_string();
        self
    }
}

/// The cell's value, all of it at `span`.
pub fn value_of<'t>(cell: &'t Cell, span: &Range<usize>) -> Spanned<DeValue<'t>> {
    match DeValue::parse(&cell.toml) {
        Ok(value) => placed(value.into_inner(), span),
        Err(_) => Spanned::new(span.clone(), DeValue::String(cell.text.as_str().into())),
    }
}

fn placed<'t>(value: DeValue<'t>, span: &Range<usize>) -> Spanned<DeValue<'t>> {
    let value = match value {
        DeValue::Array(items) => {
            let items = items.iter().map(|item| placed(item.get_ref().clone(), span));
            DeValue::Array(items.collect::<DeArray<'t>>())
        }
        DeValue::Table(table) => {
            let of = |(key, value): (Spanned<_>, Spanned<DeValue<'t>>)| {
                (Spanned::new(span.clone(), key.into_inner()), placed(value.into_inner(), span))
            };
            DeValue::Table(table.into_iter().map(of).collect::<DeTable<'t>>())
        }
        value => value,
    };
    Spanned::new(span.clone(), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_values_of_toml_or_strings() {
        let read = |text: &str| {
            let cell = Cell::new(text, String::new(), None);
            let value = value_of(&cell, &(7..8));
            assert_eq!(value.span(), 7..8);
            match value.into_inner() {
                DeValue::Array(items) => {
                    assert!(items.iter().all(|item| item.span() == (7..8)));
                    format!("array of {}", items.len())
                }
                DeValue::String(text) => format!("text {text}"),
                other => other.type_str().to_owned(),
            }
        };
        assert_eq!(read(" 90 "), "integer");
        assert_eq!(read(".5"), "float");
        assert_eq!(read("sfm"), "text sfm");
        assert_eq!(read("90 mm"), "text 90 mm");
        assert_eq!(read("[[0.0, 8.0], [62.0, 70.0]]"), "array of 2");
        assert_eq!(read(""), "text ");
    }
}
