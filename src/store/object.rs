//! A node as one object, for stores that are not folders: a tar archive, its manifest first.
//!
//! ```text
//! packed-v1/merge/4be1….tar       stage and key, as in the store
//! ├── manifest.json               first, so that it can be read without the rest
//! └── merged/zarr.json …          the files of its members, by name; none where the values were streamed
//! ```
//!
//! What comes from outside is believed in nothing: names, kinds and sizes are held against the manifest, and the manifest
//! against the limits here, before anything is written; digests afterwards.

use std::collections::BTreeSet;
use std::io::{Read, Write};
use std::path::Path;

use tar::{Archive, Builder, EntryType, Header};

use super::array::check_layout;
use super::care::verify::check_node;
use super::digest::Key;
use super::files;
use super::manifest::{FORMAT, Manifest, MemberKind};
use super::output::is_plain;
use crate::error::{Error, Result};

/// The largest manifest, bytes.
const MOST_MANIFEST_BYTES: u64 = 16 << 20;

/// The largest node, bytes.
const MOST_NODE_BYTES: u64 = 64 << 30;

/// The largest array in memory, bytes.
const MOST_ARRAY_BYTES: u64 = 1 << 40;

/// What a node's files hold beyond its members.
const GROUP_BYTES: u64 = 4096;

/// Writes the node in `folder` to `to`.
pub(super) fn pack(folder: &Path, to: impl Write) -> Result<()> {
    let mut archive = Builder::new(to);
    let (manifest, others): (Vec<_>, Vec<_>) =
        files::tree(folder)?.into_iter().partition(|(name, _)| name == "manifest.json");
    for (name, path) in manifest.into_iter().chain(others) {
        let cannot = |e: std::io::Error| Error::io("pack", &path, e);
        let file = std::fs::File::open(&path).map_err(cannot)?;
        let mut header = Header::new_ustar();
        header.set_path(&name).map_err(cannot)?;
        header.set_size(file.metadata().map_err(cannot)?.len());
        header.set_mode(0o644);
        header.set_entry_type(EntryType::Regular);
        header.set_cksum();
        archive.append(&header, file).map_err(cannot)?;
    }
    archive.into_inner().and_then(|mut to| to.flush()).map_err(|e| Error::io("pack", folder, e))
}

/// The manifest of the node `stage`, `key` at the beginning of an object of `bytes` bytes.
pub(super) fn manifest(object: impl Read, bytes: u64, stage: &str, key: Key) -> Result<Manifest> {
    let mut archive = Archive::new(object);
    let mut entries = archive.entries().map_err(|e| broken(&e))?.raw(true);
    let entry = entries.next().ok_or_else(|| Error::failed("it is empty"))?.map_err(|e| broken(&e))?;
    read_manifest(entry, bytes, stage, key)
}

fn read_manifest(mut entry: tar::Entry<'_, impl Read>, bytes: u64, stage: &str, key: Key) -> Result<Manifest> {
    if &*entry.path_bytes() != b"manifest.json" || entry.size() > MOST_MANIFEST_BYTES {
        return Err(Error::failed("it does not begin with a manifest"));
    }
    let mut text = Vec::new();
    let size = entry.size();
    entry.by_ref().take(size).read_to_end(&mut text).map_err(|e| broken(&e))?;
    let manifest: Manifest =
        serde_json::from_slice(&text).map_err(|e| Error::failed(format!("its manifest cannot be understood: {e}")))?;
    if manifest.format != FORMAT || manifest.stage != stage || manifest.key != key {
        return Err(Error::failed("its manifest belongs to another node"));
    }
    if !manifest.is_virtual {
        check_promise(&manifest, bytes)?;
    }
    Ok(manifest)
}

