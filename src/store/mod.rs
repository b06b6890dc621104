//! The cache on disk: every node's result under the name of the work that made it.
//!
//! ```text
//! cache/                          any folder; `CACHEDIR.TAG` keeps it out of backups, `.gitignore` out of git
//! └── v1/                         version of the layout; another version is another folder
//!     ├── nodes/
//!     │   └── merge/              one folder per stage
//!     │       └── 4be1…/          one per key (64 hexadecimal letters); a Zarr group where it holds arrays
//!     │           ├── manifest.json   who made it from what; present means complete
//!     │           ├── zarr.json
//!     │           ├── merged/         a member: array `merged`
//!     │           └── summary.json    a member: JSON value `summary`
//!     ├── history/merge.jsonl     one line per run, for estimates and for `why`; may be lost without harm
//!     ├── failures/               what failed where and why, one file per node; gone once it succeeds
//!     ├── files.json              digests of input files, by path, size, times and inode; may be lost without harm
//!     ├── pins/                   keys that cleaning leaves alone, one file per pin
//!     ├── in-use.lock             shared by runs; cleaning wants it alone
//!     ├── locks/                  one file per node being computed; a courtesy, correctness does not rest on it
//!     └── tmp/                    results being written, one folder per process; swept when the process is gone
//! ```
//!
//! A node is written in `tmp/`, brought to the disk, and published by one rename; so a reader sees all of it or
//! nothing, whenever the writer dies. A rename onto an existing node means that somebody else published the same
//! work first, which is success.

mod array;
mod artefact;
mod canonical;
pub mod care;
mod claim;
mod digest;
mod element;
mod failure;
mod files;
mod free;
mod heart;
mod history;
mod holder;
mod manifest;
mod object;
mod output;
mod remember;
mod remote;
mod session;
mod share;
#[cfg(test)]
mod tests;
mod usage;
mod virtual_array;

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

pub use array::{ArrayReader, SlabWriter};
pub use artefact::Artefact;
pub use canonical::bytes as canonical_bytes;
pub use claim::{Claim, Held};
pub use digest::{ArrayHasher, Digest, Key};
pub use element::{Dtype, Element};
pub use failure::Failure;
pub use files::{leads_inside, shared_files, tree};
pub use free::{write_array, write_group};
pub use history::Past;
pub use holder::{Holder, is_left_over, tag as process_tag};
pub use manifest::{FORMAT, InputRecord, Manifest, Member, MemberKind, Params, digest_of};
pub use output::Output;
pub use remote::Pushed;
pub use share::Destination;
pub use usage::InUse;
pub use virtual_array::{ArraySpec, Slab, SlabSource, VirtualArtefact};

use crate::error::{Error, Result};
use claim::Claims;
use heart::Heart;
use remember::FileMemory;
use session::Session;
use share::Behind;

/// A store on disk. Cheap to clone; safe to share between threads and processes.
#[derive(Clone)]
pub struct Store(Arc<Inner>);

struct Inner {
    /// The folder that the user named.
    home: PathBuf,
    /// Its part of this layout's version.
    root: PathBuf,
    /// Where to look for what is not here; never written to.
    upstream: Option<Store>,
    /// Packed nodes to look for what is not here; never written to.
    behind: Option<Arc<Behind>>,
    session: Mutex<Option<Arc<Session>>>,
    heart: Arc<Heart>,
    claims: Claims,
    memory: Mutex<FileMemory>,
}

/// A result being written.
pub struct Draft {
    /// Where the stage writes.
    pub output: Output,
    folder: PathBuf,
    /// Keeps the process's folder of drafts from being swept.
    _session: Arc<Session>,
}

