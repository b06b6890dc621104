//! Plain files: digests, sizes, atomic writing.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use super::digest::Digest;
use crate::error::{Error, Result};

/// Digest and length of the file at `path`.
pub(super) fn digest_file(path: &Path) -> Result<(Digest, u64)> {
    let cannot = |e| Error::io("read", path, e);
    let mut file = std::fs::File::open(path).map_err(cannot)?;
    let mut hasher = blake3::Hasher::new();
    let mut block = vec![0; 1 << 20];
    let mut length = 0;
    loop {
        match file.read(&mut block).map_err(cannot)? {
            0 => return Ok((Digest(hasher.finalize().into()), length)),
            n => {
                hasher.update(&block[..n]);
                length += n as u64;
            }
        }
    }
}

/// All files under `folder` as paths relative to it with `/` between names, sorted; nothing if it is missing.
pub fn tree(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let mut found = Vec::new();
    let mut open = vec![(String::new(), folder.to_owned())];
    while let Some((prefix, path)) = open.pop() {
        let entries = match std::fs::read_dir(&path) {
            Ok(entries) => entries,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound && prefix.is_empty() => return Ok(found),
            Err(e) => return Err(Error::io("list", &path, e)),
        };
        for entry in entries {
            let entry = entry.map_err(|e| Error::io("list", &path, e))?;
            let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
            if entry.file_type().map_err(|e| Error::io("list", &path, e))?.is_dir() {
                open.push((format!("{name}/"), entry.path()));
            } else {
                found.push((name, entry.path()));
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Makes temporary files that are readable and writable as the umask says, not to their maker alone: stores and packed
/// studies are shared.
pub fn shared_files<'a>() -> tempfile::Builder<'a, 'static> {
    #[allow(unused_mut, reason = "only Unix has modes")]
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

/// Whether a name from others leads to a file inside of the folder that it is laid under: plain parts with `/` between.
pub fn leads_inside(name: &str) -> bool {
    let strange = |part: &str| part.is_empty() || part == "." || part == ".." || part.contains(['\\', ':', '\0']);
    !name.split('/').any(strange)
}

/// Bytes of all files under `folder`.
pub(super) fn tree_bytes(folder: &Path) -> Result<u64> {
    let mut total = 0;
    for (_, path) in tree(folder)? {
        total += std::fs::metadata(&path).map_err(|e| Error::io("look at", &path, e))?.len();
    }
    Ok(total)
}

/// Digest over the sorted relative paths and contents of a folder, and its bytes.
pub(super) fn digest_tree(folder: &Path) -> Result<(Digest, u64)> {
    let mut hasher = blake3::Hasher::new();
    let mut total = 0;
    for (name, path) in tree(folder)? {
        let (digest, length) = digest_file(&path)?;
        hasher.update(&(name.len() as u64).to_le_bytes());
        hasher.update(name.as_bytes());
        hasher.update(&digest.0);
        total += length;
    }
    Ok((Digest(hasher.finalize().into()), total))
}

/// Writes a new file and brings it to the disk.
pub(super) fn write_synced(path: &Path, bytes: &[u8]) -> Result<()> {
    let write = || -> std::io::Result<()> {
        let mut file = std::fs::File::create(path)?;
        file.write_all(bytes)?;
        file.sync_all()
    };
    write().map_err(|e| Error::io("write", path, e))
}

/// Brings a folder's entries to the disk, where the system can.
pub(super) fn sync_folder(path: &Path) {
    if let Ok(folder) = std::fs::File::open(path) {
        // Some file systems refuse to synchronise folders; the files themselves are synchronised.
        let _ = folder.sync_all();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn shared_files_have_the_mode_of_any_new_file() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let any = std::fs::File::create(dir.path().join("any")).unwrap();
        let shared = shared_files().tempfile_in(dir.path()).unwrap();
        let mode = |file: &std::fs::File| file.metadata().unwrap().permissions().mode();
        assert_eq!(mode(shared.as_file()), mode(&any));
    }
}
