//! Pins: nodes that cleaning leaves alone, named after the study that needs them.
//!
//! `pins/<name>.json` holds the keys of one pin.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::PathBuf;

use crate::error::{Error, Result};
use crate::store::digest::Key;
use crate::store::{Store, files, holder};

impl Store {
    fn pin_file(&self, name: &str) -> Result<PathBuf> {
        if name.is_empty() || name.starts_with('.') || name.contains(['/', '\\']) {
            return Err(Error::usage(format!("`{name}` cannot name a pin")).help("use letters, digits, `-` and `_`"));
        }
        Ok(self.root().join("pins").join(format!("{name}.json")))
    }

    /// Keeps cleaning away from the nodes with these keys, in place of those that the pin held before.
    ///
    /// # Errors
    /// Where the pin cannot be written.
    pub fn pin(&self, name: &str, keys: &BTreeSet<Key>) -> Result<()> {
        let path = self.pin_file(name)?;
        let text = serde_json::to_vec_pretty(keys).map_err(|e| Error::failed(format!("pin `{name}`: {e}")))?;
        let folder = self.root().join("pins");
        std::fs::create_dir_all(&folder).map_err(|e| Error::io("create", &folder, e))?;
        let write = || -> std::io::Result<()> {
            // In the folder that is swept, should this process die.
            let mut fresh = files::shared_files().prefix(&holder::tag()).tempfile_in(self.root().join("tmp"))?;
            fresh.write_all(&text)?;
            fresh.as_file().sync_all()?;
            fresh.persist(&path)?;
            Ok(())
        };
        write().map_err(|e| Error::io("write", &path, e))
    }

    /// Removes a pin.
    ///
    /// # Errors
    /// Where there is none of that name.
    pub fn unpin(&self, name: &str) -> Result<()> {
        let path = self.pin_file(name)?;
        std::fs::remove_file(&path).map_err(|e| match e.kind() {
            std::io::ErrorKind::NotFound => {
                Error::usage(format!("there is no pin `{name}`")).help("`rootvox cache pins` lists them")
            }
            _ => Error::io("remove", &path, e),
        })
    }

    /// All pins by name.
    ///
    /// # Errors
    /// Where one cannot be read: then it is not known what must stay.
    pub fn pins(&self) -> Result<BTreeMap<String, BTreeSet<Key>>> {
        let mut pins = BTreeMap::new();
        for (name, path) in files::tree(&self.root().join("pins"))? {
            let Some(name) = name.strip_suffix(".json").filter(|name| !name.starts_with('.')) else { continue };
            let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
            let keys = serde_json::from_slice(&text)
                .map_err(|e| Error::io("understand", &path, e).help("remove it, or pin the study again"))?;
            pins.insert(name.to_owned(), keys);
        }
        Ok(pins)
    }
}
