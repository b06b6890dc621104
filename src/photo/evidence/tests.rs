//! Whole rooms: what the turn and the window tell of roots before them.

use super::room::{Room, find};
use super::share::{SPAN, ZERO, share};
use super::turn::Still;
use super::{Background, Codes, clear, window};
use crate::optics::{Distortion, Index, Lens, Mat3, Tank, Vec3, View};
use crate::photo::Picture;
use ndarray::Array2;

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

/// What a test room is like.
#[derive(Clone, Copy)]
struct Scene {
    root: [f32; 3],
    /// Bright upright stripes, as of windows.
    windows: bool,
    /// How far the room shifts from view to view, px.
    carried: usize,
    /// Roots per view.
    roots: usize,
}

/// View `v`: the room, and bent roots at places of this view's own, shaded along them.
fn photograph(scene: Scene, v: usize) -> (Picture, Array2<bool>) {
    let mut state = v as u32 + 1;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let lines: Vec<(f32, f32)> = (0..scene.roots).map(|_| (40.0 + 90.0 * random(), random() * 6.0)).collect();
    let is_root = Array2::from_shape_fn((160, 240), |(y, x)| {
        let (y, x) = (y as f32, x as f32);
        (65.0..175.0).contains(&x)
            && lines.iter().any(|(at, phase)| (y - at - 9.0 * (x / 17.0 + phase).sin()).abs() < 1.2)
    });
    let picture = Picture::from_shape_fn((160, 240, 3), |(y, x, c)| {
        let place = x + v * scene.carried;
        let room = [70.0, 74.0, 82.0][c] * (0.7 + 0.5 * (place % 240) as f32 / 240.0);
        let room = if scene.windows && (place / 14).is_multiple_of(2) { [205.0, 215.0, 230.0][c] } else { room };
        let shade = 1.0 + 0.2 * ((x + 3 * y) as f32 / 11.0).sin();
        let value = if is_root[[y, x]] { scene.root[c] * shade } else { room };
        let noise: f32 = (0..4).map(|_| random() - 0.5).sum::<f32>() * 4.0;
        (value + noise).round().clamp(0.0, 255.0) as u8
    });
    (picture, is_root)
}

struct Capture {
    photos: Vec<Picture>,
    roots: Vec<Array2<bool>>,
    room: Room,
    stills: Vec<Still>,
}

fn capture(scene: Scene, views: usize, background: Background) -> Capture {
    let (photos, roots): (Vec<_>, Vec<_>) = (0..views).map(|v| photograph(scene, v)).unzip();
    let (room, stills) = find(&photos, &vec![view(); views], &tank(), background, 15.0, &|| Ok(())).unwrap();
    Capture { photos, roots, room, stills }
}

impl Capture {
    /// Mean share on roots and off them, and mean confidence off them.
    fn shares(&self) -> [f32; 3] {
        let clear = clear::clear_pixels(&view(), &tank());
        let (mut on, mut off, mut sure) = (Vec::new(), Vec::new(), Vec::new());
        for (v, photo) in self.photos.iter().enumerate() {
            let codes: Codes = photo.mapv(f32::from);
            let (background, variance) = match self.room.stills[v] {
                Some(n) => (self.stills[n].background.clone(), self.stills[n].variance.clone()),
                None => {
                    let background = window::background(&codes, &clear, 15.0 * 250.0 / 480.0);
                    let variance = background.mapv(|code| self.room.noise.variance(code));
                    (background, variance)
                }
            };
            let picture = share(&codes, &clear, &background, &variance, &self.room.roots, 0.3);
            for ((y, x), _) in clear.indexed_iter().filter(|(_, clear)| **clear) {
                let near = |d: usize| {
                    let rows = y.saturating_sub(d)..(y + d + 1).min(160);
                    rows.flat_map(|v| (x.saturating_sub(d)..(x + d + 1).min(240)).map(move |u| (v, u)))
                        .any(|at| self.roots[v][at])
                };
                let a = (f32::from(picture[[y, x, 0]]) - ZERO) / SPAN;
                if near(0) && picture[[y, x, 1]] > 127 {
                    on.push(a);
                } else if !near(3) {
                    off.push(a);
                    sure.push(f32::from(picture[[y, x, 1]]) / 255.0);
                }
            }
        }
        [on, off, sure].map(|v| v.iter().sum::<f32>() / v.len().max(1) as f32)
    }
}

