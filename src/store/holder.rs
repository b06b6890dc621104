//! Who holds a claim or a folder of drafts, and whether they still live.
//!
//! A holder writes who it is into a file and touches the file every [`BEAT`]. On the same machine the system is asked
//! whether the process lives; of another machine the touches tell. No file locks: network file systems refuse them, or
//! grant them to everybody.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use super::digest::Digest;
use serde::{Deserialize, Serialize};
use sysinfo::{Pid, ProcessRefreshKind, ProcessStatus, ProcessesToUpdate, System};

/// How often a holder touches its files.
pub(super) const BEAT: Duration = Duration::from_secs(10);

/// A file that names nobody is given up after so long: its maker died before it wrote, and writing follows making at once.
pub(super) const PATIENCE_NAMELESS: Duration = BEAT;

/// Clocks tell the start of one process to within this, seconds.
const SAME_START_S: u64 = 2;

/// A process that holds something.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Holder {
    /// Its machine.
    pub host: String,
    /// The space that its number counts in: containers of one machine may count apart.
    pub(super) space: String,
    /// Its number.
    pub process: u32,
    /// When it began, seconds since 1970: numbers come back.
    pub(super) began: u64,
    /// What it holds, for people: the label of a node.
    pub what: String,
    /// Since when (RFC 3339).
    pub since: String,
    /// Tells one hold from the next.
    pub(super) turn: u64,
}

struct This {
    host: String,
    space: String,
    began: u64,
}

static THIS: LazyLock<This> = LazyLock::new(|| This {
    host: gethostname::gethostname().to_string_lossy().into_owned(),
    space: std::fs::read_link("/proc/self/ns/pid").map(|l| l.to_string_lossy().into_owned()).unwrap_or_default(),
    began: began(std::process::id()).unwrap_or_default(),
});

static TURN: AtomicU64 = AtomicU64::new(0);

/// When a process of this machine began; `None` where there is none of this number.
fn began(process: u32) -> Option<u64> {
    let (mut system, pid) = (System::new().ok()?, Pid::from_u32(process));
    let what = ProcessRefreshKind::nothing().without_tasks();
    system.refresh_processes_specifics(ProcessesToUpdate::Some(&[pid]), true, what);
    // One that ended and that nobody asked after is still listed: containers without an init keep such.
    let process = system.process(pid).filter(|p| !matches!(p.status(), ProcessStatus::Zombie | ProcessStatus::Dead));
    process.map(|process| process.start_time())
}

/// Whether the process of this machine that began then has ended.
fn is_over(process: u32, since: u64) -> bool {
    began(process).is_none_or(|began| began.abs_diff(since) > SAME_START_S)
}

/// A machine and its space, in a word.
fn machine(host: &str, space: &str) -> String {
    Digest::of(format!("{host}\n{space}").as_bytes()).to_string()[..12].to_owned()
}

/// With what the names of this process's files begin: their maker is known before anything stands in them.
pub fn tag() -> String {
    format!("{}-{}-{}-", machine(&THIS.host, &THIS.space), std::process::id(), THIS.began)
}

/// Whether this machine knows that the process is gone that a name begins with ([`tag`]).
pub fn is_left_over(name: &str) -> bool {
    let mut parts = name.split('-');
    let is_here = parts.next() == Some(&machine(&THIS.host, &THIS.space));
    let (process, since) = (parts.next().and_then(|n| n.parse().ok()), parts.next().and_then(|n| n.parse().ok()));
    is_here && process.zip(since).is_some_and(|(process, since)| is_over(process, since))
}

impl Holder {
    /// This process, holding `what`.
    pub(super) fn this(what: &str) -> Self {
        Self {
            host: THIS.host.clone(),
            space: THIS.space.clone(),
            process: std::process::id(),
            began: THIS.began,
            what: what.to_owned(),
            since: jiff::Timestamp::now().to_string(),
            turn: TURN.fetch_add(1, Ordering::Relaxed),
        }
    }

    /// Whether this machine knows that the process is gone.
    pub(super) fn is_gone(&self) -> bool {
        self.host == THIS.host && self.space == THIS.space && is_over(self.process, self.began)
    }

    /// Writes it to a new file.
    pub(super) fn write(&self, file: &mut File) -> std::io::Result<()> {
        file.write_all(&serde_json::to_vec(self)?)
    }

    /// The holder in the text of a file; `None` while it is being written.
    pub(super) fn parse(text: &[u8]) -> Option<Self> {
        serde_json::from_slice(text).ok()
    }
}

/// Whether the holder named in the file at `path` is gone: known to be, or silent for `patience` by the clocks.
pub(super) fn is_abandoned(path: &Path, patience: Duration) -> bool {
    let Ok(text) = std::fs::read(path) else { return false };
    if Holder::parse(&text).is_some_and(|holder| holder.is_gone()) {
        return true;
    }
    is_silent(path, if text.is_empty() { patience.min(PATIENCE_NAMELESS) } else { patience })
}

/// Whether the file at `path` was not touched for `patience`, by the clocks.
pub(super) fn is_silent(path: &Path, patience: Duration) -> bool {
    let touched = std::fs::metadata(path).and_then(|meta| meta.modified()).ok();
    touched.and_then(|time| SystemTime::now().duration_since(time).ok()).is_some_and(|age| age > patience)
}

/// This process for people: `host:process`.
pub(super) fn this_process() -> String {
    format!("{}:{}", THIS.host, std::process::id())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_process_lives_while_it_runs_and_a_number_that_came_back_is_another() {
        let this = Holder::this("merge");
        assert!(!this.is_gone());
        assert!(Holder { began: this.began - 100, ..this.clone() }.is_gone());
        assert!(!Holder { host: "elsewhere".into(), began: 0, ..this.clone() }.is_gone(), "nothing is known of others");
        let mut child = std::process::Command::new("sleep").arg("60").spawn().unwrap();
        let other = Holder { process: child.id(), began: began(child.id()).unwrap(), ..this };
        assert!(!other.is_gone());
        let named = |began| format!("{}-{}-{began}-x.lock", machine(&THIS.host, &THIS.space), child.id());
        let (now, before) = (named(other.began), named(other.began - 100));
        assert!(!is_left_over(&now) && is_left_over(&before) && !is_left_over(&format!("{}x", tag())));
        assert!(!is_left_over(&before[1..]) && !is_left_over("x.lock"), "nothing is known of others");
        child.kill().unwrap();
        while !other.is_gone() {
            // Killed, and not yet asked after.
            std::thread::sleep(Duration::from_millis(10));
        }
        child.wait().unwrap();
        assert!(other.is_gone() && is_left_over(&now));
    }
}
