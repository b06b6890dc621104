//! A trial in one graph: a study per capture, each with its own photographs and settings.

mod days;
mod gather;
mod page;
pub mod results;
mod tables;
pub mod tried;

use crate::error::{Error, Result};
use crate::flow::NodeId;
use crate::study::batch::Batch;
use crate::study::document::Document;
use crate::study::origin::Origin;
pub use crate::study::plants::Capture;
use crate::study::plants::{Only, Plants, Row};
use crate::study::settings::Settings;
pub use days::Days;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// What the studies of a batch are together.
pub struct Trial {
    /// Name of the folder that holds the results of all captures.
    pub name: String,
    /// Names of the group columns.
    pub groups: Vec<String>,
    /// Who is in the photographs of each study, in the order of the studies.
    pub captures: Vec<Capture>,
    /// What a person should know of how the list was understood.
    pub notes: Vec<String>,
    /// Whether the studies are all captures of the list.
    pub is_whole: bool,
    /// The plants that were photographed on several days.
    pub days: Vec<Days>,
}

impl Trial {
    /// Folder of the results of the trial as a whole, beside those of its captures.
    pub const FOLDER: &str = "trial";

    /// Names of the columns that tell captures apart, as [`Capture::values`] runs.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        ["plant", "date"].into_iter().chain(self.groups.iter().map(String::as_str))
    }

    /// The nodes of plants over days.
    pub fn targets(&self) -> impl Iterator<Item = NodeId> + '_ {
        self.days.iter().map(|days| days.follow)
    }

    /// Adds the captures to the batch, which is empty.
    ///
    /// # Errors
    /// All faults of the list and of the settings of every capture at once; what all captures have, once.
    pub(super) fn add(
        batch: &mut Batch,
        base: &mut Document<'_>,
        plants: &Plants,
        origin: &Origin,
        only: &[Only],
    ) -> Result<Self> {
        if base.take_table("studies").is_some() {
            return Err(Error::usage("[studies] and [plants] cannot stand in one file")
                .help("write one file per trial, or sweep what the studies differ in"));
        }
        let read: Vec<Result<Read<'_>>> =
            plants.captures.par_iter().map(|(_, row)| read(base, plants, *row, origin)).collect();
        let (mut faults, mut sound) = (Faults::new(plants.captures.len()), Vec::new());
        for ((_, row), read) in plants.captures.iter().zip(read) {
            match read {
                Ok(read) => sound.push(read),
                Err(error) => faults.add(&plants.list.rows[*row], error),
            }
        }
        Error::many(plants.faults.iter().cloned().chain(faults.all()).collect())?;
        let mut name = None;
        for ((capture, row), read) in plants.captures.iter().zip(sound) {
            match read {
                Read::Swept(document) => batch.add(document, origin),
                Read::Plain(settings) => batch.add_plain(*settings),
            }
            .map_err(|e| e.at(&plants.list.rows[*row].place))?;
            if let Some(study) = batch.studies.last_mut() {
                // The captures share the name of the trial: what its results are called changes nothing in them.
                name.get_or_insert(std::mem::replace(&mut study.name, capture.name()));
            }
        }
        let captures: Vec<Capture> = plants.captures.iter().map(|(capture, _)| capture.clone()).collect();
        let days = days::add(batch, &captures);
        Ok(Self {
            name: name.unwrap_or_default(),
            groups: plants.groups.clone(),
            captures,
            days,
            notes: plants.list.notes.clone(),
            is_whole: only.is_empty(),
        })
    }
}

/// A capture's study as far as it can be read beside others.
enum Read<'t> {
    Plain(Box<Settings>),
    Swept(Document<'t>),
}

fn read<'t>(base: &Document<'t>, plants: &'t Plants, row: usize, origin: &Origin) -> Result<Read<'t>> {
    let mut document = base.clone();
    plants.lay(row, &mut document);
    match document.has("sweep") {
        true => Ok(Read::Swept(document)),
        false => Ok(Read::Plain(Box::new(Settings::read(document, origin)?))),
    }
}

/// Faults of captures: what several have alike is told once.
struct Faults {
    captures: usize,
    order: Vec<String>,
    /// By message, how many captures have it, and the fault with the place of the first.
    held: BTreeMap<String, (usize, Error)>,
}

impl Faults {
    fn new(captures: usize) -> Self {
        Self { captures, order: Vec::new(), held: BTreeMap::new() }
    }

    fn add(&mut self, row: &Row, error: Error) {
        for fault in error.apart() {
            let message = fault.message.clone();
            let has_place = fault.excerpt.is_some() || message.starts_with("--set") || message.starts_with(&row.place);
            let (held, _) = self.held.entry(message.clone()).or_insert_with(|| {
                self.order.push(message);
                (0, if has_place { fault } else { fault.at(&row.place) })
            });
            *held += 1;
        }
    }

    fn all(mut self) -> Vec<Error> {
        let captures = self.captures;
        let told = |message: String| {
            let (held, mut fault) = self.held.remove(&message)?;
            if held == captures && captures > 1 {
                fault.message = message;
            }
            Some(fault)
        };
        std::mem::take(&mut self.order).into_iter().filter_map(told).collect()
    }
}
