//! Claims: a courtesy between processes, so that the same work is rarely done twice.
//!
//! A claim is a file that only one process can make. It names its holder ([`Holder`]); a holder that is gone, or that
//! was not heard of for [`PATIENCE`], loses it. Correctness does not rest on claims: where two processes come to hold
//! one, both compute, and the second to publish finds the result there.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant, SystemTime};

use super::digest::{Digest, Key};
use super::heart::Heart;
use super::holder::{BEAT, Holder, PATIENCE_NAMELESS, is_abandoned};
use crate::error::{Error, Result};

/// A holder that was not heard of for so long is taken for dead: several beats, and more than file servers take to show
/// one machine what another did.
const PATIENCE: Duration = Duration::from_secs(9 * BEAT.as_secs());

/// Of claims that nobody asks for, the files of silent holders are swept at this age.
const STALE: Duration = Duration::from_secs(3600);

/// The answer to a claim.
pub enum Claim {
    /// The work is ours until this is dropped.
    Ours(Held),
    /// Another thread or process is at it.
    Busy,
}

/// A claim held; given back when dropped.
pub struct Held(Option<(PathBuf, Holder, Arc<Heart>)>);

impl Drop for Held {
    fn drop(&mut self) {
        if let Some((path, holder, heart)) = self.0.take() {
            heart.remove(&path);
            // It may have been taken away from a process that slept for long.
            if std::fs::read(&path).is_ok_and(|text| Holder::parse(&text).as_ref() == Some(&holder)) {
                let _ = std::fs::remove_file(&path);
            }
        }
    }
}

/// The claims in one folder.
pub(super) struct Claims {
    folder: PathBuf,
    heart: Arc<Heart>,
    patience: Duration,
    /// When others' claims were last touched, and since when this process sees them so. Clocks of machines differ.
    seen: Mutex<BTreeMap<Key, (SystemTime, Instant)>>,
}

impl Claims {
    /// Claims in `folder`, kept alive by `heart`.
    pub(super) fn new(folder: PathBuf, heart: Arc<Heart>) -> Self {
        Self { folder, heart, patience: PATIENCE, seen: Mutex::default() }
    }

    /// Claims the work `key`, called `label`, without waiting.
    pub(super) fn claim(&self, key: Key, label: &str) -> Claim {
        let path = self.folder.join(format!("{key}.lock"));
        let make = || File::options().create_new(true).write(true).open(&path);
        let holder = Holder::this(label);
        for _ in 0..2 {
            let made = make().or_else(|e| match e.kind() {
                ErrorKind::NotFound => std::fs::create_dir_all(&self.folder).and_then(|()| make()),
                _ => Err(e),
            });
            match made {
                Ok(mut file) => {
                    if holder.write(&mut file).is_err() {
                        // A claim that names nobody would keep others waiting.
                        let _ = std::fs::remove_file(&path);
                        return Claim::Ours(Held(None));
                    }
                    self.heart.add(&path);
                    return Claim::Ours(Held(Some((path, holder, self.heart.clone()))));
                }
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {
                    if !self.is_given_up(key, &path) {
                        return Claim::Busy;
                    }
                }
                // Nobody can claim anything here.
                Err(_) => return Claim::Ours(Held(None)),
            }
        }
        Claim::Busy
    }

    /// Whether the claim at `path` is gone, taken away from a dead holder if need be.
    fn is_given_up(&self, key: Key, path: &Path) -> bool {
        let look = || -> std::io::Result<(Vec<u8>, SystemTime)> {
            // Opening makes a network file system ask the server.
            let mut file = File::open(path)?;
            let mut text = Vec::new();
            std::io::Read::read_to_end(&mut file, &mut text)?;
            Ok((text, file.metadata()?.modified()?))
        };
        let (text, touched) = match look() {
            Ok(found) => found,
            Err(e) => return e.kind() == ErrorKind::NotFound,
        };
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        let (last, since) = *seen.entry(key).or_insert((touched, Instant::now()));
        if last != touched {
            seen.insert(key, (touched, Instant::now()));
        }
        let patience = if text.is_empty() { self.patience.min(PATIENCE_NAMELESS) } else { self.patience };
        let is_silent = last == touched && since.elapsed() > patience;
        if !is_silent && !Holder::parse(&text).is_some_and(|holder| holder.is_gone()) {
            return false;
        }
        seen.remove(&key);
        drop(seen);
        take_away(path, &text)
    }

    /// All claims and who holds them.
    pub(super) fn list(&self) -> Vec<(Key, Holder)> {
        let Ok(entries) = std::fs::read_dir(&self.folder) else { return Vec::new() };
        let of = |path: PathBuf| {
            Some((Digest::parse(path.file_stem()?.to_str()?)?, Holder::parse(&std::fs::read(&path).ok()?)?))
        };
        entries.flatten().filter_map(|entry| of(entry.path())).filter(|(_, holder)| !holder.is_gone()).collect()
    }
}

