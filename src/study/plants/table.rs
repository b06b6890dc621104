//! The list of captures as a CSV table; commas, semicolons or tabs part the columns, whichever the first line has most of.

use super::{Cell, Column, List, Row};
use crate::error::{Error, Result};
use std::path::Path;

/// Reads the table at `path`.
///
/// # Errors
/// Where it cannot be read or is no CSV table: rows of another length are all named.
pub fn read(path: &Path) -> Result<List> {
    let text = std::fs::read(path).map_err(|e| {
        Error::usage(format!("plants.table: cannot read `{}`: {e}", path.display()))
            .help("a table of captures is a CSV file with the columns plant, photos, and any of date, groups, settings")
    })?;
    let name = path.display().to_string();
    let text = String::from_utf8(text)
        .map_err(|_| Error::usage(format!("`{name}` is no UTF-8 text")).help("save the table as CSV (UTF-8)"))?;
    let mut list = parse(&name, text.trim_start_matches('\u{feff}'))?;
    list.base = path.parent().map(Path::to_owned).unwrap_or_default();
    Ok(list)
}

/// Reads the text of the table `name`.
fn parse(name: &str, text: &str) -> Result<List> {
    let first = text.lines().next().unwrap_or_default();
    let most = |c: &char| first.matches(*c).count();
    let delimiter = [',', ';', '\t'].into_iter().rev().max_by_key(most).unwrap_or(',');
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter as u8)
        .from_reader(text.as_bytes());
    let mut faults = Vec::new();
    let mut list = List { name: name.to_owned(), text: text.to_owned(), ..List::default() };
    for record in reader.records() {
        let record = record.map_err(|e| Error::usage(format!("`{name}` is no CSV table: {e}")))?;
        let (line, start) = record.position().map_or((0, 0), |p| first_of(text, p.line(), p.byte() as usize));
        if record.iter().all(|text| text.trim().is_empty()) {
            continue;
        }
        let is_head = list.columns.is_empty();
        let spots = spots(text, start, &record, delimiter);
        let cell = |n: usize, text: &str, list: &List| {
            let (offset, len) = spots.get(n).copied().unwrap_or((start, 1));
            let title = list.columns.get(n).map(|c| format!(" ({})", c.name)).unwrap_or_default();
            let place = format!("`{name}` line {line}, column {}{title}", offset - start + 1);
            let cell = Cell::new(text, place, Some((offset, len.max(1))));
            if list.columns.get(n).is_some_and(|c| c.name == "photos") { cell.into_text() } else { cell }
        };
        if !is_head && record.len() != list.columns.len() {
            let message = format!(
                "`{name}` line {line}: {} cells where the first line names {} columns",
                record.len(),
                list.columns.len()
            );
            faults.push(Error::usage(message).help("put a text that holds the separator into double quotes"));
            continue;
        }
        let cells: Vec<Cell> = record.iter().enumerate().map(|(n, text)| cell(n, text, &list)).collect();
        let from = list.cells.len();
        if is_head {
            let named = |(n, cell): (usize, &Cell)| Column { name: cell.text.clone(), cell: from + n };
            list.columns = cells.iter().enumerate().map(named).collect();
        } else {
            let place = format!("`{name}` line {line}");
            list.rows.push(Row { place, cells: (from..from + cells.len()).collect() });
        }
        list.cells.extend(cells);
    }
    Error::many(faults)?;
    if list.columns.is_empty() {
        return Err(Error::usage(format!("`{name}` is empty"))
            .help("the first line names the columns: plant, photos, and any of date, groups, settings"));
    }
    Ok(list)
}

/// Line and byte at which a record begins whose reader stood before empty lines.
fn first_of(text: &str, line: u64, start: usize) -> (u64, usize) {
    let empty = text[start..].bytes().take_while(|byte| matches!(byte, b'\r' | b'\n'));
    let (lines, bytes) = empty.fold((0, 0), |(lines, bytes), byte| (lines + u64::from(byte == b'\n'), bytes + 1));
    (line + lines, start + bytes)
}

/// Byte offset and length of each cell; of lines with quotes or tricks all cells stand at its start.
fn spots(text: &str, start: usize, record: &csv::StringRecord, delimiter: char) -> Vec<(usize, usize)> {
    let line = text[start..].lines().next().unwrap_or_default();
    if line.contains('"') || line.split(delimiter).count() != record.len() {
        return vec![(start, line.len()); record.len()];
    }
    let mut at = start;
    line.split(delimiter)
        .map(|cell| {
            let spot = (at + cell.len() - cell.trim_start().len(), cell.trim().len());
            at += cell.len() + delimiter.len_utf8();
            spot
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_know_their_line_and_column() {
        let list = parse("p.csv", "plant;photos;tank.radius\n\n7;a b; 90\n\"8\";c;45\n").unwrap();
        let names: Vec<&str> = list.columns.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["plant", "photos", "tank.radius"]);
        let cell = |row: usize, n: usize| &list.cells[list.rows[row].cells[n]];
        assert_eq!((cell(0, 2).text.as_str(), cell(1, 0).text.as_str()), ("90", "8"));
        assert_eq!(cell(0, 2).place, "`p.csv` line 3, column 8 (tank.radius)");
        assert_eq!(list.rows[1].place, "`p.csv` line 4");
        let (start, len) = cell(0, 2).spot.unwrap();
        assert_eq!(&list.text[start..start + len], "90");
    }

    #[test]
    fn rows_of_another_length_are_named_all_at_once() {
        let e = parse("p.csv", "plant,photos\n1\n2,b\n3,c,d\n").unwrap_err();
        let all: Vec<String> = e.apart().iter().map(|e| e.message.clone()).collect();
        assert_eq!(all.len(), 2, "{all:?}");
        assert!(all[0].contains("line 2") && all[1].contains("line 4"), "{all:?}");
        assert!(parse("p.csv", "").is_err());
    }
}
