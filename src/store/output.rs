//! What a node produces, while it is being written.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use ndarray::ArrayViewD;
use serde::Serialize;

use super::array::SlabWriter;
use super::canonical;
use super::digest::Digest;
use super::element::Element;
use super::files;
use super::manifest::{Member, MemberKind};
use crate::error::{Error, Result};

/// Collects the members of an artefact in a private folder; nobody sees them before they are published.
pub struct Output {
    folder: PathBuf,
    started: BTreeSet<String>,
    folders: Vec<String>,
    members: Arc<Mutex<Vec<Member>>>,
    warnings: Vec<String>,
}

impl Output {
    /// Writes into `folder`, which must be new and empty.
    pub(super) fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            started: BTreeSet::new(),
            folders: Vec::new(),
            members: Arc::default(),
            warnings: Vec::new(),
        }
    }

    /// Claims `file` for a member, and gives its path.
    fn begin(&mut self, file: &str) -> Result<PathBuf> {
        if !is_plain(file) {
            return Err(Error::failed(format!(
                "`{file}` cannot name a member: letters, digits, `.`, `_` and `-` can, and no leading `.`"
            )));
        }
        if matches!(file, "manifest.json" | "zarr.json") || !self.started.insert(file.to_owned()) {
            return Err(Error::failed(format!("there is a member `{file}` already")));
        }
        Ok(self.folder.join(file))
    }

    /// Writes a whole array with one dimension name per axis, such as `["z", "y", "x"]`.
    pub fn array<T: Element>(&mut self, name: &str, values: ArrayViewD<'_, T>, dimensions: &[&str]) -> Result<()> {
        let mut writer = self.slabs::<T>(name, values.shape(), dimensions)?;
        writer.push(values)?;
        writer.finish()
    }

    /// Begins an array that is pushed slab by slab along axis 0; several may be open at once.
    pub fn slabs<T: Element>(&mut self, name: &str, shape: &[usize], dimensions: &[&str]) -> Result<SlabWriter<T>> {
        let folder = self.begin(name)?;
        let members = self.members.clone();
        let (name, shape_, folder_) = (name.to_owned(), shape.to_vec(), folder.clone());
        let done = move |digest: Digest| {
            let bytes = files::tree_bytes(&folder_)?;
            let kind = MemberKind::Array;
            push(&members, Member { name, kind, dtype: Some(T::DTYPE), shape: shape_, digest, bytes });
            Ok(())
        };
        SlabWriter::create(&folder, shape, dimensions, Box::new(done))
    }

    /// Writes `value` as JSON.
    pub fn json<V: Serialize>(&mut self, name: &str, value: &V) -> Result<()> {
        let path = self.begin(&format!("{name}.json"))?;
        let value = serde_json::to_value(value).map_err(|e| Error::failed(format!("cannot write `{name}`: {e}")))?;
        let mut text = serde_json::to_vec_pretty(&value).map_err(|e| Error::io("write", &path, e))?;
        text.push(b'\n');
        files::write_synced(&path, &text)?;
        self.member(name, MemberKind::Json, Digest::of(&canonical::bytes(&value)?), text.len() as u64);
        Ok(())
    }

    /// Writes a file, its name with its extension.
    pub fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.begin(name)?;
        files::write_synced(&path, bytes)?;
        self.member(name, MemberKind::Bytes, Digest::of(bytes), bytes.len() as u64);
        Ok(())
    }

    /// Makes an empty folder that the stage fills with files before it returns.
    pub fn folder(&mut self, name: &str) -> Result<PathBuf> {
        let path = self.begin(name)?;
        std::fs::create_dir(&path).map_err(|e| Error::io("create", &path, e))?;
        self.folders.push(name.to_owned());
        Ok(path)
    }

    /// Notes something that the user should know; kept in the manifest and shown again on every hit.
    pub fn warn(&mut self, text: impl Into<String>) {
        self.warnings.push(text.into());
    }

    fn member(&self, name: &str, kind: MemberKind, digest: Digest, bytes: u64) {
        push(&self.members, Member { name: name.to_owned(), kind, dtype: None, shape: Vec::new(), digest, bytes });
    }

    /// Completes the members: they, sorted by name, and the warnings.
    pub(super) fn close(self) -> Result<(Vec<Member>, Vec<String>)> {
        for name in &self.folders {
            let path = self.folder.join(name);
            let (digest, bytes) = files::digest_tree(&path)?;
            self.member(name, MemberKind::Folder, digest, bytes);
        }
        let mut members = std::mem::take(&mut *self.members.lock().unwrap_or_else(PoisonError::into_inner));
        if members.len() != self.started.len() {
            let names: Vec<&str> = members.iter().map(|m| m.name.as_str()).collect();
            let open = self.started.iter().filter(|name| !names.contains(&name.trim_end_matches(".json")));
            let open: Vec<&str> = open.map(String::as_str).collect();
            return Err(Error::failed(format!("the stage left members unfinished: {}", open.join(", "))));
        }
        members.sort_by(|a, b| a.name.cmp(&b.name));
        Ok((members, self.warnings))
    }
}

/// Whether a member may be called so.
pub(super) fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '.' | '_' | '-');
    !name.is_empty() && !name.starts_with('.') && name.chars().all(plain)
}

fn push(members: &Mutex<Vec<Member>>, member: Member) {
    members.lock().unwrap_or_else(PoisonError::into_inner).push(member);
}
