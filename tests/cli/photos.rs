//! Photographs as they come: turned, named and numbered by cameras, with what shared folders add.

use super::capture::{Capture, stderr};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use std::fs;
use std::path::{Path, PathBuf};

/// The photographs of a capture.
fn photographs(capture: &Capture) -> Vec<PathBuf> {
    let entries = fs::read_dir(capture.path("images")).expect("images");
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.expect("entry").path()).collect();
    paths.sort();
    paths
}

/// Replaces every photograph by what `write` makes of its pixels, under another ending; the cameras name it so.
fn rewritten(capture: &Capture, ending: &str, write: impl Fn(&RgbImage, &Path)) {
    for path in photographs(capture) {
        let pixels = image::open(&path).expect("can open").into_rgb8();
        fs::remove_file(&path).expect("can remove");
        write(&pixels, &path.with_extension(ending));
    }
    let cameras = fs::read_to_string(capture.path("cameras.json")).expect("can read");
    fs::write(capture.path("cameras.json"), cameras.replace(".jpg", &format!(".{ending}"))).expect("can write");
    capture.edit("study.toml", "images/*.jpg", &format!("images/*.{ending}"));
}

/// A PNG with that EXIF data.
fn save_png(pixels: &RgbImage, exif: Vec<u8>, path: &Path) {
    let mut encoder = PngEncoder::new(fs::File::create(path).expect("can create"));
    encoder.set_exif_metadata(exif).expect("PNG holds EXIF data");
    encoder.write_image(pixels, pixels.width(), pixels.height(), ExtendedColorType::Rgb8).expect("can write");
}

/// Little-endian EXIF data of one entry: an orientation.
fn orientation(turn: u8) -> Vec<u8> {
    [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..], &[turn, 0, 0, 0, 0, 0, 0, 0]].concat()
}

/// Little-endian EXIF data whose Exif directory holds DateTimeOriginal.
fn taken(time: &str) -> Vec<u8> {
    let mut data = b"II*\0\x08\0\0\0\x01\0\x69\x87\x04\0\x01\0\0\0\x1a\0\0\0\0\0\0\0".to_vec();
    data.extend(b"\x01\0\x03\x90\x02\0\x14\0\0\0\x2c\0\0\0\0\0\0\0");
    data.extend(time.as_bytes());
    data.push(0);
    data
}

/// Runs the study, expects it to succeed, and hands back what it said.
fn done(capture: &Capture, more: &[&str]) -> String {
    let output = capture.run(more).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{text}");
    text
}

fn roots(capture: &Capture) -> String {
    fs::read_to_string(capture.path("results/tiny/root_voxels.csv")).expect("can read")
}

#[test]
fn portrait_photographs_give_what_upright_ones_give() {
    let upright = Capture::new();
    rewritten(&upright, "png", |pixels, path| save_png(pixels, orientation(1), path));
    done(&upright, &[]);
    let portrait = Capture::new();
    // As a camera stores it that was turned: its right side up.
    rewritten(&portrait, "png", |pixels, path| save_png(&image::imageops::rotate270(pixels), orientation(6), path));
    done(&portrait, &[]);
    assert!(roots(&upright).lines().count() > 20);
    assert_eq!(roots(&upright), roots(&portrait));
    for picture in ["000.jpg", "000-roots.jpg"] {
        let of = |capture: &Capture| fs::read(capture.path("results/tiny/overlays").join(picture)).expect("can read");
        assert!(of(&upright) == of(&portrait), "{picture}");
    }
}

#[test]
fn cameras_of_the_stored_size_are_told_of_the_tag() {
    let capture = Capture::new();
    rewritten(&capture, "png", |pixels, path| save_png(pixels, orientation(8), path));
    let output = capture.run(&[]).output().expect("runs");
    let text = String::from_utf8_lossy(&output.stderr).split_whitespace().collect::<Vec<_>>().join(" ");
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("120 x 160 px") && text.contains("EXIF orientation 8"), "{text}");
}

