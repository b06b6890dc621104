//! The check of a capture: a simulated one of a belted tank, with each fault provoked once.

use rootvox::calibration::check::{Checked, Finding, Glance, Level, check};
use rootvox::optics::{Index, Tank};
use rootvox::photo::Picture;
use rootvox::simulation::{CaptureParams, Scene, capture};
use std::sync::OnceLock;

const VIEWS: usize = 20;

fn photographs() -> &'static [Picture] {
    static PHOTOS: OnceLock<Vec<Picture>> = OnceLock::new();
    PHOTOS.get_or_init(|| taken(&CaptureParams::default()))
}

/// Photographs of 484 px width of a tank without a plant in a furnished room.
fn taken(params: &CaptureParams) -> Vec<Picture> {
    let tank = Tank {
        radius_mm: 50.0,
        height_mm: 150.0,
        wall_mm: 3.0,
        water_level_mm: 12.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 24.0], [126.0, 150.0]],
    };
    let mut params = CaptureParams { views: VIEWS, width: 484, height: 324, supersampling: 2, ..params.clone() };
    params.room.clutter = 0.5;
    let views = capture(&params, &tank, 3).unwrap();
    let scene = Scene::new(&tank, &[], &views, &params, 3).unwrap();
    (0..VIEWS).map(|k| scene.photograph(k, &|_| ())).collect()
}

fn of(photos: &[Picture]) -> Checked {
    let names: Vec<String> = (0..photos.len()).map(|k| format!("{k:02}.jpg")).collect();
    let glances: Vec<Glance> = photos.iter().map(Glance::at).collect();
    check(&glances, &names, true).unwrap()
}

/// The faults' texts; that there is just one, about these photographs.
fn fault(photos: &[Picture], about: &[usize], word: &str) {
    let checked = of(photos);
    let faults: Vec<&Finding> = checked.findings.iter().filter(|f| f.level == Level::Fault).collect();
    assert!(faults.len() == 1 && faults[0].photos == about && faults[0].text.contains(word), "{:#?}", checked.findings);
}

#[test]
fn a_good_capture_has_no_fault() {
    let checked = of(photographs());
    assert!(checked.will_do() && checked.findings.is_empty(), "{:#?}", checked.findings);
    for look in &checked.looks {
        assert!((look.turn_deg.unwrap() - 18.0).abs() < 3.0 && look.blur_px < 0.5, "{look:?}");
    }
}

#[test]
fn each_fault_is_named() {
    let good = photographs();
    let mut photos = good.to_vec();
    photos.truncate(13);
    fault(&photos, &[12, 0], "missing");
    let mut photos = good.to_vec();
    photos.swap(5, 6);
    fault(&photos, &[5], "out of order");
    let mut photos = good.to_vec();
    photos[9] = photos[8].clone();
    let texts: Vec<String> = of(&photos).findings.into_iter().map(|f| f.text).collect();
    assert!(texts[0].contains("`08.jpg` and `09.jpg` are one photograph"), "{texts:#?}");
    let mut photos = good.to_vec();
    photos[4].mapv_inplace(|code| (0.6 * f64::from(code)) as u8);
    fault(&photos, &[4], "light");
    let texts: Vec<String> = of(&good[..9]).findings.into_iter().map(|f| f.text).collect();
    assert!(texts.len() == 2 && texts[0].contains("9 photographs") && texts[1].contains("missing"), "{texts:#?}");
}

#[test]
fn a_bump_is_named_with_its_view() {
    let bumped = taken(&CaptureParams { bump_view: 7, bump_mm: 1.5, bump_deg: 0.3, ..CaptureParams::default() });
    fault(&bumped, &[7], "moved before `07.jpg`");
}

#[test]
fn blur_is_named() {
    // At 484 px width a blur of 1.5 px of 968 px is one of 0.75 px.
    let blurred = taken(&CaptureParams { blur_px: 3.0, ..CaptureParams::default() });
    let mut photos = photographs().to_vec();
    photos[3] = blurred[3].clone();
    fault(&photos, &[3], "blurred more");
    fault(&blurred, &(0..VIEWS).collect::<Vec<_>>(), "are blurred");
}

#[test]
fn belts_without_print_cannot_be_read() {
    let plain: Vec<Picture> = (0..VIEWS).map(|_| Picture::from_elem((324, 484, 3), 90)).collect();
    let texts: Vec<String> = of(&plain).findings.into_iter().map(|f| f.text).collect();
    assert!(texts.iter().any(|t| t.contains("no printed belts")), "{texts:#?}");
}
