//! What [`super::pack`] wrote, taken apart again; a file from strangers can do no harm.
//!
//! Only plain files in the known folders, each once; nothing grows beyond what its size in the archive can mean; nothing
//! is written outside of the folder.

use super::crate_metadata;
use super::pack::{INPUT, NODES, RESULTS};
use crate::error::{Error, Result};
use crate::store::leads_inside;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use zip::ZipArchive;

/// Files in one archive.
const MOST_FILES: usize = 1_000_000;

/// Bytes that any archive may unpack to, and so many for every byte of it.
const ALWAYS_BYTES: u64 = 64 << 20;
const MOST_GROWTH: u64 = 200;

/// Unpacks the file at `path` into the empty `folder`.
///
/// # Errors
/// Where it cannot be read, or holds what does not belong there.
pub fn unpack(path: &Path, folder: &Path) -> Result<()> {
    let no_parcel = |cause: &dyn std::fmt::Display| {
        Error::usage(format!("`{}` is no study that was packed: {cause}", path.display()))
            .help("`rootvox pack STUDY -o plant-7.rootvox.zip` makes one")
    };
    let file = File::open(path).map_err(|e| Error::io("read", path, e))?;
    let size = file.metadata().map_err(|e| Error::io("read", path, e))?.len();
    let mut archive = ZipArchive::new(BufReader::new(file)).map_err(|e| no_parcel(&e))?;
    if archive.len() > MOST_FILES {
        return Err(no_parcel(&format_args!("it holds {} files", archive.len())));
    }
    let mut left = ALWAYS_BYTES.saturating_add(size.saturating_mul(MOST_GROWTH));
    for n in 0..archive.len() {
        let mut entry = archive.by_index(n).map_err(|e| no_parcel(&e))?;
        let name = entry.name().map_err(|e| no_parcel(&e))?.into_owned();
        if entry.is_dir() {
            continue;
        }
        if entry.is_symlink() || !entry.is_file() || !belongs(&name) {
            return Err(no_parcel(&format_args!("`{}` does not belong into one", name.escape_debug())));
        }
        let promised = entry.size();
        left = left.checked_sub(promised).ok_or_else(|| no_parcel(&"it unpacks to far more than it is"))?;
        let to = folder.join(&name);
        let write = |entry: &mut dyn Read| -> std::io::Result<u64> {
            std::fs::create_dir_all(to.parent().unwrap_or(folder))?;
            let mut file = File::options().create_new(true).write(true).open(&to)?;
            std::io::copy(&mut entry.take(promised + 1), &mut file)
        };
        match write(&mut entry) {
            Ok(n) if n == promised => {}
            Ok(_) => return Err(no_parcel(&format_args!("`{name}` is not as long as it says"))),
            Err(e) if e.kind() == std::io::ErrorKind::InvalidData || e.kind() == std::io::ErrorKind::InvalidInput => {
                return Err(no_parcel(&format_args!("`{name}` is damaged: {e}")));
            }
            Err(e) => return Err(Error::io("unpack", &to, e)),
        }
    }
    Ok(())
}

/// Whether a packed study may hold a file of that name.
fn belongs(name: &str) -> bool {
    let mut parts = name.split('/');
    let known = [INPUT, RESULTS, NODES, "study"];
    let (first, is_file) = (parts.next().unwrap_or_default(), name == crate_metadata::NAME);
    leads_inside(name) && (is_file || (known.contains(&first) && parts.next().is_some()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Seek, Write};
    use zip::ZipWriter;
    use zip::write::SimpleFileOptions;

    /// What unpacking says to an archive with this one entry.
    fn refused(name: &str, bytes: &[u8], mode: u32) -> String {
        let dir = tempfile::tempdir().unwrap();
        let mut zip = ZipWriter::new(tempfile::NamedTempFile::new().unwrap());
        zip.start_file(name, SimpleFileOptions::default().unix_permissions(mode)).unwrap();
        zip.write_all(bytes).unwrap();
        let file = zip.finish().unwrap();
        let inner = dir.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        let answer = unpack(file.path(), &inner).map_err(|e| e.message).err().unwrap_or_default();
        let outside: Vec<_> = std::fs::read_dir(dir.path()).unwrap().flatten().map(|e| e.file_name()).collect();
        assert_eq!(outside, ["inner"], "{name} got out");
        answer
    }

    #[test]
    fn names_that_lead_out_and_names_of_others_are_refused() {
        for name in ["../evil", "results/../../evil", "/results/evil", "results/./a", "results//a", "evil", "results"] {
            assert!(refused(name, b"x", 0o644).contains("does not belong"), "{name}");
        }
        for name in ["results\\..\\evil", "results/c:evil"] {
            assert!(refused(name, b"x", 0o644).contains("does not belong"), "{name}");
        }
        assert_eq!(refused("results/a/b.csv", b"x", 0o644), "");
    }

    #[test]
    fn what_unpacks_to_far_more_than_it_is_is_refused() {
        let zeros = vec![0; (ALWAYS_BYTES + (40 << 20)) as usize];
        assert!(refused("results/bomb", &zeros, 0o644).contains("far more"));
    }

    #[test]
    fn links_broken_files_and_what_is_no_archive_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let mut zip = ZipWriter::new(tempfile::NamedTempFile::new().unwrap());
        zip.add_symlink("results/link", "/etc/passwd", SimpleFileOptions::default()).unwrap();
        let file = zip.finish().unwrap();
        assert!(unpack(file.path(), dir.path()).unwrap_err().message.contains("does not belong"));
        let mut text = tempfile::NamedTempFile::new().unwrap();
        text.write_all(b"no archive").unwrap();
        text.rewind().unwrap();
        assert!(unpack(text.path(), dir.path()).unwrap_err().message.contains("is no study that was packed"));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }
}