/// Takes the claim that holds `text` away; false if it is another one by now.
fn take_away(path: &Path, text: &[u8]) -> bool {
    let aside = path.with_extension(format!("{}.taken", std::process::id()));
    // One of several takers moves it.
    if std::fs::rename(path, &aside).is_err() {
        return false;
    }
    let is_it = std::fs::read(&aside).is_ok_and(|found| found == text);
    if !is_it {
        // Somebody was faster and holds it now: back with it.
        let _ = std::fs::hard_link(&aside, path);
    }
    let _ = std::fs::remove_file(&aside);
    is_it
}

/// Removes the claims in `folder` of holders that are gone.
pub(super) fn sweep(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for path in entries.flatten().map(|entry| entry.path()) {
        if is_abandoned(&path, STALE)
            && let Ok(text) = std::fs::read(&path)
        {
            take_away(&path, &text);
        }
    }
}

impl super::Store {
    /// Claims the work `key`, called `label`, without waiting, so that other processes do something else meanwhile.
    pub fn claim(&self, key: Key, label: &str) -> Claim {
        self.0.claims.claim(key, label)
    }

    /// Who is at what: all claims of processes that live as far as is known.
    ///
    /// # Errors
    /// Where there is no store.
    pub fn claims(&self) -> Result<Vec<(Key, Holder)>> {
        if self.exists() {
            return Ok(self.0.claims.list());
        }
        Err(Error::usage(format!("there is no store in `{}`", self.home().display())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn claims(folder: &Path, patience: Duration) -> Claims {
        Claims { patience, ..Claims::new(folder.to_owned(), Arc::default()) }
    }

    fn is_ours(claim: &Claim) -> bool {
        matches!(claim, Claim::Ours(_))
    }

    #[test]
    fn one_holds_it_until_it_is_given_back() {
        let dir = tempfile::tempdir().unwrap();
        let (one, two) = (claims(dir.path(), PATIENCE), claims(dir.path(), PATIENCE));
        let key = Digest::of(b"work");
        let held = one.claim(key, "merge");
        assert!(is_ours(&held) && !is_ours(&two.claim(key, "merge")) && !is_ours(&one.claim(key, "merge")));
        assert_eq!(two.list().iter().map(|(k, h)| (*k, h.what.as_str())).collect::<Vec<_>>(), [(key, "merge")]);
        drop(held);
        assert!(is_ours(&two.claim(key, "merge")));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn of_many_threads_one_gets_a_dead_holders_claim() {
        let dir = tempfile::tempdir().unwrap();
        let mut child = std::process::Command::new("true").spawn().unwrap();
        child.wait().unwrap();
        for n in 0..50_u8 {
            let key = Digest::of(&[n]);
            let dead = Holder { process: child.id(), ..Holder::this("merge") };
            std::fs::write(dir.path().join(format!("{key}.lock")), serde_json::to_vec(&dead).unwrap()).unwrap();
            let won: Vec<Claim> = std::thread::scope(|scope| {
                let ask = || claims(dir.path(), PATIENCE).claim(key, "merge");
                let threads: Vec<_> = (0..4).map(|_| scope.spawn(ask)).collect();
                threads.into_iter().map(|thread| thread.join().unwrap()).collect()
            });
            assert!(won.iter().filter(|claim| is_ours(claim)).count() >= 1, "turn {n}");
        }
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_silent_holder_of_another_machine_loses_it_and_a_heard_one_does_not() {
        let dir = tempfile::tempdir().unwrap();
        let claims = claims(dir.path(), Duration::from_millis(200));
        for (n, text) in [br#"{"host": "node-7"}"#.to_vec(), Vec::new()].into_iter().enumerate() {
            let key = Digest::of(&[n as u8]);
            let path = dir.path().join(format!("{key}.lock"));
            std::fs::write(&path, &text).unwrap();
            for _ in 0..4 {
                assert!(!is_ours(&claims.claim(key, "merge")));
                std::thread::sleep(Duration::from_millis(90));
                File::options().append(true).open(&path).unwrap().set_modified(SystemTime::now()).unwrap();
            }
            assert!(!is_ours(&claims.claim(key, "merge")));
            std::thread::sleep(Duration::from_millis(250));
            assert!(is_ours(&claims.claim(key, "merge")));
        }
    }

    #[test]
    fn sweeping_takes_the_dead_and_leaves_the_living() {
        let dir = tempfile::tempdir().unwrap();
        let claims = claims(dir.path(), PATIENCE);
        let held = claims.claim(Digest::of(b"alive"), "merge");
        let gone = Holder { process: u32::MAX - 1, ..Holder::this("merge") };
        std::fs::write(dir.path().join("dead.lock"), serde_json::to_vec(&gone).unwrap()).unwrap();
        sweep(dir.path());
        assert!(is_ours(&held));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_claim_that_names_nobody_is_swept_once_its_maker_cannot_be_writing() {
        let dir = tempfile::tempdir().unwrap();
        for (name, age_s) in [("old.lock", 20), ("new.lock", 0)] {
            let file = File::create(dir.path().join(name)).unwrap();
            file.set_modified(SystemTime::now() - Duration::from_secs(age_s)).unwrap();
        }
        sweep(dir.path());
        let left: Vec<_> = std::fs::read_dir(dir.path()).unwrap().map(|e| e.unwrap().file_name()).collect();
        assert_eq!(left, ["new.lock"]);
    }
}
