//! Photographs as other programs write them (`tests/data/photographs/make.sh`), held against what those programs make of
//! them.

use rootvox::photo::{Metadata, Photograph, Picture, decode, head};
use std::path::Path;

fn bytes(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/photographs");
    std::fs::read(folder.join(name)).expect("can read")
}

/// A photograph of 8 bits.
fn eight(name: &str) -> Picture {
    match decode(&bytes(name), name).expect("is read") {
        Photograph::Eight(picture) => picture,
        Photograph::Sixteen(_) => panic!("{name} has 16 bits"),
    }
}

#[test]
fn every_orientation_is_what_imagemagick_makes_of_it() {
    let stored = eight("upright.png");
    for orientation in 2..=8 {
        let (tagged, turned) = (format!("tagged-{orientation}.tif"), eight(&format!("turned-{orientation}.png")));
        assert_eq!(eight(&tagged), turned, "{orientation}");
        assert_ne!(turned, stored);
        let head = head(&bytes(&tagged), &tagged).expect("has a head");
        let (height, width, _) = turned.dim();
        assert_eq!((head.orientation, head.size, head.format.as_str()), (orientation, (width, height), "TIFF"));
    }
}

#[test]
fn the_tag_is_found_in_every_format() {
    let turned = eight("turned-6.png");
    for name in ["tagged-6.png", "tagged-6.webp", "big-6.tif"] {
        assert_eq!(eight(name), turned, "{name}");
    }
    // EXIF data behind the pixels of a PNG.
    assert_eq!(eight("behind-6.png"), eight("behind-turned-6.png"));
    // A JPEG is turned bit for bit; its stored pixels are nearly those of the PNG.
    let (stored, tagged) = (eight("stored.jpg"), eight("tagged-6.jpg"));
    for ((y, x, c), &value) in tagged.indexed_iter() {
        assert_eq!(value, stored[[3 - x, y, c]]);
        assert!(value.abs_diff(turned[[y, x, c]]) < 8, "{y} {x}: {value} for {}", turned[[y, x, c]]);
    }
}

#[test]
fn sixteen_bits_are_those_that_imagemagick_lists() {
    let list = String::from_utf8(bytes("deep.txt")).expect("is text");
    for name in ["deep.png", "deep.tif", "deep-big.tif"] {
        let Photograph::Sixteen(picture) = decode(&bytes(name), name).expect("is read") else {
            panic!("{name}: 8 bits")
        };
        let mut count = 0;
        for line in list.lines().skip(1) {
            let (place, rest) = line.split_once(": (").expect("a place");
            let (x, y) = place.split_once(',').expect("a place");
            let values = rest.split_once(')').expect("values").0.split(',');
            for (c, value) in values.enumerate() {
                let at = [y.parse().expect("a row"), x.parse().expect("a column"), c];
                assert_eq!(picture[at].to_string(), value, "{name}: {line}");
                count += 1;
            }
        }
        assert_eq!(count, picture.len());
    }
}

#[test]
fn time_and_focal_length_are_those_that_exiftool_wrote() {
    let metadata = Metadata::of(&bytes("tagged-6.jpg")).expect("has EXIF data");
    assert_eq!(metadata.taken().expect("has a time").to_string(), "2024-05-01 12:00:03.250");
    let focal_px = metadata.focal_px(4, 6).expect("has a focal length");
    assert!((focal_px - 50.0 / 43.267 * 52_f64.sqrt()).abs() < 1e-9);
}

#[test]
fn what_stands_behind_a_jpeg_is_left_alone() {
    let (stored, behind) = (bytes("stored.jpg"), bytes("tagged-6.jpg"));
    // A second picture (as in MPO files), a film (motion photographs), a maker's trailer.
    for more in [behind, bytes("telephone.heic").repeat(40), b"SEFHe\0\0\0SEFT".to_vec()] {
        let both = [stored.clone(), more].concat();
        assert_eq!(decode(&both, "x.jpg").expect("is read"), Photograph::Eight(eight("stored.jpg")));
    }
    let cut = [&stored[..stored.len() - 3], &[0; 5000]].concat();
    assert!(decode(&cut, "x.jpg").expect_err("is cut").message.contains("truncated"));
}

#[test]
fn a_telephones_heic_is_named_with_its_remedy() {
    let e = decode(&bytes("telephone.heic"), "IMG_1.HEIC").expect_err("is not read").to_string();
    assert!(e.contains("`IMG_1.HEIC` is HEIC") && e.contains("heif-convert IMG_1.HEIC IMG_1.png"), "{e}");
}
