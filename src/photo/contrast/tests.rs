use super::axis::{Learned, samples};
use super::feature::{ZERO, feature};
use super::*;
use crate::optics::{Distortion, Index, Lens, Mat3, Vec3};
use crate::photo::Picture;

fn tank() -> Tank {
    Tank {
        radius_mm: 90.0,
        height_mm: 246.6,
        wall_mm: 5.0,
        water_level_mm: 12.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
    }
}

/// A camera 480 mm from the axis, looking at it horizontally.
fn view() -> View {
    let lens =
        Lens { width: 240, height: 160, focal_px: 250.0, cx: 120.0, cy: 80.0, distortion: Distortion::default() };
    // Rows: camera x, y, z in the tank frame; it stands on +x and looks along -x.
    let rotation = Mat3::new(0.0, -1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0);
    let centre = Vec3::new(480.0, 0.0, 120.0);
    View { lens, rotation, translation_mm: -(rotation * centre) }
}

/// A room that darkens sideways with noise, and two bent lines of another colour.
fn photograph(root: [f32; 3], seed: u32, roots: bool) -> (Picture, Array2<bool>) {
    let mut state = seed;
    let mut noise = || {
        (0..4)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / (1 << 24) as f32 - 0.5
            })
            .sum::<f32>()
            * 6.0
    };
    let is_root = Array2::from_shape_fn((160, 240), |(y, x)| {
        let (y, x) = (y as f32, x as f32);
        roots && ((y - 60.0 - 12.0 * (x / 17.0).sin()).abs() < 1.2 || (x - 130.0 - 10.0 * (y / 19.0).cos()).abs() < 1.2)
    });
    let picture = Picture::from_shape_fn((160, 240, 3), |(y, x, c)| {
        let room = [70.0, 74.0, 82.0][c] * (0.7 + 0.5 * x as f32 / 240.0);
        let value = if is_root[[y, x]] { room + root[c] } else { room };
        (value + noise()).round().clamp(0.0, 255.0) as u8
    });
    (picture, is_root)
}

#[test]
fn clear_pixels_are_those_between_the_belts() {
    let (view, tank) = (view(), tank());
    let clear = clear::clear_pixels(&view, &tank);
    for ((y, x), &is_clear) in clear.indexed_iter() {
        let ray = crate::optics::trace(&tank, &view.centre_in_tank(), &view.ray_in_tank(x as f64, y as f64));
        let expected = ray.is_some_and(|r| r.p1_mm.z > 28.0 && r.p1_mm.z < 214.6 && r.p2_mm.z > 12.0);
        assert_eq!(is_clear, expected, "{x} {y}");
    }
    assert!(clear[[80, 120]] && !clear[[10, 120]] && !clear[[80, 20]]);
}

#[test]
fn the_room_vanishes_and_roots_of_any_colour_stand_out() {
    let (view, tank) = (view(), tank());
    // Brighter, darker, and of the room's brightness but browner.
    for root in [[60.0, 55.0, 45.0], [-45.0, -48.0, -50.0], [24.0, 0.0, -60.0]] {
        let shots: Vec<_> = (1..4).map(|seed| photograph(root, seed, true)).collect();
        let contrasts: Vec<Contrast> = shots
            .iter()
            .map(|(p, _)| {
                contrast(
                    &Photograph::Eight(p.clone()),
                    &view,
                    &tank,
                    &ContrastParams { blur_mm: 1.0, ..Default::default() },
                )
                .unwrap()
            })
            .collect();
        let axis = Learned::new(contrasts.iter().flat_map(samples)).unwrap();
        assert!(axis.contrast > 5.0, "{root:?}: {axis:?}");
        let (mut on, mut off) = (vec![], vec![]);
        for (c, (_, is_root)) in contrasts.iter().zip(&shots) {
            let picture = feature(c, &axis.axis);
            for ((y, x), _) in is_root.indexed_iter().filter(|(at, _)| c.clear[*at]) {
                let around = |d: usize| {
                    let rows = y.saturating_sub(d)..(y + d + 1).min(160);
                    rows.flat_map(|v| (x.saturating_sub(d)..(x + d + 1).min(240)).map(move |u| (v, u)))
                        .any(|at| is_root[at])
                };
                if around(0) {
                    on.push(f32::from(picture[[y, x, 0]]));
                } else if !around(3) {
                    off.push(f32::from(picture[[y, x, 0]]));
                }
            }
        }
        let mean = |v: &[f32]| v.iter().sum::<f32>() / v.len() as f32;
        assert!(mean(&on) > ZERO + 80.0, "{root:?}: roots at code {}", mean(&on));
        assert!((mean(&off) - ZERO).abs() < 6.0, "{root:?}: water at code {}", mean(&off));
    }
}

#[test]
fn without_roots_the_axis_is_gray() {
    let shots = [photograph([0.0; 3], 9, false).0];
    let contrasts: Vec<_> = shots
        .iter()
        .map(|p| contrast(&Photograph::Eight(p.clone()), &view(), &tank(), &ContrastParams::default()).unwrap())
        .collect();
    let axis = Learned::new(contrasts.iter().flat_map(samples)).unwrap();
    assert!(axis.share < 1e-3, "{axis:?}");
    let ratio = axis.axis.weights[1] / axis.axis.weights[0];
    assert!((ratio - 0.587 / 0.299).abs() < 0.05, "{axis:?}");
}

#[test]
fn bad_input_is_refused() {
    let small = Photograph::Eight(Picture::zeros((10, 10, 3)));
    assert!(contrast(&small, &view(), &tank(), &ContrastParams::default()).unwrap_err().message.contains("10 x 10"));
    let faults = ContrastParams { window_mm: 0.0, blur_mm: f64::NAN, ..Default::default() }.check().unwrap_err();
    assert_eq!(faults.others.len(), 1);
}

#[test]
fn sixteen_bits_show_contrast_that_eight_lose() {
    let (view, tank) = (view(), tank());
    let params = ContrastParams { blur_mm: 0.0, ..Default::default() };
    let (codes, _) = photograph([60.0, 55.0, 45.0], 3, true);
    let coarse = contrast(&Photograph::Eight(codes.clone()), &view, &tank, &params).unwrap();
    let same = contrast(&Photograph::Sixteen(codes.mapv(|c| 257 * u16::from(c))), &view, &tank, &params).unwrap();
    // The same values but for the finer steps of the background.
    assert_eq!(coarse.clear, same.clear);
    assert!(coarse.values.iter().zip(&same.values).all(|(a, b)| (a - b).abs() < 1.0));
    // A line a fifth of a code brighter than an even room.
    let line = |y: usize| y == 80;
    let steps = |y, most: f32| if line(y) { most * 100.2 / 255.0 } else { most * 100.0 / 255.0 };
    let deep = Array3::from_shape_fn((160, 240, 3), |(y, _, _)| steps(y, 65535.0).round() as u16);
    let flat = Array3::from_shape_fn((160, 240, 3), |(y, _, _)| steps(y, 255.0).round() as u8);
    let fine = contrast(&Photograph::Sixteen(deep), &view, &tank, &params).unwrap();
    let lost = contrast(&Photograph::Eight(flat), &view, &tank, &params).unwrap();
    for ((y, x), _) in fine.clear.indexed_iter().filter(|(_, clear)| **clear) {
        let want = if line(y) { 0.2 } else { 0.0 };
        assert!((fine.values[[y, x, 1]] - want).abs() < 0.01, "{y} {x}: {}", fine.values[[y, x, 1]]);
        assert!(lost.values[[y, x, 1]].abs() < 0.01);
    }
}
