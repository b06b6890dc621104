//! Nodes that come from a store of packed nodes, and go there.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use super::digest::Key;
use super::manifest::Manifest;
use super::remote::{FOLDER, Pushed, Remote};
use super::{FORMAT, Store};
use crate::error::{Error, Result};

/// The store of packed nodes behind a store, and what it was found to hold.
pub(super) struct Behind {
    remote: Remote,
    known: Mutex<BTreeMap<Key, Manifest>>,
}

impl Store {
    /// Puts another store, such as a lab's, behind this one: what this one does not have is taken from there, and
    /// nothing is written there. `place` is a store's folder, a folder of packed nodes, `https://…` or `s3://…`.
    ///
    /// # Errors
    /// Where there is no store in the folder, or the address cannot be used.
    pub fn over(self, place: &str) -> Result<Self> {
        if !place.contains("://") {
            let behind = Self::look(Path::new(place));
            if behind.exists() {
                return Ok(Self::at(self.home(), self.root().to_owned(), Some(behind), None));
            }
            if !Path::new(place).join(FOLDER).is_dir() {
                return Err(Error::usage(format!("there is no store of format {FORMAT} in `{place}`"))
                    .help("name the folder that another `rootvox run` had as --cache, or one that was pushed to"));
            }
        }
        let behind = Behind { remote: Remote::open(place)?, known: Mutex::default() };
        Ok(Self::at(self.home(), self.root().to_owned(), None, Some(Arc::new(behind))))
    }

    /// The record of a node in the store of packed nodes behind.
    pub(super) fn behind(&self, stage: &str, key: Key) -> Option<Manifest> {
        let behind = self.0.behind.as_ref()?;
        let known = || behind.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(manifest) = known().get(&key) {
            return Some(manifest.clone());
        }
        let manifest = behind.remote.manifest(stage, key)?;
        known().insert(key, manifest.clone());
        Some(manifest)
    }

    /// Whether nodes may have to be fetched from a store far away.
    pub fn is_over_far(&self) -> bool {
        self.0.behind.is_some()
    }

    /// Whether the values of a node found by [`Store::lookup`] have to be fetched before they can be read.
    pub fn is_far(&self, manifest: &Manifest) -> bool {
        let is_near = || self.own(&manifest.stage, manifest.key).is_ok_and(|own| own.is_some_and(|m| !m.is_virtual));
        !manifest.is_virtual && self.is_over_far() && !is_near()
    }

    /// As [`Store::lookup`], of nodes with values only, which are at hand then: fetched and verified if need be.
    ///
    /// # Errors
    /// As [`Store::lookup`], and where the store cannot be written.
    pub fn lookup_values(&self, stage: &str, key: Key) -> Result<Option<Manifest>> {
        let Some(manifest) = self.lookup(stage, key)?.filter(|manifest| !manifest.is_virtual) else { return Ok(None) };
        let Some(behind) = self.0.behind.as_ref().filter(|_| self.is_far(&manifest)) else { return Ok(Some(manifest)) };
        let draft = self.draft()?;
        match behind.remote.fetch(stage, key, &draft.folder) {
            Some(manifest) => self.publish(draft, manifest).map(Some),
            None => {
                behind.known.lock().unwrap_or_else(PoisonError::into_inner).remove(&key);
                Ok(None)
            }
        }
    }

    /// What is to be said of the store behind, since the last time.
    pub fn complaints(&self) -> Vec<String> {
        self.0.behind.as_ref().map(|behind| behind.remote.complaints()).unwrap_or_default()
    }
}

/// A store of packed nodes to push to.
pub struct Destination(Remote);

impl Destination {
    /// `s3://bucket/prefix`, or a folder, made where it is missing.
    ///
    /// # Errors
    /// Where the address cannot be used.
    pub fn open(place: &str) -> Result<Self> {
        if !place.contains("://") {
            std::fs::create_dir_all(Path::new(place).join(FOLDER))
                .map_err(|e| Error::io("create", Path::new(place), e))?;
        }
        Remote::open(place).map(Self)
    }

    /// Pushes a node that `store` itself holds; `None` where it does not.
    ///
    /// # Errors
    /// Where the destination cannot be written.
    pub fn push(&self, store: &Store, stage: &str, key: Key) -> Result<Option<Pushed>> {
        match store.own(stage, key)? {
            Some(_) => self.0.push(stage, key, &store.folder(stage, key)).map(Some),
            None => Ok(None),
        }
    }
}
