//! What failed, where and why: one small file per node in `failures/`, gone once the node succeeds.
//!
//! Nothing is decided by it. A record that cannot be written or read is a loss of comfort only.

use serde::{Deserialize, Serialize};

use super::Store;
use super::digest::{Digest, Key};
use super::holder::this_process;

/// A node that failed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failure {
    /// Label of the node.
    pub label: String,
    /// Why.
    pub error: String,
    /// Machine and process, as `host:process`.
    pub by: String,
    /// When (RFC 3339, UTC).
    pub at: String,
    /// The log of the process, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<String>,
}

impl Store {
    fn failure(&self, name: Key) -> std::path::PathBuf {
        self.root().join("failures").join(format!("{name}.json"))
    }

    /// Records that the work claimed as `name`, called `label`, failed in this process.
    pub fn record_failure(&self, name: Key, label: &str, error: &str, log: Option<&str>) {
        let failure = Failure {
            label: label.to_owned(),
            error: error.to_owned(),
            by: this_process(),
            at: jiff::Timestamp::now().to_string(),
            log: log.map(str::to_owned),
        };
        let path = self.failure(name);
        let Ok(text) = serde_json::to_vec_pretty(&failure) else { return };
        let _ = std::fs::create_dir_all(self.root().join("failures")).and_then(|()| std::fs::write(path, text));
    }

    /// Forgets that the work claimed as `name` failed.
    pub fn forget_failure(&self, name: Key) {
        let _ = std::fs::remove_file(self.failure(name));
    }

    /// All records, by the name of the work.
    pub fn failures(&self) -> Vec<(Key, Failure)> {
        let Ok(entries) = std::fs::read_dir(self.root().join("failures")) else { return Vec::new() };
        let read = |path: std::path::PathBuf| {
            let name = Digest::parse(path.file_stem()?.to_str()?)?;
            Some((name, serde_json::from_slice(&std::fs::read(path).ok()?).ok()?))
        };
        let mut all: Vec<(Key, Failure)> = entries.flatten().filter_map(|entry| read(entry.path())).collect();
        all.sort_by(|a, b| (&a.1.label, &a.1.at).cmp(&(&b.1.label, &b.1.at)));
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_kept_until_it_is_forgotten() {
        let dir = tempfile::tempdir().unwrap();
        let store = Store::open(dir.path()).unwrap();
        let name = Digest::of(b"work");
        assert!(store.failures().is_empty());
        store.record_failure(name, "merge", "no photographs", Some("logs/1.log"));
        let (found, failure) = store.failures().remove(0);
        assert_eq!((found, failure.label.as_str(), failure.error.as_str()), (name, "merge", "no photographs"));
        assert_eq!(failure.log.as_deref(), Some("logs/1.log"));
        store.forget_failure(name);
        assert!(store.failures().is_empty());
    }
}
