//! Reading everything again and comparing it with its digests.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;

use crate::error::{Error, Result};
use crate::store::array::ArrayReader;
use crate::store::digest::{ArrayHasher, Digest, Key};
use crate::store::element::{Dtype, Element};
use crate::store::manifest::{FORMAT, Manifest, Member, MemberKind, digest_of};
use crate::store::virtual_array::ArraySpec;
use crate::store::{Store, canonical, files};

/// A node that is not what its manifest says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Bad {
    /// Its folder.
    pub folder: PathBuf,
    /// Its key, as the folder is called.
    pub key: Option<Key>,
    /// What is wrong.
    pub cause: String,
}

/// What a verification found.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Verdict {
    /// Nodes read.
    pub nodes: usize,
    /// Bytes read.
    pub bytes: u64,
    /// Nodes that are damaged.
    pub bad: Vec<Bad>,
    /// How many of them were removed, so that they are computed again when asked for.
    pub removed: usize,
}

impl Store {
    /// Reads every node and recomputes its digests; damaged nodes are removed if `remove` says so. `step` is called
    /// after each node with the nodes done and in all; an error from it stops the work.
    ///
    /// # Errors
    /// Where the store cannot be listed, or a damaged node cannot be removed.
    pub fn verify(&self, remove: bool, step: &(dyn Fn(usize, usize) -> Result<()> + Sync)) -> Result<Verdict> {
        let _alone = if remove { Some(self.claim_alone()?) } else { None };
        let folders = self.node_folders()?;
        let done = std::sync::atomic::AtomicUsize::new(0);
        let check = |folder: &PathBuf| -> Result<(u64, Option<Bad>)> {
            let found = match key_of(folder) {
                Some(key) => check_node(folder, &stage_of(folder), key),
                None => Err(Error::failed("its folder is not named after a key")),
            };
            step(done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1, folders.len())?;
            Ok(match found {
                Ok(bytes) => (bytes, None),
                Err(error) => (0, Some(Bad { folder: folder.clone(), key: key_of(folder), cause: error.message })),
            })
        };
        let checked = folders.par_iter().map(check).collect::<Result<Vec<_>>>()?;
        let mut verdict = Verdict { nodes: checked.len(), ..Verdict::default() };
        for (bytes, bad) in checked {
            verdict.bytes += bytes;
            verdict.bad.extend(bad);
        }
        if remove {
            for bad in &verdict.bad {
                self.discard(&bad.folder)?;
                verdict.removed += 1;
            }
        }
        Ok(verdict)
    }
}

/// The key that a node's folder is named after.
fn key_of(folder: &Path) -> Option<Key> {
    folder.file_name().and_then(|name| name.to_str()).and_then(Digest::parse)
}

/// The stage whose nodes lie beside this one.
fn stage_of(folder: &Path) -> String {
    folder.parent().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Bytes of the sound node `stage`, `key` in `folder`, or what is wrong with it.
pub(in crate::store) fn check_node(folder: &Path, stage: &str, key: Key) -> Result<u64> {
    let path = folder.join("manifest.json");
    let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
    let manifest: Manifest = serde_json::from_slice(&text).map_err(|e| Error::io("understand", &path, e))?;
    if manifest.format != FORMAT || manifest.key != key || manifest.stage != stage {
        return Err(Error::failed("the manifest belongs to another node"));
    }
    if digest_of(&manifest.members) != manifest.digest {
        return Err(Error::failed("the digests of the members do not add up to that of the node"));
    }
    let mut expected: BTreeSet<String> = BTreeSet::from(["manifest.json".to_owned()]);
    if !manifest.is_virtual {
        for member in &manifest.members {
            check_member(folder, member).map_err(|e| e.at(format!("member `{}`", member.name)))?;
            let json = member.kind == MemberKind::Json;
            expected.insert(if json { format!("{}.json", member.name) } else { member.name.clone() });
            if member.kind == MemberKind::Array {
                expected.insert("zarr.json".to_owned());
            }
        }
    }
    for entry in std::fs::read_dir(folder).map_err(|e| Error::io("list", folder, e))?.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if !expected.contains(&name) {
            return Err(Error::failed(format!("`{name}` does not belong there")));
        }
    }
    Ok(manifest.bytes())
}

/// Fails where a member in the folder of its node is not what was written.
pub(in crate::store) fn check_member(folder: &Path, member: &Member) -> Result<()> {
    let path = folder.join(&member.name);
    let (digest, bytes) = match member.kind {
        MemberKind::Bytes => files::digest_file(&path)?,
        MemberKind::Folder => files::digest_tree(&path)?,
        MemberKind::Json => {
            let path = folder.join(format!("{}.json", member.name));
            let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
            let value: serde_json::Value =
                serde_json::from_slice(&text).map_err(|e| Error::io("understand", &path, e))?;
            (Digest::of(&canonical::bytes(&value)?), text.len() as u64)
        }
        MemberKind::Array => {
            let digest = match member.dtype.ok_or_else(|| Error::failed("it has no data type"))? {
                Dtype::Uint8 => array_digest::<u8>(&path, member),
                Dtype::Uint16 => array_digest::<u16>(&path, member),
                Dtype::Uint32 => array_digest::<u32>(&path, member),
                Dtype::Uint64 => array_digest::<u64>(&path, member),
                Dtype::Int8 => array_digest::<i8>(&path, member),
                Dtype::Int16 => array_digest::<i16>(&path, member),
                Dtype::Int32 => array_digest::<i32>(&path, member),
                Dtype::Int64 => array_digest::<i64>(&path, member),
                Dtype::Float32 => array_digest::<f32>(&path, member),
                Dtype::Float64 => array_digest::<f64>(&path, member),
            }?;
            (digest, files::tree_bytes(&path)?)
        }
    };
    if bytes != member.bytes {
        return Err(Error::failed(format!("it takes {bytes} bytes where {} were written", member.bytes)));
    }
    if digest != member.digest {
        return Err(Error::failed("its values are not those that were written"));
    }
    Ok(())
}

fn array_digest<T: Element>(path: &Path, member: &Member) -> Result<Digest> {
    let reader = ArrayReader::<T>::open(path, &member.shape)?;
    let names = vec![""; member.shape.len()];
    let step = ArraySpec::new::<T>(&member.name, &member.shape, &names).slab_rows();
    let mut hasher = ArrayHasher::default();
    let rows = member.shape.first().copied().unwrap_or(0);
    for start in (0..rows).step_by(step) {
        hasher.update(reader.slab(start..rows.min(start + step))?.view());
    }
    Ok(hasher.finish())
}
