//! `[plants]`: a trial of many plants, many days; each capture is the file's study with its own photographs and settings.
//!
//! ```toml
//! [plants]
//! table = "plants.csv"      # columns plant, photos, and any of date, groups, settings such as tank.radius
//! # or
//! folders = "captures/{genotype}-{plant}/{date:%Y-%m-%d}"
//! ```
//!
//! A column whose name holds a dot is a setting; `plant`, `photos` and `date` are what they say; every other column is a group.
//! `photos` takes the place of `photos.dir`; in a table it starts from the table's folder, a pattern starts from the study file's.
//! A date is a day (`2026-05-01`), a day with a time (`2026-05-01T14:30`), or a number of days (`9`).

mod cell;
mod date;
mod only;
mod pattern;
mod table;

pub(super) use cell::{Cell, value_of};
pub use date::Date;
pub use only::Only;

use super::document::Document;
use crate::error::{Error, Excerpt, Result};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// `[plants]`: where the captures of a trial are listed.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct PlantsSection {
    /// A CSV table, one capture per row; relative to the study file (or to the working folder when given by `--set`).
    table: Option<String>,
    /// A pattern of folders, one capture each, with fields in braces; relative likewise.
    folders: Option<String>,
}

/// A column of the list.
#[derive(Debug, Clone)]
pub(super) struct Column {
    pub name: String,
    /// Place of its name among the cells.
    pub cell: usize,
}

/// One capture of the list.
#[derive(Debug, Clone)]
pub(super) struct Row {
    /// Where it stands, for people.
    pub place: String,
    /// Per column the place of its cell among the cells.
    pub cells: Vec<usize>,
}

/// The list of captures as it stands: texts with their places.
#[derive(Debug, Default)]
pub(super) struct List {
    /// Every text that a fault can be shown at.
    pub cells: Vec<Cell>,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    /// Folder that the photographs' paths start from.
    pub base: PathBuf,
    pub notes: Vec<String>,
    /// Name and text of the file that it stands in, where it is one.
    pub name: String,
    pub text: String,
}

impl List {
    /// What is wrong with a cell.
    pub fn fault(&self, cell: usize, message: &str) -> Error {
        let cell = &self.cells[cell];
        let error = Error::usage(format!("{}: {message}", cell.place));
        match cell.spot {
            Some((start, len)) => {
                error.excerpt(Excerpt { file: self.name.clone(), text: self.text.clone(), start, len })
            }
            None => error,
        }
    }
}

/// Who is in a capture's photographs.
#[derive(Debug, Clone, PartialEq)]
pub struct Capture {
    /// The plant.
    pub plant: String,
    /// When it was photographed, where the list says so.
    pub date: Option<Date>,
    /// Its value of each group column.
    pub groups: Vec<String>,
}

impl Capture {
    /// Name of its results folder: `7-2026-05-01`.
    pub fn name(&self) -> String {
        match &self.date {
            Some(date) => format!("{}-{}", self.plant, date.text.replace(':', "")),
            None => self.plant.clone(),
        }
    }

    /// Plant, date (empty where there is none) and groups.
    pub fn values(&self) -> Vec<String> {
        let date = self.date.as_ref().map(|date| date.text.clone()).unwrap_or_default();
        [self.plant.clone(), date].into_iter().chain(self.groups.iter().cloned()).collect()
    }

    /// For people: `plant 7, 2026-05-01`.
    pub fn title(&self) -> String {
        match &self.date {
            Some(date) => format!("plant {}, {}", self.plant, date.text),
            None => format!("plant {}", self.plant),
        }
    }
}

/// The captures of a trial, checked.
pub(super) struct Plants {
    pub list: List,
    /// Names of the group columns.
    pub groups: Vec<String>,
    /// The captures with their rows, in the order of the list.
    pub captures: Vec<(Capture, usize)>,
    /// Everything that is wrong with the list itself.
    pub faults: Vec<Error>,
}

impl Plants {
    /// Takes the section out of the document and reads the list that it names; `None` where there is none.
    ///
    /// # Errors
    /// A section that names no list, or a list that cannot be read at all.
    pub fn take(document: &mut Document<'_>, start: &Path, overrides: &[String]) -> Result<Option<Self>> {
        if !document.has("plants") {
            return Ok(None);
        }
        let section: PlantsSection = document.section("plants");
        document.forget("plants");
        let from_command = |key: &str| overrides.iter().any(|o| o.trim_start().starts_with(key));
        let folder = |key: &str| if from_command(key) { Path::new(".") } else { start };
        let list = match (&section.table, &section.folders) {
            (Some(table), None) => table::read(&folder("plants.table").join(table))?,
            (None, Some(pattern)) => pattern::read(folder("plants.folders"), pattern)?,
            // What is wrong inside the section is told with the rest of the file.
            _ => {
                document.failed()?;
                return Err(Error::usage("[plants] names the captures by `table` or by `folders`, one of them")
                    .help("write table = \"plants.csv\", or folders = \"captures/{plant}/{date:%Y-%m-%d}\""));
            }
        };
        Self::of(list, document.has("simulate")).map(Some)
    }

