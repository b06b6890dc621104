//! A node of the store with one of its files damaged: its manifest, its arrays' metadata, a shard, its JSON.
//!
//! The first byte chooses the file, the next two the place, the third how much is cut there; the rest is put in.

use ndarray::ArrayD;
use rootvox::store::{FORMAT, Key, Manifest, Store};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

struct Node {
    _folder: tempfile::TempDir,
    store: Store,
    key: Key,
    files: Vec<(PathBuf, Vec<u8>)>,
}

fn files(folder: &Path, found: &mut Vec<(PathBuf, Vec<u8>)>) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        if entry.path().is_dir() {
            files(&entry.path(), found);
        } else {
            found.push((entry.path(), std::fs::read(entry.path()).unwrap()));
        }
    }
    found.sort();
}

fn node() -> &'static Node {
    static NODE: OnceLock<Node> = OnceLock::new();
    NODE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let mut draft = store.draft().unwrap();
        let values = ArrayD::from_shape_fn(vec![6, 5, 4], |i| (i[0] * i[1] + i[2]) as f32);
        draft.output.array::<f32>("values", values.view(), &["z", "y", "x"]).unwrap();
        draft.output.json("numbers.json", &[1.0, 2.0]).unwrap();
        let record = serde_json::json!({
            "format": FORMAT, "stage": "toy", "version": 1, "label": "toy", "params": {}, "inputs": {},
            "key": "0".repeat(64), "digest": "0".repeat(64), "members": [], "started": "", "seconds": 0.0, "threads": 1,
            "host": "", "program": "",
        });
        let mut record: Manifest = serde_json::from_value(record).unwrap();
        store.close(&mut draft, &mut record).unwrap();
        let key = record.key;
        store.publish(draft, record).unwrap();
        let mut found = Vec::new();
        files(&store.folder("toy", key), &mut found);
        Node { _folder: folder, store, key, files: found }
    })
}

/// Reads it, whatever it is, and tells whether it could be.
pub fn run(data: &[u8]) -> bool {
    let node = node();
    let [choice, high, low, cut, with @ ..] = data else { return false };
    let (path, whole) = &node.files[usize::from(*choice) % node.files.len()];
    let at = (usize::from(*high) * 256 + usize::from(*low)) % (whole.len() + 1);
    let rest = &whole[(at + usize::from(*cut)).min(whole.len())..];
    std::fs::write(path, [&whole[..at], with, rest].concat()).unwrap();
    let mut read = false;
    if let Ok(Some(manifest)) = node.store.lookup("toy", node.key)
        && let Ok(artefact) = node.store.artefact(&manifest)
    {
        read = artefact.array::<f32>("values").and_then(|values| values.read()).is_ok();
        let _ = artefact.json::<Vec<f64>>("numbers.json");
        let _ = artefact.bytes("numbers.json");
        let _ = artefact.path("values");
    }
    std::fs::write(path, whole).unwrap();
    read
}