impl Drop for Draft {
    fn drop(&mut self) {
        // After publishing there is nothing left to remove.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

impl Store {
    /// Opens the store in the folder `home`, making it where it is missing.
    ///
    /// A store that cannot be written opens all the same if it is there: what it holds can be read.
    pub fn open(home: &Path) -> Result<Self> {
        let root = home.join(format!("v{FORMAT}"));
        if !root.join("nodes").is_dir() {
            let make = || -> std::io::Result<()> {
                for folder in ["nodes", "history", "locks", "tmp"] {
                    std::fs::create_dir_all(root.join(folder))?;
                }
                for (name, text) in [("CACHEDIR.TAG", CACHEDIR_TAG), (".gitignore", "*\n")] {
                    if !home.join(name).exists() {
                        std::fs::write(home.join(name), text)?;
                    }
                }
                Ok(())
            };
            make().map_err(|e| {
                Error::io("make a store in", home, e)
                    .help("name a folder that can be written with `--cache FOLDER` or ROOTVOX_CACHE")
            })?;
        }
        session::sweep(&root.join("tmp"));
        claim::sweep(&root.join("locks"));
        Ok(Self::at(home, root, None, None))
    }

    /// Opens the store in the folder `home` without making anything: where there is none, nothing is found.
    pub fn look(home: &Path) -> Self {
        Self::at(home, home.join(format!("v{FORMAT}")), None, None)
    }

    /// Whether there is a store of this format in the folder.
    pub fn exists(&self) -> bool {
        self.root().join("nodes").is_dir()
    }

    fn at(home: &Path, root: PathBuf, upstream: Option<Self>, behind: Option<Arc<Behind>>) -> Self {
        let memory = Mutex::new(FileMemory::load(&root.join("files.json")));
        let heart = Arc::new(Heart::default());
        let claims = Claims::new(root.join("locks"), heart.clone());
        Self(Arc::new(Inner {
            home: home.to_owned(),
            root,
            upstream,
            behind,
            session: Mutex::default(),
            heart,
            claims,
            memory,
        }))
    }

    /// The folder that the store was opened with.
    pub fn home(&self) -> &Path {
        &self.0.home
    }

    fn root(&self) -> &Path {
        &self.0.root
    }

    /// Folder of the node of `stage` with this key, whether it is there or not.
    pub fn folder(&self, stage: &str, key: Key) -> PathBuf {
        self.0.root.join("nodes").join(stage).join(key.to_string())
    }

    /// The manifest of a node; `None` if neither the store nor the one behind it has it.
    ///
    /// # Errors
    /// Where the manifest cannot be read. A node behind that cannot be read counts as missing.
    pub fn lookup(&self, stage: &str, key: Key) -> Result<Option<Manifest>> {
        let own = self.own(stage, key)?;
        let Some(upstream) = self.0.upstream.as_ref().filter(|_| own.as_ref().is_none_or(|m| m.is_virtual)) else {
            return Ok(match own {
                Some(own) if !own.is_virtual => Some(own),
                own => self.behind(stage, key).filter(|m| own.is_none() || !m.is_virtual).or(own),
            });
        };
        let theirs = upstream.lookup(stage, key).ok().flatten();
        Ok(theirs.filter(|m| own.is_none() || !m.is_virtual).or(own))
    }

    /// The manifest of a node in this store itself.
    fn own(&self, stage: &str, key: Key) -> Result<Option<Manifest>> {
        let path = self.folder(stage, key).join("manifest.json");
        match std::fs::read(&path) {
            // A record that is damaged, or of another node, says nothing: the node is computed again and takes its place.
            Ok(text) => {
                Ok(serde_json::from_slice(&text).ok().filter(|m: &Manifest| m.stage == stage && m.is_sound(key)))
            }
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
            Err(e) => Err(Error::io("read", &path, e)),
        }
    }

    /// The artefact of a node found by [`Store::lookup`].
    pub fn artefact(&self, manifest: &Manifest) -> Result<Artefact> {
        if manifest.is_virtual {
            return Err(Error::failed(format!("the values of `{}` are not stored", manifest.label)));
        }
        let (stage, key) = (&manifest.stage, manifest.key);
        match &self.0.upstream {
            Some(upstream) if self.own(stage, key)?.is_none_or(|own| own.is_virtual) => upstream.artefact(manifest),
            _ => Ok(Artefact::stored(manifest, self.folder(stage, key))),
        }
    }

    /// Begins a result in a private folder.
    pub fn draft(&self) -> Result<Draft> {
        let session = {
            let mut current = self.0.session.lock().unwrap_or_else(PoisonError::into_inner);
            match &*current {
                Some(session) => session.clone(),
                None => current.insert(Arc::new(Session::begin(&self.root().join("tmp"), &self.0.heart)?)).clone(),
            }
        };
        let folder = session.new_folder()?;
        Ok(Draft { output: Output::new(&folder), folder, _session: session })
    }

    /// Completes `draft`, filling members, digest and warnings into `record`.
    pub fn close(&self, draft: &mut Draft, record: &mut Manifest) -> Result<()> {
        let output = std::mem::replace(&mut draft.output, Output::new(&draft.folder));
        (record.members, record.warnings) = output.close()?;
        record.digest = digest_of(&record.members);
        Ok(())
    }

    /// Publishes a closed draft under the key in `record` by one rename, and tells what the store then holds.
    ///
    /// If the store has the node already, with its values, that one stays.
    pub fn publish(&self, draft: Draft, record: Manifest) -> Result<Manifest> {
        if record.members.iter().any(|member| member.kind == MemberKind::Array) && !record.is_virtual {
            let group = b"{\n  \"zarr_format\": 3,\n  \"node_type\": \"group\",\n  \"attributes\": {}\n}\n";
            files::write_synced(&draft.folder.join("zarr.json"), group)?;
        }
        for member in record.members.iter().filter(|member| !record.is_virtual && member.kind != MemberKind::Json) {
            let path = draft.folder.join(&member.name);
            if member.kind != MemberKind::Bytes && files::tree_bytes(&path)? != member.bytes {
                return Err(Error::failed(format!("`{}` changed after it was written", path.display())));
            }
            if member.kind == MemberKind::Folder {
                for (_, file) in files::tree(&path)? {
                    let synced = std::fs::File::open(&file).and_then(|file| file.sync_all());
                    synced.map_err(|e| Error::io("write", &file, e))?;
                }
            }
        }
        let mut text = serde_json::to_vec_pretty(&record)
            .map_err(|e| Error::failed(format!("cannot write the manifest of `{}`: {e}", record.label)))?;
        text.push(b'\n');
        files::write_synced(&draft.folder.join("manifest.json"), &text)?;
        files::sync_folder(&draft.folder);

        let target = self.folder(&record.stage, record.key);
        let shelf = self.root().join("nodes").join(&record.stage);
        std::fs::create_dir_all(&shelf).map_err(|e| Error::io("create", &shelf, e))?;
        let mut renamed = std::fs::rename(&draft.folder, &target);
        if renamed.is_err() && target.exists() {
            let held = self.own(&record.stage, record.key);
            match held {
                Ok(Some(held)) if record.is_virtual || !held.is_virtual => return Ok(held),
                _ => {
                    // What lies there has no values or cannot be read: ours takes its place.
                    let aside = draft.folder.with_extension("old");
                    let _ = std::fs::rename(&target, &aside);
                    renamed = std::fs::rename(&draft.folder, &target);
                    let _ = std::fs::remove_dir_all(&aside);
                }
            }
        }
        renamed.map_err(|e| Error::io("publish", &target, e))?;
        files::sync_folder(&shelf);
        Ok(record)
    }

    /// Digest and length of a file of the outside world, remembered while the file stays as it is.
    pub fn file_digest(&self, path: &Path) -> Result<(Digest, u64)> {
        remember::file_digest(&self.0.memory, path)
    }

    /// Keeps what [`Store::file_digest`] learned for the next process; a store that cannot be written forgets.
    pub fn remember_files(&self) {
        let mut memory = self.0.memory.lock().unwrap_or_else(PoisonError::into_inner);
        memory.save(&self.root().join("files.json"));
    }

    /// Adds a run to the history; it took `seconds` with publishing.
    pub fn record_history(&self, record: &Manifest, seconds: f64) {
        history::append(&self.root().join("history"), record, seconds);
    }

    /// The latest earlier runs of `stage`, as [`Store::history`].
    pub fn latest_history(&self, stage: &str) -> Vec<Past> {
        let mut past = self.0.upstream.as_ref().map(|upstream| upstream.latest_history(stage)).unwrap_or_default();
        past.extend(history::read_latest(&self.root().join("history"), stage));
        past
    }

    /// Earlier runs of `stage`, oldest first, those of the store behind before all others.
    pub fn history(&self, stage: &str) -> Vec<Past> {
        let mut past = self.0.upstream.as_ref().map(|upstream| upstream.history(stage)).unwrap_or_default();
        past.extend(history::read(&self.root().join("history"), stage));
        past
    }
}

const CACHEDIR_TAG: &str = "Signature: 8a477f597d28d172789f06886806bc55\n\
# This folder is a cache: everything in it can be computed again. See https://bford.info/cachedir/\n";