const PLAIN: Scene = Scene { root: [170.0, 165.0, 150.0], windows: false, carried: 0, roots: 3 };

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
    // Brighter, darker, and of the room's brightness but browner.
    for root in [[170.0, 165.0, 150.0], [28.0, 26.0, 22.0], [104.0, 76.0, 30.0]] {
        for background in [Background::Turn, Background::Window] {
            let [on, off, sure] = capture(Scene { root, ..PLAIN }, 12, background).shares();
            assert!(on > 0.6 && off.abs() < 0.1 && sure > 0.6, "{root:?} {background:?}: {on} {off} {sure}");
        }
    }
}

#[test]
fn before_windows_the_turn_is_taken_and_roots_stand_out() {
    let capture = capture(Scene { windows: true, ..PLAIN }, 14, Background::Auto);
    assert!(capture.room.stills.iter().all(Option::is_some), "{:?}", capture.room.reasons);
    assert!((capture.room.roots.mean[0] - 170.0).abs() < 25.0, "{:?}", capture.room.roots);
    let [on, off, _] = capture.shares();
    assert!(on > 0.6 && off.abs() < 0.1, "{on} {off}");
}

#[test]
fn a_bush_does_not_become_background() {
    // 18 roots of 2.4 px in 90 rows: four pixels in ten show root.
    let capture = capture(Scene { roots: 18, ..PLAIN }, 20, Background::Auto);
    assert!(capture.room.stills.iter().all(Option::is_some), "{:?}", capture.room.reasons);
    let [on, off, _] = capture.shares();
    assert!(on > 0.6 && off.abs() < 0.1, "{on} {off}");
}

#[test]
fn a_carried_camera_is_judged_by_its_own_surroundings() {
    let carried = capture(Scene { windows: true, carried: 9, ..PLAIN }, 12, Background::Auto);
    assert!(carried.room.stills.iter().all(Option::is_none), "{:?}", carried.room.reasons);
    let few = capture(PLAIN, 4, Background::Auto);
    assert!(few.room.stills.iter().all(Option::is_none), "{:?}", few.room.reasons);
}

#[test]
fn without_roots_their_colour_is_a_guess() {
    let empty = capture(Scene { roots: 0, ..PLAIN }, 8, Background::Auto);
    assert!(!empty.room.learned);
    let [_, off, _] = empty.shares();
    assert!(off.abs() < 0.1, "{off}");
}

#[test]
fn one_thread_finds_what_many_find() {
    let photos: Vec<Picture> = (0..8).map(|v| photograph(PLAIN, v).0).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| find(&photos, &vec![view(); 8], &tank(), Background::Auto, 15.0, &|| Ok(())).unwrap())
    };
    let ((one, still_one), (many, still_many)) = (run(1), run(5));
    assert_eq!(one, many);
    assert!(still_one.iter().zip(&still_many).all(|(a, b)| a.background == b.background && a.variance == b.variance));
}

#[test]
fn photographs_of_another_size_are_refused() {
    let error = find(&[Picture::zeros((10, 10, 3))], &[view()], &tank(), Background::Auto, 15.0, &|| Ok(()));
    assert!(error.unwrap_err().message.contains("10 x 10"));
}

#[test]
fn settings_out_of_range_are_refused() {
    let faults = super::ContrastParams { window_mm: 0.0, blur_mm: f64::NAN, ..Default::default() }.check().unwrap_err();
    assert_eq!(faults.others.len(), 1);
}
