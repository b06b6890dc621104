//! What a node produced, for reading.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::array::ArrayReader;
use super::canonical;
use super::care::verify::check_member;
use super::digest::Digest;
use super::element::Element;
use super::manifest::{Manifest, Member, MemberKind, digest_of};
use super::virtual_array::VirtualArtefact;
use crate::error::{Error, Result};

enum Place {
    /// A node's folder in the store.
    Folder(PathBuf),
    /// A file of the outside world.
    File(PathBuf),
    /// Computed as it is read.
    Virtual(Arc<VirtualArtefact>),
}

struct Inner {
    name: String,
    members: Vec<Member>,
    place: Place,
}

/// The result of a node: named members, each an array, a JSON value, a file or a folder. Cheap to clone.
#[derive(Clone)]
pub struct Artefact(Arc<Inner>);

impl Artefact {
    /// The artefact in the folder of a node.
    pub(super) fn stored(manifest: &Manifest, folder: PathBuf) -> Self {
        let name = manifest.label.clone();
        Self(Arc::new(Inner { name, members: manifest.members.clone(), place: Place::Folder(folder) }))
    }

    /// A file of the outside world with this content digest; its member is `file`.
    pub fn file(path: &Path, content: Digest, bytes: u64) -> Self {
        let member = Member {
            name: "file".into(),
            kind: MemberKind::Bytes,
            dtype: None,
            shape: Vec::new(),
            digest: content,
            bytes,
        };
        let name = path.display().to_string();
        Self(Arc::new(Inner { name, members: vec![member], place: Place::File(path.to_owned()) }))
    }

    /// An artefact that is computed as it is read; its digests are known to `source` alone.
    pub fn streamed(name: &str, source: Arc<VirtualArtefact>) -> Self {
        let members = source
            .arrays()
            .into_iter()
            .map(|spec| Member {
                name: spec.name,
                kind: MemberKind::Array,
                dtype: Some(spec.dtype),
                shape: spec.shape,
                digest: Digest([0; 32]),
                bytes: 0,
            })
            .collect();
        Self(Arc::new(Inner { name: name.to_owned(), members, place: Place::Virtual(source) }))
    }

    /// Digest over all members.
    pub fn digest(&self) -> Digest {
        digest_of(&self.0.members)
    }

    /// Names of the members.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.0.members.iter().map(|member| member.name.as_str())
    }

    /// The record of each member.
    pub fn members(&self) -> &[Member] {
        &self.0.members
    }

    /// Whether there is a member `name`.
    pub fn has(&self, name: &str) -> bool {
        self.names().any(|n| n == name)
    }

    fn member(&self, name: &str, kind: MemberKind) -> Result<&Member> {
        let found = self.0.members.iter().find(|member| member.name == name && member.kind == kind);
        found.ok_or_else(|| {
            let names: Vec<String> =
                self.0.members.iter().map(|m| format!("{} `{}`", m.kind.as_str(), m.name)).collect();
            Error::failed(format!(
                "`{}` has no {} `{name}`, only {}",
                self.0.name,
                kind.as_str(),
                if names.is_empty() { "nothing".to_owned() } else { names.join(", ") }
            ))
        })
    }

    /// The array `name`, whose elements must be `T`.
    pub fn array<T: Element>(&self, name: &str) -> Result<ArrayReader<T>> {
        let member = self.member(name, MemberKind::Array)?;
        if member.dtype != Some(T::DTYPE) {
            return Err(Error::failed(format!(
                "array `{name}` of `{}` holds {}, not {}",
                self.0.name,
                member.dtype.map_or("nothing", |dtype| dtype.as_str()),
                T::DTYPE.as_str()
            )));
        }
        match &self.0.place {
            Place::Virtual(source) => Ok(ArrayReader::streamed(source.clone(), name, &member.shape)),
            Place::Folder(folder) | Place::File(folder) => {
                let folder = folder.join(name);
                let found = super::files::tree_bytes(&folder).map_err(|e| damaged(&folder, &e.message))?;
                if found != member.bytes {
                    return Err(damaged(&folder, &format!("{found} bytes where {} were written", member.bytes)));
                }
                ArrayReader::open(&folder, &member.shape)
            }
        }
    }

    /// The JSON value `name`.
    pub fn json<D: DeserializeOwned>(&self, name: &str) -> Result<D> {
        let member = self.member(name, MemberKind::Json)?;
        let path = self.place(name)?;
        let text = std::fs::read(&path).map_err(|e| damaged(&path, &e.to_string()))?;
        let value: Value = serde_json::from_slice(&text).map_err(|e| damaged(&path, &e.to_string()))?;
        if Digest::of(&canonical::bytes(&value)?) != member.digest {
            return Err(damaged(&path, "its content is not what was written"));
        }
        // From the text: a value of numbers alone would lose what their letters say.
        serde_json::from_slice(&text).map_err(|e| Error::io("understand", &path, e))
    }

    /// The bytes of the file `name`, compared with their digest.
    pub fn bytes(&self, name: &str) -> Result<Vec<u8>> {
        let member = self.member(name, MemberKind::Bytes)?;
        let path = self.place(name)?;
        let bytes = std::fs::read(&path).map_err(|e| match self.0.place {
            Place::File(_) => Error::io("read", &path, e),
            _ => damaged(&path, &e.to_string()),
        })?;
        if Digest::of(&bytes) == member.digest {
            return Ok(bytes);
        }
        match self.0.place {
            Place::File(_) => Err(Error::failed(format!("`{}` changed while it was being used", path.display()))
                .help("run again when nothing writes to it")),
            _ => Err(damaged(&path, "its content is not what was written")),
        }
    }

    /// Where the file or folder `name` lies, for copying it out; what the store holds is compared with its digest. It must not be
    /// written to.
    pub fn path(&self, name: &str) -> Result<PathBuf> {
        let path = self.place(name)?;
        if let (Place::Folder(folder), Some(member)) = (&self.0.place, self.0.members.iter().find(|m| m.name == name)) {
            check_member(folder, member).map_err(|e| damaged(&path, &e.message))?;
        }
        Ok(path)
    }

    /// Where the member `name` lies.
    fn place(&self, name: &str) -> Result<PathBuf> {
        match &self.0.place {
            Place::File(path) if name == "file" => Ok(path.clone()),
            Place::Folder(folder) => match self.0.members.iter().find(|member| member.name == name) {
                Some(member) if member.kind == MemberKind::Json => Ok(folder.join(format!("{name}.json"))),
                Some(_) => Ok(folder.join(name)),
                None => Err(Error::failed(format!("`{}` has no member `{name}`", self.0.name))),
            },
            _ => Err(Error::failed(format!("`{name}` of `{}` is not stored", self.0.name))),
        }
    }
}

fn damaged(path: &Path, cause: &str) -> Error {
    Error::failed(format!("the store is damaged at `{}`: {cause}", path.display()))
        .help("run `rootvox cache verify`, which can remove what is bad so that it is computed again")
}
