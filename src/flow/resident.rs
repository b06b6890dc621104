//! The memory that the process holds while a node runs, measured.
//!
//! The resident set of the whole process is read at the beginning, every [`EVERY`] and at the end: nodes that run at the
//! same time, and what the program holds beside them, are in it. So it bounds a node's own need from above.

use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use sysinfo::{Pid, ProcessRefreshKind, ProcessesToUpdate, System};

/// How often the resident set is read.
const EVERY: Duration = Duration::from_millis(20);

/// Watches the resident set until it is asked.
pub(super) struct Resident {
    stop: Sender<()>,
    watcher: Option<JoinHandle<Option<u64>>>,
}

impl Resident {
    /// Begins to watch.
    pub(super) fn watch() -> Self {
        let (stop, stopped) = channel();
        let watcher = std::thread::Builder::new().name("resident".into()).spawn(move || {
            let (mut system, pid) = (System::new().ok()?, sysinfo::get_current_pid().ok()?);
            let mut peak = now(&mut system, pid);
            while stopped.recv_timeout(EVERY) == Err(RecvTimeoutError::Timeout) {
                peak = peak.max(now(&mut system, pid));
            }
            peak.max(now(&mut system, pid))
        });
        Self { stop, watcher: watcher.ok() }
    }

    /// The largest resident set since then, bytes; `None` where the machine does not tell.
    pub(super) fn peak_bytes(self) -> Option<u64> {
        drop(self.stop);
        self.watcher?.join().ok().flatten()
    }
}

fn now(system: &mut System, pid: Pid) -> Option<u64> {
    let what = ProcessRefreshKind::nothing().with_memory().without_tasks();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), false, what);
    system.process(pid).map(|process| process.memory())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_held_for_a_moment_is_seen() {
        let watch = Resident::watch();
        let before = Resident::watch().peak_bytes().unwrap();
        let held = std::hint::black_box(vec![1_u8; 256 << 20]);
        std::thread::sleep(4 * EVERY);
        drop(held);
        let peak = watch.peak_bytes().unwrap();
        assert!(peak > before + (200 << 20), "{before} {peak}");
    }
}
