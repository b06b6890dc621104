//! Lenses against OpenCV: pixels of random directions, and the directions back from these pixels.
//!
//! `tests/data/lenses/points.py` wrote the figures, and writes more: its head says how.

use rootvox::optics::Lens;
use serde::Deserialize;
use std::path::{Path, PathBuf};

#[derive(Deserialize)]
struct File {
    lenses: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    lens: Lens,
    points: Vec<[f64; 4]>,
}

#[test]
fn pixels_are_those_of_opencv() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/lenses/opencv.json");
    let path = std::env::var_os("ROOTVOX_LENSES").map_or(own, PathBuf::from);
    let file: File = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!(file.lenses.len(), 8);
    for Case { name, lens, points } in file.lenses {
        let (mut forward, mut back) = (0_f64, 0_f64);
        for &[x, y, u, v] in &points {
            let seen = lens.pixel(x, y);
            forward = forward.max((seen.0 - u).abs()).max((seen.1 - v).abs());
            let found = lens.direction(u, v);
            back = back.max((found.0 - x).abs()).max((found.1 - y).abs());
        }
        assert!(forward < 1e-6 && back < 1e-9, "{name}: {forward} px, {back}");
    }
}
