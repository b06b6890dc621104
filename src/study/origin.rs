//! Where a study's file lies, and what was found of the world outside of it.

use super::document::{Resolved, written_but};
use super::inputs::Photos;
use super::photographs::{self, Found};
use super::scale::Scale;
use crate::error::Result;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// What a study's file decides by where it lies.
pub(super) struct Origin {
    /// Name of a study that does not say its own.
    pub name: String,
    /// Folder that `photos.dir` starts from.
    pub base: PathBuf,
    /// Folder that `corrections.file` starts from.
    pub corrections: PathBuf,
    /// What was found of the world outside of the file, by the settings that it was looked for with: the points of a sweep
    /// look once.
    photographs: Mutex<BTreeMap<(PathBuf, String), Found>>,
    scales: Mutex<BTreeMap<String, Scale>>,
}

impl Origin {
    /// A folder named on the command line starts from where the user stands, one named in the file from the file.
    pub fn of(path: &Path, overrides: &[String]) -> Self {
        let start = |setting: &str| {
            let from_command = overrides.iter().any(|o| o.trim_start().starts_with(setting));
            let folder = if from_command { Path::new(".") } else { path.parent().unwrap_or(Path::new(".")) };
            folder.to_owned()
        };
        Self {
            name: path.file_stem().map_or("study".into(), |s| s.to_string_lossy().into()),
            base: start("photos.dir"),
            corrections: start("corrections.file"),
            photographs: Mutex::default(),
            scales: Mutex::default(),
        }
    }

    /// The same with input paths that start from the list of captures, whose folder is `base`.
    pub fn of_list(path: &Path, overrides: &[String], base: &Path) -> Self {
        Self { base: base.to_owned(), ..Self::of(path, overrides) }
    }

    /// As [`photographs::find`].
    pub fn photographs(&self, input_dir: &Path, photos: &Photos) -> Result<Found> {
        let key = (input_dir.to_owned(), photos.images.clone());
        remembered(&self.photographs, key, || photographs::find(input_dir, photos))
    }

    /// The scale of a study with these values, found by `find` the first time.
    pub fn scale(&self, resolved: &Resolved, find: impl FnOnce() -> Result<Scale>) -> Result<Scale> {
        remembered(&self.scales, written_but(resolved, &[MEASURING, SHOWING].concat()), find)
    }
}

/// Sections that decide nothing about the views' volumes and what they are made of.
pub(super) const MEASURING: &[&str] = &[
    "study",
    "merge",
    "rootness",
    "suppress",
    "extract",
    "trace",
    "explain",
    "diameters",
    "hierarchy",
    "follow",
    "recall",
    "corrections",
    "traits",
    "overlay",
];

/// Sections that besides these decide nothing about the voxels' edge.
const SHOWING: &[&str] = &["render", "contrast", "report", "truth"];

/// The value of that key, made the first time.
fn remembered<K: Ord, V: Clone>(known: &Mutex<BTreeMap<K, V>>, key: K, make: impl FnOnce() -> Result<V>) -> Result<V> {
    let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
    match known.entry(key) {
        Entry::Occupied(value) => Ok(value.get().clone()),
        Entry::Vacant(free) => Ok(free.insert(make()?).clone()),
    }
}
