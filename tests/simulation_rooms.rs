//! Photographs in rooms with things in them, by cameras that are bumped or carried, in light that changes; and that none of
//! it touches a capture that does not ask for it.

use ndarray::Array3;
use rootvox::optics::{Index, Tank, Vec3, View};
use rootvox::simulation::{CaptureParams, GrowthParams, OtherLight, RoomParams, Scene, capture, grow};

const SEED: u64 = 5;

fn tank() -> Tank {
    Tank {
        radius_mm: 40.0,
        height_mm: 120.0,
        wall_mm: 3.0,
        water_level_mm: 10.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 16.0], [104.0, 120.0]],
    }
}

/// A capture without noise, lens errors or stem: what differs between pictures is what the scene differs in.
fn still() -> CaptureParams {
    CaptureParams {
        views: 4,
        width: 240,
        height: 160,
        noise_sigma: 0.0,
        stem: false,
        table_offset_mm: 0.0,
        ..Default::default()
    }
}

fn furnished() -> CaptureParams {
    CaptureParams { room: RoomParams { clutter: 0.7, windows: 2, lamps: 2, ..RoomParams::default() }, ..still() }
}

fn photographed(params: &CaptureParams) -> (Vec<View>, Vec<Array3<u8>>) {
    let roots = grow(&GrowthParams::default(), &tank(), SEED).unwrap();
    let views = capture(params, &tank(), SEED).unwrap();
    let scene = Scene::new(&tank(), &roots, &views, params, SEED).unwrap();
    let pictures = (0..views.len()).map(|view| scene.photograph(view, &|_| ())).collect();
    (views, pictures)
}

/// Whether a pixel looks past tank and table top by 5 mm and more.
fn is_outside(view: &View, x: usize, y: usize) -> bool {
    let (o, d) = (view.centre_in_tank(), view.ray_in_tank(x as f64, y as f64));
    let nearest = |radius_mm: f64, low: f64, high: f64| {
        (0..4000).map(|i| o + d * (0.25 * f64::from(i))).any(|p| p.x.hypot(p.y) < radius_mm && p.z > low && p.z < high)
    };
    !nearest(45.0, -5.0, 125.0) && !nearest(65.0, 118.0, 124.0)
}

fn outside(view: &View, picture: &Array3<u8>) -> Vec<([usize; 2], [u8; 3])> {
    let (height, width, _) = picture.dim();
    let places = (0..height).step_by(4).flat_map(|y| (0..width).step_by(4).map(move |x| [x, y]));
    places
        .filter(|[x, y]| is_outside(view, *x, *y))
        .map(|[x, y]| ([x, y], [0, 1, 2].map(|k| picture[[y, x, k]])))
        .collect()
}

#[test]
fn the_room_stands_still_before_a_turning_table() {
    let (views, pictures) = photographed(&furnished());
    let first = outside(&views[0], &pictures[0]);
    assert!(first.len() > 400, "{}", first.len());
    for (view, picture) in views.iter().zip(&pictures) {
        assert_eq!(outside(view, picture), first);
    }
    // It is full of things: brighter and darker, redder and bluer than any plain room.
    let brightest = first.iter().map(|(_, p)| p[1]).max().unwrap();
    let colours: Vec<i32> = first.iter().map(|(_, p)| i32::from(p[0]) - i32::from(p[2])).collect();
    assert!(brightest > 200 && *colours.iter().max().unwrap() > 30 && *colours.iter().min().unwrap() < -30);
    // And it is seen through the tank.
    let middle = |p: &Array3<u8>| (40..200).map(|x| i32::from(p[[80, x, 1]])).collect::<Vec<_>>();
    assert_ne!(middle(&pictures[0]), middle(&photographed(&still()).1[0]));
}

#[test]
fn a_bump_moves_the_picture_of_the_room_as_the_truth_says() {
    let bumped = CaptureParams { bump_view: 2, bump_deg: 2.0, ..furnished() };
    let (views, pictures) = photographed(&bumped);
    let (before, after) = (outside(&views[0], &pictures[0]), outside(&views[2], &pictures[2]));
    assert_eq!(outside(&views[1], &pictures[1]), before);
    assert_eq!(outside(&views[3], &pictures[3]), after);
    // A camera that only turned sees the same room, elsewhere in the picture: as the true cameras have it.
    let steady = capture(&furnished(), &tank(), SEED).unwrap();
    let (mut moved, mut kept, mut count) = (0.0, 0.0, 0);
    for ([x, y], pixel) in &after {
        let direction =
            steady[0].rotation.transpose() * (steady[2].rotation * views[2].ray_in_tank(*x as f64, *y as f64));
        let Some((u, v)) = steady[0].pixel_of_direction(&direction) else { continue };
        let (u, v) = (u.round(), v.round());
        if steady[0].holds(u, v) && is_outside(&steady[0], u as usize, v as usize) {
            let off = |x: usize, y: usize| f64::from(pixel[1]) - f64::from(pictures[0][[y, x, 1]]);
            moved += off(u as usize, v as usize).abs();
            kept += off(*x, *y).abs();
            count += 1;
        }
    }
    assert!(count > 300 && moved < 0.4 * kept, "{count} {moved} {kept}");
}