#[test]
fn sixteen_bits_are_kept_up_to_the_contrast() {
    let eight = Capture::new();
    rewritten(&eight, "png", |pixels, path| pixels.save(path).expect("can save"));
    done(&eight, &[]);
    let sixteen = Capture::new();
    rewritten(&sixteen, "png", |pixels, path| {
        let deep = image::DynamicImage::from(pixels.clone()).into_rgb16();
        deep.save(path).expect("can save");
    });
    let text = done(&sixteen, &[]);
    assert!(!text.contains("several formats"), "{text}");
    // Nearly the same roots: only the steps of undistorted photographs and backgrounds are finer.
    let (a, b) = (roots(&eight).lines().count() as f64, roots(&sixteen).lines().count() as f64);
    assert!(a > 20.0 && (a / b - 1.0).abs() < 0.1, "{a} and {b} root voxels");
    let node = fs::read_dir(sixteen.path("cache/v1/nodes/undistort")).expect("nodes").next().expect("a node");
    let array = fs::read_to_string(node.expect("entry").path().join("photo/zarr.json")).expect("can read");
    assert!(array.contains("\"uint16\""), "{array}");
}

#[test]
fn endings_in_capitals_and_droppings_of_shared_folders() {
    let capture = Capture::new();
    for path in photographs(&capture) {
        fs::rename(&path, path.with_extension("JPG")).expect("can rename");
    }
    let cameras = fs::read_to_string(capture.path("cameras.json")).expect("can read");
    fs::write(capture.path("cameras.json"), cameras.replace(".jpg", ".JPG")).expect("can write");
    for name in ["._000.JPG", "._001.JPG", "Thumbs.db", ".DS_Store", "desktop.ini"] {
        fs::write(capture.path("images").join(name), "no picture").expect("can write");
    }
    let text = done(&capture, &[]);
    assert_eq!(text.matches("note: ").count(), 1, "{text}");
    assert!(text.contains("note: photos.images: 2 files left out"), "{text}");
    let text = done(&capture, &["--set", "photos.images=images/*", "--set", "sweep.extract.high=[0.8, 1.0]"]);
    assert_eq!(text.matches("note: photos.images: 5 files left out").count(), 1, "{text}");
    let text = stderr(&mut capture.run(&["--set", "photos.images=images/*.png"]));
    let text = text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ");
    assert!(text.contains("holds 6 .JPG") && text.contains("images = \"images/*.jpg\""), "{text}");
}

#[test]
fn names_and_times_that_disagree_are_warned_of() {
    let capture = Capture::new();
    rewritten(&capture, "png", |pixels, path| {
        let number: usize = path.file_stem().and_then(|s| s.to_str()).and_then(|s| s.parse().ok()).expect("a number");
        let second = if number == 5 { 30 } else { 40 + number };
        save_png(pixels, taken(&format!("2024:05:01 12:00:{second}")), path);
    });
    let text = done(&capture, &[]);
    let warned =
        "warning: survey: names and times disagree: `005.png` (2024-05-01 12:00:30) was taken before `004.png`";
    assert_eq!(text.matches("names and times").count(), 1, "{text}");
    assert!(text.contains(warned), "{text}");
    let page = fs::read_to_string(capture.path("results/tiny/report.html")).expect("can read");
    assert!(page.contains("names and times disagree"));
}

#[test]
fn photographs_of_several_formats_are_named() {
    let capture = Capture::new();
    rewritten(&capture, "png", |pixels, path| {
        if path.ends_with("003.png") {
            pixels.save_with_format(path, image::ImageFormat::Tiff).expect("can save");
        } else {
            pixels.save(path).expect("can save");
        }
    });
    let text = done(&capture, &[]);
    assert!(text.contains("5 PNG, 1 TIFF (`003.png`)"), "{text}");
    fs::write(capture.path("images/003.tif"), "").expect("can write");
    let text = stderr(&mut capture.run(&["--set", "photos.images=images/*"]));
    assert!(text.contains("`003.png`") && text.contains("`003.tif`"), "{text}");
}

#[test]
fn paths_in_messages_are_clean() {
    let capture = Capture::new();
    fs::create_dir(capture.path("x")).expect("can make");
    fs::rename(capture.path("study.toml"), capture.path("x/study.toml")).expect("can move");
    fs::write(capture.path("images/001.jpg"), "not a picture").expect("can write");
    let mut command = super::capture::rootvox();
    command.current_dir(capture.path("")).args(["run", "x/study.toml"]);
    capture.edit("x/study.toml", "[photos]", "[photos]\ndir = \"../x/./..\"");
    let text = stderr(&mut command);
    assert!(text.contains("photograph `images/001.jpg`"), "{text}");
}
