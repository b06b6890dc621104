//! Cameras and lenses of every format that is read: the first byte chooses it, 0xFF parts the files of a COLMAP model.

use rootvox::formats::camera_file::{self, COLMAP_FILES};
use rootvox::formats::opencv_lens;

/// Reads it, whatever it is, and tells whether it could be.
pub fn run(data: &[u8]) -> bool {
    let Some((choice, data)) = data.split_first() else { return false };
    let one = |name: &str| vec![(name.to_owned(), data.to_vec())];
    let model = |names: [&str; 3]| {
        let mut parts = data.splitn(3, |byte| *byte == 0xFF);
        names.map(|name| (name.to_owned(), parts.next().unwrap_or_default().to_vec())).to_vec()
    };
    let files = match choice % 5 {
        0 => one("cameras.json"),
        1 => one("cameras.xml"),
        2 => model(COLMAP_FILES[0]),
        3 => model(COLMAP_FILES[1]),
        _ => {
            let Ok(text) = std::str::from_utf8(data) else { return false };
            return ["lens.yaml", "lens.json"].map(|name| opencv_lens::parse(name, text).is_ok()).contains(&true);
        }
    };
    camera_file::parse(&files).is_ok()
}
