//! Camera files with damage: every parser answers with a model or an error, and never panics.

use proptest::prelude::*;
use rootvox::formats::camera_file::{self, Format};
use rootvox::formats::{NamedView, opencv_lens};
use rootvox::optics::{Distortion, Lens, Mat3, Model, Vec3, View};
use std::fmt::Write;

type Files = Vec<(String, Vec<u8>)>;

fn views() -> Vec<NamedView> {
    let distortion = Distortion { model: Model::Fisheye, k1: -0.1, b1: 2.0, ..Distortion::default() };
    let lens = Lens { width: 96, height: 64, focal_px: 90.0, cx: 48.2, cy: 31.1, distortion };
    let view = |k: u32| View { lens, rotation: Mat3::identity(), translation_mm: Vec3::new(f64::from(k), 0.25, 300.0) };
    (0..3).map(|k| NamedView { file: format!("{k}.jpg"), view: view(k) }).collect()
}

/// A file of every format that is read.
fn samples() -> Vec<Files> {
    let mut all: Vec<Files> = [Format::CamerasJson, Format::Colmap, Format::TransformsJson]
        .into_iter()
        .map(|format| {
            let files = camera_file::write(&views(), format).expect("can be written");
            files.into_iter().map(|(name, text)| (name.to_owned(), text.into_bytes())).collect()
        })
        .collect();
    let mut xml = String::from(
        "<document><chunk><sensors><sensor id=\"0\"><calibration type=\"frame\" class=\"adjusted\"><resolution width=\"96\" \
         height=\"64\"/><f>90</f><k1>-0.1</k1></calibration></sensor></sensors><cameras>",
    );
    for k in 0..3 {
        let _ = write!(
            xml,
            "<camera sensor_id=\"0\" label=\"{k}\"><transform>1 0 0 {k} 0 1 0 0 0 0 1 5 0 0 0 1</transform></camera>"
        );
    }
    all.push(vec![("cameras.xml".into(), (xml + "</cameras></chunk></document>").into_bytes())]);
    all
}

/// The bytes with some replaced, cut off or repeated.
fn damaged(bytes: &[u8], at: usize, with: &[u8], cut: usize) -> Vec<u8> {
    let at = at % (bytes.len() + 1);
    let rest = &bytes[(at + cut).min(bytes.len())..];
    [&bytes[..at], with, rest].concat()
}

#[test]
fn the_samples_are_read() {
    for files in samples() {
        assert_eq!(camera_file::parse(&files).expect("is read").views.len(), 3, "{}", files[0].0);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn damage_is_no_panic(
        sample in 0..4_usize,
        file in 0..3_usize,
        at in any::<usize>(),
        with in prop_oneof![
            prop::collection::vec(any::<u8>(), 0..6),
            prop::sample::select(vec!["-1", "1e999", "NaN", "[", "{", "\"", "<", "&", "0", "\n", " ", "99999999999999999999"])
                .prop_map(|word| word.as_bytes().to_vec()),
        ],
        cut in 0..40_usize,
    ) {
        let mut files = samples().swap_remove(sample);
        let file = file % files.len();
        files[file].1 = damaged(&files[file].1, at, &with, cut);
        let _ = camera_file::parse(&files);
    }

    #[test]
    fn a_damaged_calibration_is_no_panic(at in any::<usize>(), with in prop::collection::vec(any::<u8>(), 0..6), cut in 0..40_usize) {
        for text in [include_str!("data/lenses/calibration.yml"), include_str!("data/lenses/calibration.json")] {
            let text = damaged(text.as_bytes(), at, &with, cut);
            let _ = opencv_lens::parse("c", &String::from_utf8_lossy(&text));
        }
    }
}