    /// Sorts out plants, dates and groups.
    fn of(list: List, simulated: bool) -> Result<Self> {
        let find = |name: &str| list.columns.iter().position(|c| c.name == name);
        let Some(plant_at) = find("plant") else {
            let names: Vec<String> = list.columns.iter().map(|c| format!("`{}`", c.name)).collect();
            let place = list.columns.first().map_or_else(String::new, |c| list.cells[c.cell].place.clone());
            return Err(Error::usage(format!("{place}: there is no column `plant`, only {}", names.join(", ")))
                .help("the first line names the columns: plant, photos, and any of date, groups, settings"));
        };
        let simulated = simulated || list.columns.iter().any(|c| c.name.starts_with("simulate."));
        let mut faults = Vec::new();
        if find("photos").is_none() && find("photos.dir").is_none() && !simulated {
            let place = &list.cells[list.columns[plant_at].cell].place;
            faults.push(
                Error::usage(format!("{place}: there is no column `photos`"))
                    .help("it names the folder of each capture, relative to the table"),
            );
        }
        for (n, column) in list.columns.iter().enumerate() {
            if column.name.is_empty() {
                faults.push(list.fault(column.cell, "a column without a name"));
            } else if list.columns[..n].iter().any(|c| c.name == column.name) {
                faults.push(list.fault(column.cell, &format!("a second column `{}`", column.name)));
            }
        }
        let of_group = |c: &&Column| !c.name.contains('.') && !["plant", "photos", "date"].contains(&c.name.as_str());
        let groups: Vec<String> = list.columns.iter().filter(of_group).map(|c| c.name.clone()).collect();
        let group_at: Vec<usize> = groups.iter().filter_map(|g| find(g)).collect();
        let (mut captures, mut known) = (Vec::<(Capture, usize)>::new(), BTreeMap::<String, usize>::new());
        for (n, row) in list.rows.iter().enumerate() {
            let text = |at: usize| &list.cells[row.cells[at]].text;
            let mut refuse = |at: usize, message: &str, help: &str| {
                faults.push(list.fault(row.cells[at], message).help(help));
            };
            let plant = text(plant_at).clone();
            if !names_a_folder(&plant) {
                let message = format!("`{plant}` cannot name a plant");
                refuse(plant_at, &message, "use letters, digits, `-`, `_` and `.`; not `trial`");
                continue;
            }
            let date = match find("date").map(|at| (at, Date::read(text(at)))) {
                None => None,
                Some((_, Ok(date))) => Some(date),
                Some((at, Err(why))) => {
                    refuse(at, &why, "write 2026-05-01, 2026-05-01T14:30 or a number of days");
                    continue;
                }
            };
            let groups = group_at.iter().map(|&at| text(at).clone()).collect();
            let capture = Capture { plant, date, groups };
            if let Some(first) = known.insert(capture.name(), n) {
                let message = format!("{} is in {} already", capture.title(), list.rows[first].place);
                refuse(plant_at, &message, "one capture per plant and date");
            }
            captures.push((capture, n));
        }
        if list.rows.is_empty() {
            faults.push(Error::usage("the list of captures is empty").at("[plants]"));
        }
        Ok(Self { list, groups, captures, faults })
    }

    /// Leaves the captures that `only` names.
    ///
    /// # Errors
    /// Where no capture is left, or there is no such column.
    pub fn keep(&mut self, only: &[Only]) -> Result<()> {
        let list = &self.list;
        for wanted in only {
            wanted.check(list.columns.iter().map(|c| c.name.as_str()))?;
        }
        let value = |row: usize, column: &str| {
            let at = list.columns.iter().position(|c| c.name == column)?;
            Some(list.cells[list.rows[row].cells[at]].text.as_str())
        };
        self.captures.retain(|(_, row)| Only::all(only, |column| value(*row, column)));
        match self.captures.is_empty() && self.faults.is_empty() {
            true => Err(Error::usage(format!("no capture is left by {}", Only::shown(only)))
                .help("name a plant of the list, such as --only plant=7")),
            false => Ok(()),
        }
    }

    /// Lays the settings of a row over the document.
    pub fn lay<'t>(&'t self, row: usize, document: &mut Document<'t>) {
        document.know(&self.list);
        for (column, &cell) in self.list.columns.iter().zip(&self.list.rows[row].cells) {
            let parameter = match column.name.as_str() {
                "photos" => "photos.dir",
                name if name.contains('.') => name,
                _ => continue,
            };
            document.set_cell(parameter, column.cell, cell);
        }
    }
}

/// Whether a folder can be called so, beside that of the trial.
fn names_a_folder(name: &str) -> bool {
    let sound = |c: char| c.is_alphanumeric() || "-_.".contains(c);
    !name.is_empty() && !name.starts_with('.') && name != "trial" && name.chars().all(sound)
}
