//! A folder of results: written beside its place and swapped in by rename, so that it never mixes two runs.
//!
//! Its `study.lock` says which nodes it was made from; a folder whose lock is equal, and which is complete, is left alone.

use super::crate_metadata::{self, Made};
use super::lock::Lock;
use crate::error::{Error, Result};
use crate::flow::{NodeId, Report};
use crate::store::{is_left_over, process_tag};
use std::fs;
use std::path::{Path, PathBuf};

/// Name of the lock file in a results folder.
pub const LOCK: &str = "study.lock";

/// Ending of the old results while new ones take their place.
const OLD: &str = "old";

/// A results folder being written.
pub struct Fresh {
    folder: tempfile::TempDir,
    target: PathBuf,
}

impl Fresh {
    /// Begins the results in `results_dir/<name of the study>` with that lock; `None` where they are there already.
    ///
    /// # Errors
    /// Where the folder cannot be written.
    pub fn begin(results_dir: &Path, lock: &Lock) -> Result<Option<Self>> {
        let (name, text) = (&lock.study, lock.text()?);
        let target = results_dir.join(name);
        check_free(&target)?;
        // Results behind a link stay behind it.
        let target = fs::canonicalize(&target).unwrap_or(target);
        if fs::read_to_string(target.join(LOCK)).is_ok_and(|old| old == text) && is_complete(&target) {
            return Ok(None);
        }
        fs::create_dir_all(results_dir)
            .map_err(|e| Error::io("create", results_dir, e).help("name another folder with --results"))?;
        let beside = target.parent().unwrap_or(results_dir);
        sweep(&target, name);
        let folder = tempfile::Builder::new()
            .prefix(&format!(".{name}-{}", process_tag()))
            .tempdir_in(beside)
            .map_err(|e| Error::io("write into", beside, e).help("name another folder with --results"))?;
        let fresh = Self { folder, target };
        fresh.write(LOCK, text.as_bytes())?;
        Ok(Some(fresh))
    }

    /// Writes the file `name`.
    ///
    /// # Errors
    /// Where it cannot be written.
    pub fn write(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let path = self.folder.path().join(name);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
        }
        fs::write(&path, bytes).map_err(|e| Error::io("write", &path, e))
    }

    /// Copies a member of a node's artefact, a file or a folder, to `name`.
    ///
    /// # Errors
    /// Where there is no such member or it cannot be copied.
    pub fn put(&self, report: &Report, node: NodeId, member: &str, name: &str) -> Result<()> {
        copy(&report.artefact(node)?.path(member)?, &self.folder.path().join(name))
    }

    /// Adds the metadata with what is known of the run, and puts the folder in its place.
    ///
    /// # Errors
    /// Where it cannot be replaced; the old results then stay as they were.
    pub fn publish(self, lock: &Lock, made: &Made) -> Result<()> {
        let folder = self.folder.path();
        let entries = fs::read_dir(folder).map_err(|e| Error::io("list", folder, e))?.flatten();
        let mut entries: Vec<_> =
            entries.map(|entry| (entry.file_name().to_string_lossy().into_owned(), entry.path().is_dir())).collect();
        entries.sort();
        self.write(crate_metadata::NAME, crate_metadata::text(lock, &entries, made)?.as_bytes())?;
        keep_foreign(&self.target, folder)?;
        swap_in(self.folder, &self.target)
    }
}

