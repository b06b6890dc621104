//! Touches the files of what this process holds, so that others see that it lives.

use std::collections::BTreeSet;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::SystemTime;

use super::holder::BEAT;

type Held = Arc<Mutex<BTreeSet<PathBuf>>>;

/// Beats from the first file on until it is dropped.
#[derive(Default)]
pub(super) struct Heart {
    held: Held,
    stop: Mutex<Option<Sender<()>>>,
}

impl Heart {
    /// Touches `path` from now on.
    pub(super) fn add(&self, path: &Path) {
        self.held.lock().unwrap_or_else(PoisonError::into_inner).insert(path.to_owned());
        let mut stop = self.stop.lock().unwrap_or_else(PoisonError::into_inner);
        if stop.is_none() {
            let (sender, stopped) = channel();
            let held = self.held.clone();
            let beat = move || {
                while stopped.recv_timeout(BEAT) == Err(RecvTimeoutError::Timeout) {
                    let all = held.lock().unwrap_or_else(PoisonError::into_inner).clone();
                    for path in all {
                        // What cannot be touched was taken away: its holder will see when it gives it back.
                        let _ = File::options()
                            .append(true)
                            .open(&path)
                            .and_then(|file| file.set_modified(SystemTime::now()));
                    }
                }
            };
            // Without a thread nobody hears this process, which costs work done twice and nothing else.
            *stop = std::thread::Builder::new().name("heart".into()).spawn(beat).ok().map(|_| sender);
        }
    }

    /// Leaves `path` alone from now on.
    pub(super) fn remove(&self, path: &Path) {
        self.held.lock().unwrap_or_else(PoisonError::into_inner).remove(path);
    }
}