#[test]
fn a_carried_camera_walks_about_in_a_room_that_stays_with_the_tank() {
    let params = CaptureParams { views: 8, carried: true, front_level: 0.1, ..furnished() };
    let (views, pictures) = photographed(&params);
    let pixels = |i: usize| outside(&views[i], &pictures[i]);
    for i in 1..8 {
        let mean = |v: &[([usize; 2], [u8; 3])]| v.iter().map(|(_, p)| f64::from(p[1])).sum::<f64>() / v.len() as f64;
        assert!(pixels(i) != pixels(0) && (mean(&pixels(i)) - mean(&pixels(0))).abs() > 0.5);
    }
    // The lamps stay as well: a patch of the upper belt is as bright from all sides from which it is seen.
    let patch = |azimuth: f64, view: &View, picture: &Array3<u8>| -> Option<f64> {
        let at = |z: f64| Vec3::new(40.1 * azimuth.cos(), 40.1 * azimuth.sin(), z);
        let towards = view.centre_in_tank() - at(8.0);
        (towards.normalize().dot(&(at(0.0) / 40.1)) > 0.5).then_some(())?;
        let level = |z: f64, turn: f64| {
            let p = at(z) + Vec3::new(-azimuth.sin(), azimuth.cos(), 0.0) * turn;
            let (u, v) = view.pixel_of_direction(&(p - view.centre_in_tank())).unwrap();
            f64::from(picture[[v.round() as usize, u.round() as usize, 1]])
        };
        Some(
            (4..13)
                .flat_map(|z| (-8..9).map(move |t| (z, t)))
                .map(|(z, t)| level(f64::from(z), f64::from(t)))
                .sum::<f64>()
                / 153.0,
        )
    };
    let mut compared = 0;
    for k in 0..24 {
        let azimuth = f64::from(k) * std::f64::consts::TAU / 24.0;
        let seen: Vec<f64> = views.iter().zip(&pictures).filter_map(|(v, p)| patch(azimuth, v, p)).collect();
        for other in seen.iter().skip(1) {
            assert!((other - seen[0]).abs() < 15.0, "{azimuth}: {seen:?}");
            compared += 1;
        }
    }
    assert!(compared > 20, "{compared}");
}

#[test]
fn another_light_is_brighter_by_its_gain_and_shines_from_elsewhere() {
    let linear = |level: u8| f64::from(rootvox::photo::colour::linear_of_srgb(f32::from(level) / 255.0));
    let light = OtherLight { views: vec![1, 3], gain: [1.5, 1.2, 0.8], lamp_direction: None };
    let usual = photographed(&still()).1;
    let other = photographed(&CaptureParams { other_light: vec![light.clone()], ..still() }).1;
    assert!(usual[0] == other[0] && usual[2] == other[2]);
    for (k, gain) in light.gain.iter().enumerate() {
        let mut ratios = Vec::new();
        for (a, b) in usual[1].iter().zip(&other[1]).skip(k).step_by(3).filter(|(a, _)| (60..180).contains(*a)) {
            ratios.push(linear(*b) / linear(*a));
        }
        let mean = ratios.iter().sum::<f64>() / ratios.len() as f64;
        assert!((mean - gain).abs() < 0.01, "{k}: {mean}");
    }
    let moved = OtherLight { gain: [1.0; 3], lamp_direction: Some([0.8, -0.2, -0.3]), ..light };
    let moved = photographed(&CaptureParams { other_light: vec![moved], ..still() }).1;
    assert!(usual[0] == moved[0] && usual[1] != moved[1]);
}

#[test]
fn bits_and_glints_turn_with_the_tank_and_are_no_roots() {
    let params =
        CaptureParams { drifting: 30, drifting_mm: 1.5, bubbles: 60, bubble_mm: 1.5, bubble_glint: 1.0, ..still() };
    let (views, pictures) = photographed(&params);
    let (_, usual) = photographed(&still());
    for ((view, picture), usual) in views.iter().zip(&pictures).zip(&usual) {
        assert_eq!(outside(view, picture), outside(view, usual));
        let differ = picture.iter().zip(usual).filter(|(a, b)| a.abs_diff(**b) > 8).count();
        let brighter = picture.iter().zip(usual).filter(|(a, b)| a.saturating_sub(**b) > 60).count();
        assert!(differ > 200 && brighter > 20, "{differ} {brighter}");
    }
    let roots = |p: &CaptureParams| capture(p, &tank(), SEED).unwrap();
    assert_eq!(roots(&params), roots(&still()));
}

/// The pixels of captures without rooms, as they were before there were any.
#[test]
fn captures_that_ask_for_none_of_it_are_what_they_were() {
    let restless = CaptureParams {
        views: 3,
        sway_mm: 1.0,
        exposure_drift: 0.1,
        dirt: 60,
        bubbles: 60,
        blur_px: 1.0,
        ..CaptureParams { width: 240, height: 160, ..Default::default() }
    };
    let mut hash = blake3::Hasher::new();
    for picture in photographed(&restless).1 {
        hash.update(picture.as_slice().unwrap());
    }
    assert_eq!(hash.finalize().to_hex().as_str(), "526f2bc792fcabbe2c9bf6f872a4c5a1d672fc0a49bbebd3fbfb0ea66c6953f6");
}