/// Fails where the results of study `name` could not be written into `results_dir`, before anything is computed for them.
///
/// # Errors
/// Where it, or the folder it would be made in, cannot be written, or something else stands in their place.
pub fn check_place(results_dir: &Path, name: &str) -> Result<()> {
    let target = results_dir.join(name);
    sweep(&fs::canonicalize(&target).unwrap_or_else(|_| target.clone()), name);
    check_free(&target)?;
    let mut there = results_dir.ancestors().filter(|a| a.as_os_str().is_empty() || a.exists());
    let there = there.next().filter(|a| !a.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A file without a name: nothing can stay behind.
    tempfile::tempfile_in(there)
        .map(drop)
        .map_err(|e| Error::io("write into", results_dir, e).help("name another folder with --results"))
}

/// Removes what processes that are gone left beside the results of study `name`. Where one died between the two renames that
/// swap results, the old ones are put back first: people's own files may lie in them.
fn sweep(target: &Path, name: &str) {
    let Some(entries) = target.parent().and_then(|beside| fs::read_dir(beside).ok()) else { return };
    let ours = format!(".{name}-");
    for path in entries.flatten().map(|entry| entry.path()) {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if !file.strip_prefix(&ours).is_some_and(is_left_over) {
            continue;
        }
        let is_old = path.extension().is_some_and(|extension| extension == OLD);
        if is_old && !target.exists() && fs::rename(&path, target).is_ok() {
            continue;
        }
        // What cannot be removed now is swept later.
        let _ = fs::remove_dir_all(&path);
    }
}

/// Fails where the target holds something that is no result.
fn check_free(target: &Path) -> Result<()> {
    let is_empty = fs::read_dir(target).is_ok_and(|mut entries| entries.next().is_none());
    if fs::symlink_metadata(target).is_err() || is_empty || target.join(LOCK).is_file() {
        return Ok(());
    }
    let message = format!("`{}` is no results folder (it holds no {LOCK}) and is left as it is", target.display());
    Err(Error::usage(message).help("name another folder with --results, or the study otherwise with study.name"))
}

/// Carries what people put beside the old results over to the fresh ones.
fn keep_foreign(target: &Path, fresh: &Path) -> Result<()> {
    let page = fs::read(target.join(crate_metadata::NAME)).ok();
    let parts = page.and_then(|page| crate_metadata::parts(&page)).unwrap_or_else(crate_metadata::known);
    let own: Vec<&str> = parts.iter().map(|part| part.trim_end_matches('/')).chain([crate_metadata::NAME]).collect();
    let Ok(entries) = fs::read_dir(target) else { return Ok(()) };
    for entry in entries.flatten() {
        let (name, to) = (entry.file_name(), fresh.join(entry.file_name()));
        if !own.iter().any(|own| name == **own) && !to.exists() {
            copy(&entry.path(), &to)?;
        }
    }
    Ok(())
}

/// Whether every part that the folder's metadata names is there: somebody may have removed one.
fn is_complete(target: &Path) -> bool {
    let parts = fs::read(target.join(crate_metadata::NAME)).ok().and_then(|page| crate_metadata::parts(&page));
    parts.is_some_and(|parts| parts.iter().all(|part| target.join(part).exists()))
}

/// Puts the fresh folder in the target's place.
fn swap_in(fresh: tempfile::TempDir, target: &Path) -> Result<()> {
    let had = target.exists();
    if had {
        let blocked = |e| Error::io("replace", target, e).help("give yourself the right to write there and run again");
        make_removable(target).map_err(blocked)?;
    }
    let fresh = fresh.keep();
    // Names of studies may hold dots.
    let mut aside = fresh.clone().into_os_string();
    aside.push(format!(".{OLD}"));
    let aside = PathBuf::from(aside);
    let swapped = (if had { fs::rename(target, &aside) } else { Ok(()) }).and_then(|()| fs::rename(&fresh, target));
    if let Err(e) = swapped {
        // Back to where we were.
        if had && !target.exists() {
            let _ = fs::rename(&aside, target);
        }
        let _ = fs::remove_dir_all(&fresh);
        return Err(Error::io("replace", target, e).help("is a program using the results? close it and run again"));
    }
    if had {
        let _ = fs::remove_dir_all(&aside);
    }
    Ok(())
}

/// Gives the owner of a folder the right to take everything out of it: what is moved aside must not stay there.
fn make_removable(folder: &Path) -> std::io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = fs::metadata(folder)?.permissions().mode();
        if mode & 0o700 != 0o700 {
            fs::set_permissions(folder, fs::Permissions::from_mode(mode | 0o700))?;
        }
    }
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        if entry.file_type()?.is_dir() {
            make_removable(&entry.path())?;
        }
    }
    Ok(())
}

/// Copies a file or a folder with all that is in it.
fn copy(from: &Path, to: &Path) -> Result<()> {
    if from.is_dir() {
        fs::create_dir_all(to).map_err(|e| Error::io("create", to, e))?;
        for entry in fs::read_dir(from).map_err(|e| Error::io("read", from, e))? {
            let entry = entry.map_err(|e| Error::io("read", from, e))?;
            copy(&entry.path(), &to.join(entry.file_name()))?;
        }
        return Ok(());
    }
    if let Some(folder) = to.parent() {
        fs::create_dir_all(folder).map_err(|e| Error::io("create", folder, e))?;
    }
    fs::copy(from, to).map(|_| ()).map_err(|e| Error::io("write", to, e))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn of_a_process_that_died_while_it_swapped_the_old_results_come_back() {
        let dir = tempfile::tempdir().unwrap();
        let tag = process_tag();
        let dead = tag.replace(&format!("-{}-", std::process::id()), &format!("-{}-", u32::MAX - 1));
        let make = |name: &str| {
            fs::create_dir(dir.path().join(name)).unwrap();
            fs::write(dir.path().join(name).join("mine.txt"), name).unwrap();
        };
        for name in [format!(".a-{dead}x"), format!(".a-{dead}x.old"), format!(".b-{dead}x"), format!(".a-{tag}x")] {
            make(&name);
        }
        check_place(dir.path(), "b").unwrap();
        sweep(&dir.path().join("a"), "a");
        let mut left: Vec<String> =
            fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        left.sort();
        assert_eq!(left, [format!(".a-{tag}x"), "a".to_owned()], "the living keeps its own");
        assert_eq!(fs::read_to_string(dir.path().join("a/mine.txt")).unwrap(), format!(".a-{dead}x.old"));
    }

    #[test]
    fn results_that_are_read_only_are_replaced_and_nothing_stays_behind() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("plant.v2");
        fs::create_dir_all(target.join("overlays/deep")).unwrap();
        fs::write(target.join("overlays/deep/a.jpg"), "old").unwrap();
        for folder in ["overlays/deep", "overlays", ""] {
            fs::set_permissions(target.join(folder), fs::Permissions::from_mode(0o555)).unwrap();
        }
        let fresh = tempfile::Builder::new().prefix(".plant.v2-").tempdir_in(dir.path()).unwrap();
        fs::write(fresh.path().join("new"), "new").unwrap();
        swap_in(fresh, &target).unwrap();
        let names = |at: &Path| -> Vec<_> { fs::read_dir(at).unwrap().map(|e| e.unwrap().file_name()).collect() };
        assert_eq!(names(dir.path()), ["plant.v2"]);
        assert_eq!(names(&target), ["new"]);
    }
}
