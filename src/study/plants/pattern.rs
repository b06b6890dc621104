//! The list of captures as a pattern of folders: `captures/{genotype}-{plant}/{date:%Y-%m-%d}`.
//!
//! A field stands for one or more characters of a folder's name, as many as the rest of the pattern leaves it; a date may say how it
//! is written. Every folder that fits is a capture.

use super::{Cell, Column, Date, List, Row};
use crate::error::{Error, Result};
use std::path::Path;

/// A part of a pattern.
#[derive(Debug, Clone, PartialEq)]
enum Part {
    Text(String),
    Field { name: String, form: Option<String> },
}

/// The folders below `start` that fit the pattern.
///
/// # Errors
/// A pattern that is none, or that no folder fits.
pub fn read(start: &Path, pattern: &str) -> Result<List> {
    let wrong = |why: &str| {
        Error::usage(format!("plants.folders `{pattern}`: {why}"))
            .help("write fields in braces, such as captures/{genotype}-{plant}/{date:%Y-%m-%d}")
    };
    let parts = parts(pattern).map_err(|why| wrong(&why))?;
    let mut list = List { base: start.to_owned(), ..List::default() };
    for part in &parts {
        if let Part::Field { name, .. } = part {
            let place = format!("plants.folders, field {{{name}}}");
            list.columns.push(Column { name: name.clone(), cell: list.cells.len() });
            list.cells.push(Cell::new(name, place, None));
        }
    }
    list.columns.push(Column { name: "photos".into(), cell: list.cells.len() });
    list.cells.push(Cell::new("photos", "plants.folders".into(), None));
    let escaped = |part: &Part| match part {
        Part::Text(text) => glob::Pattern::escape(text),
        Part::Field { .. } => "*".to_owned(),
    };
    let below = parts.iter().map(escaped).collect::<String>();
    let root = if start.as_os_str().is_empty() { Path::new(".") } else { start };
    let all = format!("{}/{below}", glob::Pattern::escape(&root.display().to_string()));
    let all = if Path::new(&below).is_absolute() { below } else { all };
    let matches = glob::glob(&all).map_err(|e| wrong(&e.to_string()))?;
    for path in matches.flatten().filter(|path| path.is_dir()) {
        let relative = path.strip_prefix(root).unwrap_or(&path);
        let text = relative.to_string_lossy().replace('\\', "/");
        let Some(mut values) = fitted(&parts, &text) else { continue };
        let place = format!("folder `{}`", path.display());
        match dated(&parts, &mut values) {
            Ok(()) => {}
            Err(why) => {
                list.notes.push(format!("{place} is left out: {why}"));
                continue;
            }
        }
        let from = list.cells.len();
        list.cells.extend(values.iter().map(|value| Cell::new(value, place.clone(), None)));
        list.cells.push(Cell::new(&text, place.clone(), None).into_text());
        list.rows.push(Row { place, cells: (from..list.cells.len()).collect() });
    }
    if list.rows.is_empty() {
        let notes: String = list.notes.iter().map(|note| format!("; {note}")).collect();
        return Err(wrong(&format!("no folder below `{}` fits{notes}", root.display())));
    }
    Ok(list)
}

/// Puts dates into one form.
fn dated(parts: &[Part], values: &mut [String]) -> std::result::Result<(), String> {
    let fields = parts.iter().filter_map(|part| match part {
        Part::Field { name, form } => Some((name, form)),
        Part::Text(_) => None,
    });
    for ((name, form), value) in fields.zip(values) {
        if name == "date" {
            *value = Date::read_as(value, form.as_deref())?.text;
        }
    }
    Ok(())
}

/// The pattern in its parts.
fn parts(pattern: &str) -> std::result::Result<Vec<Part>, String> {
    let (mut parts, mut rest) = (Vec::new(), pattern);
    while let Some(open) = rest.find('{') {
        let close = rest[open..].find('}').ok_or("a brace is not closed")? + open;
        if open > 0 {
            parts.push(Part::Text(rest[..open].to_owned()));
        } else if matches!(parts.last(), Some(Part::Field { .. })) {
            return Err("two fields stand side by side".into());
        }
        let inner = &rest[open + 1..close];
        let (name, form) = inner.split_once(':').map_or((inner, None), |(n, f)| (n, Some(f.to_owned())));
        if form.is_some() && name != "date" {
            return Err(format!("only a date has a form, `{name}` has none"));
        }
        if name.is_empty() || name == "photos" {
            return Err(format!("`{{{inner}}}` is no field"));
        }
        parts.push(Part::Field { name: name.to_owned(), form });
        rest = &rest[close + 1..];
    }
    if !rest.is_empty() {
        parts.push(Part::Text(rest.to_owned()));
    }
    Ok(parts)
}

/// The values of the fields where `text` fits; the first field takes as much as it can.
fn fitted(parts: &[Part], text: &str) -> Option<Vec<String>> {
    match parts {
        [] => text.is_empty().then(Vec::new),
        [Part::Text(wanted), rest @ ..] => fitted(rest, text.strip_prefix(wanted.as_str())?),
        [Part::Field { .. }, rest @ ..] => {
            let most = text.find('/').unwrap_or(text.len());
            let ends = text.char_indices().map(|(at, c)| at + c.len_utf8()).filter(|&end| end <= most);
            ends.collect::<Vec<_>>().into_iter().rev().find_map(|end| {
                let mut values = fitted(rest, &text[end..])?;
                values.insert(0, text[..end].to_owned());
                Some(values)
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_take_their_part_of_a_name() {
        let parts = parts("c/{genotype}-{plant}/{date:%Y-%m-%d}").unwrap();
        assert_eq!(fitted(&parts, "c/wild-type-7/2026-05-01").unwrap(), ["wild-type", "7", "2026-05-01"]);
        assert_eq!(fitted(&parts, "c/wild/2026-05-01"), None);
        assert_eq!(fitted(&parts, "c/a-7/2026-05-01/more"), None);
        assert!(super::parts("{plant}{date}").is_err() && super::parts("{plant").is_err());
        assert!(super::parts("{plant:%d}").is_err());
    }

    #[test]
    fn folders_that_fit_are_captures() {
        let dir = tempfile::tempdir().unwrap();
        for name in ["a-1/2026-05-01", "a-1/2026-05-04", "b-2/2026-05-01", "b-2/notes"] {
            std::fs::create_dir_all(dir.path().join("c").join(name)).unwrap();
        }
        let list = read(dir.path(), "c/{genotype}-{plant}/{date:%Y-%m-%d}").unwrap();
        assert_eq!((list.rows.len(), list.notes.len()), (3, 1));
        let texts = |row: usize| list.rows[row].cells.iter().map(|&c| list.cells[c].text.clone()).collect::<Vec<_>>();
        assert_eq!(texts(1), ["a", "1", "2026-05-04", "c/a-1/2026-05-04"]);
        assert!(read(dir.path(), "d/{plant}").is_err());
    }
}