/// Holds what a manifest promises against the limits and the size of its object.
fn check_promise(manifest: &Manifest, object_bytes: u64) -> Result<()> {
    let (mut total, mut names) = (0_u64, BTreeSet::new());
    for member in &manifest.members {
        total = total.saturating_add(member.bytes);
        if !is_plain(&member.name)
            || matches!(&*member.name, "manifest.json" | "zarr.json")
            || !names.insert(&member.name)
        {
            return Err(Error::failed(format!("its manifest names a member `{}`", member.name.escape_debug())));
        }
        let cells = member.shape.iter().try_fold(1_u64, |n, &side| n.checked_mul(side as u64));
        if member.kind == MemberKind::Array && cells.is_none_or(|n| n > MOST_ARRAY_BYTES / 8) {
            return Err(Error::failed(format!("its manifest promises an array of shape {:?}", member.shape)));
        }
    }
    if total > MOST_NODE_BYTES || total > object_bytes {
        return Err(Error::failed(format!(
            "its manifest promises {total} bytes where the object has {object_bytes} and {MOST_NODE_BYTES} are allowed"
        )));
    }
    Ok(())
}

/// Writes the files of the node `stage`, `key` from an object of `bytes` bytes into the empty `folder`, and verifies all
/// of them.
pub(super) fn unpack(object: impl Read, bytes: u64, stage: &str, key: Key, folder: &Path) -> Result<Manifest> {
    let mut archive = Archive::new(object);
    let mut entries = archive.entries().map_err(|e| broken(&e))?.raw(true);
    let entry = entries.next().ok_or_else(|| Error::failed("it is empty"))?.map_err(|e| broken(&e))?;
    let manifest = read_manifest(entry, bytes, stage, key)?;
    let mut left = if manifest.is_virtual { 0 } else { manifest.bytes() + GROUP_BYTES };
    for entry in entries {
        let mut entry = entry.map_err(|e| broken(&e))?;
        let name = String::from_utf8_lossy(&entry.path_bytes()).into_owned();
        let size = entry.size();
        if entry.header().entry_type() != EntryType::Regular || !is_inside(&name, &manifest) {
            return Err(Error::failed(format!("`{}` does not belong into it", name.escape_debug())));
        }
        left = left.checked_sub(size).ok_or_else(|| Error::failed("it holds more than its manifest promises"))?;
        let path = folder.join(&name);
        let mut write = || -> std::io::Result<u64> {
            std::fs::create_dir_all(path.parent().unwrap_or(folder))?;
            let mut file = std::fs::File::options().create_new(true).write(true).open(&path)?;
            let copied = std::io::copy(&mut entry.by_ref().take(size), &mut file)?;
            file.sync_all()?;
            Ok(copied)
        };
        if write().map_err(|e| Error::io("write", &path, e))? != size {
            return Err(Error::failed("it ends too early"));
        }
    }
    let text = serde_json::to_vec(&manifest).map_err(|e| Error::failed(format!("its manifest: {e}")))?;
    files::write_synced(&folder.join("manifest.json"), &text)?;
    for member in manifest.members.iter().filter(|m| m.kind == MemberKind::Array && !manifest.is_virtual) {
        check_layout(&folder.join(&member.name), member)?;
    }
    check_node(folder, stage, key)?;
    Ok(manifest)
}

/// Whether a file of that name belongs to a member of the manifest.
fn is_inside(name: &str, manifest: &Manifest) -> bool {
    if !files::leads_inside(name) {
        return false;
    }
    let owns = |member: &super::manifest::Member| match member.kind {
        MemberKind::Bytes => name == member.name,
        MemberKind::Json => name.strip_suffix(".json") == Some(&member.name),
        MemberKind::Array | MemberKind::Folder => {
            name.strip_prefix(&member.name).is_some_and(|rest| rest.starts_with('/'))
        }
    };
    let has_arrays = manifest.members.iter().any(|member| member.kind == MemberKind::Array);
    (name == "zarr.json" && has_arrays) || manifest.members.iter().any(owns)
}

fn broken(cause: &std::io::Error) -> Error {
    Error::failed(format!("it cannot be read: {cause}"))
}
