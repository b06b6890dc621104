//! Hostile input: the kept corpora and files of every format, whole and damaged, through the bodies of the fuzz targets
//! (`tests/fuzz`), seeded. Nothing panics and nothing hangs.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::fs;
use std::path::{Path, PathBuf};

#[path = "fuzz/bodies/cameras.rs"]
mod cameras;
#[path = "fuzz/bodies/photograph.rs"]
mod photograph;
#[path = "fuzz/bodies/roots.rs"]
mod roots;
#[path = "fuzz/bodies/store.rs"]
mod store;
#[path = "fuzz/bodies/study.rs"]
mod study;

/// Damaged versions of each file.
const TIMES: usize = 300;

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let mut found: Vec<PathBuf> =
        fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).filter(|path| path.is_file()).collect();
    assert!(!found.is_empty(), "{} is empty", folder.display());
    found.sort();
    found
}

/// Reads the files, each as it is and with bytes replaced, cut out, repeated and put in.
fn provoke(body: fn(&[u8]) -> bool, folders: &[&str]) {
    let mut rng = ChaCha8Rng::seed_from_u64(27);
    for path in folders.iter().flat_map(|folder| files(folder)) {
        let whole = fs::read(&path).unwrap();
        body(&whole);
        for _ in 0..TIMES {
            let mut bytes = whole.clone();
            for _ in 0..rng.random_range(1..4) {
                let at = rng.random_range(0..=bytes.len());
                let end = (at + rng.random_range(0..9)).min(bytes.len());
                match rng.random_range(0..4) {
                    0 => bytes[at..end].iter_mut().for_each(|byte| *byte = rng.random()),
                    1 => drop(bytes.drain(at..end)),
                    2 => {
                        let again = bytes[at..end].to_vec();
                        bytes.splice(at..at, again);
                    }
                    _ => {
                        let digits = ["9999999999", "-1", "1e999", "nan", "0", "\"", "[", "<"];
                        bytes.splice(at..end, digits[rng.random_range(0..digits.len())].bytes());
                    }
                }
            }
            body(&bytes);
        }
    }
}

/// Samples that no parser takes would provoke nothing.
#[test]
fn the_samples_are_read() {
    let of = |body: fn(&[u8]) -> bool, folder: &str| {
        for path in files(folder) {
            assert!(body(&fs::read(&path).unwrap()), "{}", path.display());
        }
    };
    of(cameras::run, "tests/fuzz/corpus/cameras");
    of(roots::run, "tests/fuzz/corpus/roots");
    of(study::run, "tests/fuzz/corpus/study");
}

#[test]
fn cameras_of_any_kind() {
    provoke(cameras::run, &["tests/fuzz/corpus/cameras"]);
}

#[test]
fn roots_of_any_kind() {
    provoke(roots::run, &["tests/fuzz/corpus/roots"]);
}

#[test]
fn photographs_of_any_kind() {
    provoke(photograph::run, &["tests/fuzz/corpus/photograph", "tests/data/photographs"]);
}

#[test]
fn studies_of_any_kind() {
    provoke(study::run, &["tests/fuzz/corpus/study", "pipelines"]);
}

#[test]
fn nodes_of_any_kind() {
    assert!(store::run(&[0, 0, 0, 0]), "an undamaged node");
    provoke(store::run, &["tests/fuzz/corpus/store"]);
}
