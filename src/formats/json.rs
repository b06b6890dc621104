//! Reading JSON with errors that show the line they speak of.

use crate::error::{Error, Excerpt, Result};
use serde::de::DeserializeOwned;

/// Parses `text`, the content of the file `name`.
///
/// # Errors
/// Names file, line and column and shows the line; NaN and infinity, which JSON does not have, get
/// their own remedy.
pub fn parse<T: DeserializeOwned>(name: &str, text: &str) -> Result<T> {
    serde_json::from_str(text).map_err(|e| {
        let (line, column) = (e.line().max(1), e.column().max(1));
        let line_start: usize = text.split_inclusive('\n').take(line - 1).map(str::len).sum();
        let start = (line_start + column - 1).min(text.len());
        let start = (0..=start).rev().find(|&i| text.is_char_boundary(i)).unwrap_or(0);
        let cause = e.to_string();
        let cause = cause.split(" at line ").next().unwrap_or(&cause);
        let rest = text[start..].trim_start_matches(['-', '+']).to_ascii_lowercase();
        let help = if ["nan", "inf"].iter().any(|w| rest.starts_with(w)) {
            "JSON has no NaN or infinity: every number must be finite"
        } else if e.is_eof() {
            "the file ends too early: was it cut off while being copied?"
        } else {
            "see the README for the form of this file"
        };
        Error::failed(format!("`{name}` line {line}, column {column}: {cause}")).help(help).excerpt(Excerpt {
            file: name.to_owned(),
            text: text.to_owned(),
            start,
            len: usize::from(start < text.len()),
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_nan_is_named_with_line_and_column() {
        let e = parse::<Vec<f64>>("cameras.json", "[\n 1.0,\n NaN\n]").unwrap_err();
        assert!(e.message.contains("line 3"), "{e}");
        assert!(e.help.as_ref().is_some_and(|h| h.contains("NaN")), "{e}");
    }

    #[test]
    fn a_truncated_file_is_said_to_be_one() {
        let e = parse::<Vec<f64>>("a.json", "[1, 2").unwrap_err();
        assert!(e.help.as_ref().is_some_and(|h| h.contains("cut off")), "{e}");
        assert!(parse::<Vec<f64>>("a.json", "").is_err());
    }
}
