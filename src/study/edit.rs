//! Settings written into a study file: comments, order and everything else of it stay.

use crate::error::{Error, Result};
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

/// The text of the study file `name` with `section.key` settings, whose values are TOML.
///
/// # Errors
/// Where the text or a value is not TOML, or a value stands where a section is needed.
pub fn edited<'a>(name: &str, text: &str, settings: impl IntoIterator<Item = (&'a str, &'a str)>) -> Result<String> {
    let wrong = |e: &dyn std::fmt::Display| Error::usage(format!("`{name}` cannot be changed: {e}"));
    let mut document: DocumentMut = text.parse().map_err(|e| wrong(&e))?;
    for (setting, value) in settings {
        let value: Value = value.parse().map_err(|e| wrong(&e))?;
        let (path, key) = setting.rsplit_once('.').ok_or_else(|| wrong(&format!("`{setting}` names no section")))?;
        let mut section: &mut dyn TableLike = document.as_table_mut();
        for part in path.split('.') {
            let fresh = || {
                let mut table = Table::new();
                table.set_implicit(false);
                Item::Table(table)
            };
            section = section
                .entry(part)
                .or_insert_with(fresh)
                .as_table_like_mut()
                .ok_or_else(|| wrong(&format!("`{part}` of `{setting}` is no section")))?;
        }
        put(section, key, value);
    }
    Ok(document.to_string())
}

/// Sets a value; the space and the comment about an old one stay.
fn put(section: &mut dyn TableLike, key: &str, mut value: Value) {
    match section.get_mut(key).and_then(Item::as_value_mut) {
        Some(old) => {
            *value.decor_mut() = old.decor().clone();
            *old = value;
        }
        None => drop(section.insert(key, Item::Value(value))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STUDY: &str = "# My plant\n[photos]\ndir = \"a\"   # the folder\n\n[extract]\n# strict\nhigh = 1.5 # chosen by eye\nlow=0.5\n\n\
                         [grid]\nspacing = 1.0\n";

    #[test]
    fn only_the_value_changes() {
        let text = edited("a.toml", STUDY, [("extract.high", "2.0")]).unwrap();
        assert_eq!(text, STUDY.replace("1.5", "2.0"));
    }

    #[test]
    fn what_is_not_there_is_added_to_its_section_or_at_the_end() {
        let text = edited("a.toml", STUDY, [("extract.min_length_mm", "4.0"), ("trace.link.reach", "3.0")]).unwrap();
        assert!(text.contains("low=0.5\nmin_length_mm = 4.0\n\n[grid]"), "{text}");
        assert!(text.starts_with(&STUDY[..60]) && text.contains("reach = 3.0"), "{text}");
        let read: toml::Table = text.parse().unwrap();
        assert_eq!(read["trace"]["link"]["reach"].as_float(), Some(3.0));
    }

    #[test]
    fn dotted_keys_and_inline_tables_stay_what_they_are() {
        for study in ["trace.link.reach = 2.0 # wide\n", "[trace]\nlink = { reach = 2.0, angle_deg = 40.0 }\n"] {
            let text = edited("a.toml", study, [("trace.link.reach", "3.5")]).unwrap();
            assert_eq!(text, study.replace("2.0", "3.5"));
        }
    }

    #[test]
    fn what_is_no_section_is_told() {
        let e = edited("a.toml", "trace = 3\n", [("trace.low", "1.0")]).unwrap_err();
        assert!(e.message.contains("`a.toml`") && e.message.contains("no section"), "{e}");
        assert!(edited("a.toml", "= 3", [("trace.low", "1.0")]).is_err());
    }
}
