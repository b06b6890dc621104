//! `rootvox export figure`.

use super::capture::{Capture, rootvox};
use std::fs;

#[test]
fn a_figure_comes_in_every_form_and_bad_ones_are_refused() {
    let capture = Capture::new();
    capture.run(&[]).assert().success();
    let export = |arguments: &[&str]| {
        let mut command = rootvox();
        command.current_dir(capture.path("")).args(["export", "figure"]).args(arguments);
        let output = command.output().expect("runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for (out, begins) in [("f.svg", &b"<svg "[..]), ("f.pdf", b"%PDF-"), ("f.png", b"\x89PNG")] {
        let (code, text) = export(&["results/tiny", "--colour", "diameter", "--width", "85", "-o", out]);
        assert_eq!(code, Some(0), "{text}");
        let bytes = fs::read(capture.path(out)).expect("is there");
        assert!(bytes.starts_with(begins), "{out} begins with {:?}", &bytes[..8]);
    }
    // 85 mm at 600 dots per inch, and lines in it.
    let picture = image::open(capture.path("f.png")).expect("is a picture").to_rgb8();
    assert_eq!(picture.width(), 2008);
    let dark = picture.pixels().filter(|p| p.0.iter().all(|c| *c < 90)).count();
    assert!(dark > 500, "{dark} dark pixels: scale bar and letters");
    for (arguments, word) in [
        (&["results/tiny", "-o", "f.tif"][..], ".svg, .pdf or .png"),
        (&["results/tiny", "--width", "5", "-o", "f.svg"], "50 to 1000"),
        (&["images", "-o", "f.svg"], "no results folder"),
    ] {
        let (code, text) = export(arguments);
        assert_eq!(code, Some(2), "{text}");
        assert!(text.contains(word), "{text}");
    }
}
