use super::*;
use crate::calibration::similarity::first_view_to_azimuth_zero;
use crate::calibration::sparse::Sighting;
use crate::optics::{Distortion, Lens, Mat3, Vec3, View, turn_about_z};
use axis::{AXIS, Axis};
use nalgebra::{DVector, Rotation3};
use normal::outline_residual;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use state::{COMMON, State, on_cylinder};

const RADIUS: f64 = 60.0;
const HEIGHT: f64 = 180.0;

fn truth() -> Vec<View> {
    let lens = Lens {
        width: 800,
        height: 600,
        focal_px: 850.0,
        cx: 401.0,
        cy: 295.0,
        distortion: Distortion { k1: -0.08, k2: 0.03, p1: 3e-4, p2: -2e-4, k3: 0.0, ..Distortion::default() },
    };
    (0..12)
        .map(|i| {
            // Camera 380 mm from the axis, 60 mm below the rim, pitched a little, axis 2 mm off.
            let looks = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0) * turn_about_z(0.53 * f64::from(i));
            let rotation = Rotation3::new(Vec3::new(0.06, 0.01, 0.004)).into_inner() * looks;
            let centre = turn_about_z(-0.53 * f64::from(i)) * Vec3::new(-380.0, 2.0, 60.0);
            View { lens, rotation, translation_mm: -(rotation * centre) }
        })
        .collect()
}

fn pixel(view: &View, x: &Vec3) -> (f64, f64) {
    let c = view.rotation * x + view.translation_mm;
    view.lens.pixel(c.x / c.z, c.y / c.z)
}

/// Belt points at both ends seen from up to 50 degrees off, with noise and some gross errors; rings.
fn network(views: &[View], noise_px: f64, wrong: f64, seed: u64) -> (Network, Vec<Vec3>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1);
    let (mut tracks, mut points) = (Vec::new(), Vec::new());
    for k in 0..400 {
        let z = if k % 2 == 0 { 20.0 * rng.random::<f64>() } else { HEIGHT - 20.0 * rng.random::<f64>() };
        let (x, _) = on_cylinder(RADIUS, std::f64::consts::TAU * rng.random::<f64>(), z);
        let mut seen = Vec::new();
        for (view, v) in views.iter().enumerate() {
            let to = v.centre_in_tank() - x;
            if (to.x * x.x + to.y * x.y) / (to.norm() * RADIUS) > 0.64 {
                let (u, v) = pixel(v, &x);
                let slip = if rng.random::<f64>() < wrong { 30.0 } else { noise_px };
                seen.push(Sighting { view, u: u + slip * normal(), v: v + slip * normal() });
            }
        }
        if seen.len() >= 3 {
            tracks.push(seen);
            points.push(x);
        }
    }
    let ring = |name: &str, z_mm, outward| Contour {
        name: name.into(),
        radius_mm: RADIUS,
        shape: Shape::Ring { z_mm, outward },
    };
    let mut contours = vec![ring("rim", 0.0, -1.0), ring("floor", HEIGHT, 1.0)];
    let mut outline = Vec::new();
    for (view, v) in views.iter().enumerate() {
        let c = v.centre_in_tank();
        for (contour, z_mm) in [0.0, HEIGHT].into_iter().enumerate() {
            for side in [-0.8, -0.4, 0.0, 0.4, 0.8] {
                let azimuth = c.y.atan2(c.x) + side;
                let (u, v) = pixel(v, &on_cylinder(RADIUS, azimuth, z_mm).0);
                outline.push(OutlinePoint { view, contour, u, v: v + noise_px * normal(), along: azimuth });
            }
        }
    }
    for turn in [-1.0, 1.0] {
        let shape = Shape::Side { z_mm: [0.0, 20.0], turn };
        for (view, v) in views.iter().enumerate() {
            let azimuth = Contour::side_azimuth(turn, RADIUS, &v.centre_in_tank()).expect("outside");
            let (u, v) = pixel(v, &on_cylinder(RADIUS, azimuth, 12.0).0);
            // The start along the side is off.
            outline.push(OutlinePoint { view, contour: contours.len(), u: u + noise_px * normal(), v, along: 9.0 });
        }
        contours.push(Contour { name: "side".into(), radius_mm: RADIUS, shape });
    }
    (
        Network {
            belt_radius_mm: RADIUS,
            tracks,
            redundancy: 1.0,
            contours,
            outline,
            focal_prior_px: None,
            holds_lens: false,
        },
        points,
    )
}

fn disturbed(views: &[View], points_mm: Vec<Vec3>) -> Start {
    let mut views = views.to_vec();
    for (k, v) in views.iter_mut().enumerate() {
        v.lens.focal_px = 870.0;
        v.lens.cx = 399.5;
        v.lens.cy = 299.5;
        v.lens.distortion = Distortion { k1: -0.1, ..Distortion::default() };
        let wobble = Vec3::new(0.01, 0.005 * (k as f64).sin(), 0.002);
        v.rotation = Rotation3::new(wobble).into_inner() * v.rotation;
        v.translation_mm += Vec3::new(1.0, 3.0, 8.0);
    }
    Start { views, points_mm }
}

/// Largest distance in px between where two sets of views see points in the tank, after the free turn.
fn worst_px(a: &[View], b: &[View]) -> f64 {
    let (mut a, mut b) = (a.to_vec(), b.to_vec());
    first_view_to_azimuth_zero(&mut a);
    first_view_to_azimuth_zero(&mut b);
    let mut worst: f64 = 0.0;
    for (v, w) in a.iter().zip(&b) {
        for x in [Vec3::new(40.0, 10.0, 20.0), Vec3::new(-30.0, 0.0, 90.0), Vec3::new(0.0, -45.0, 160.0)] {
            let (p, q) = (pixel(v, &x), pixel(w, &x));
            worst = worst.max((p.0 - q.0).hypot(p.1 - q.1));
        }
    }
    worst
}

#[test]
fn exact_observations_give_the_truth_back() {
    let views = truth();
    let (network, points) = network(&views, 0.0, 0.0, 1);
    // Weak priors: they must not pull.
    let params = AdjustParams {
        radius_sigma_mm: 0.0,
        tangential_sigma: 1.0,
        radial_sigma: 10.0,
        principal_point_sigma: 1.0,
        ..AdjustParams::default()
    };
    let out = adjust(&network, &disturbed(&views, points), &params).unwrap();
    assert!(worst_px(&out.views, &views) < 0.01, "{} px", worst_px(&out.views, &views));
    assert!((out.views[0].lens.focal_px - 850.0).abs() < 0.1, "f {}", out.views[0].lens.focal_px);
}

#[test]
fn a_known_lens_stays_and_helps() {
    let views = truth();
    let (mut network, points) = network(&views, 0.3, 0.0, 5);
    let mut start = disturbed(&views, points);
    start.views.iter_mut().for_each(|view| view.lens = views[0].lens);
    let free = adjust(&network, &start, &AdjustParams::default()).unwrap();
    network.holds_lens = true;
    let held = adjust(&network, &start, &AdjustParams::default()).unwrap();
    assert_eq!(held.views[0].lens, views[0].lens);
    assert_ne!(free.views[0].lens, views[0].lens);
    assert_eq!((held.uncertainty.focal_px, held.uncertainty.distortion), (0.0, [0.0; 5]));
    assert!(held.uncertainty.wall_px > 0.0 && held.uncertainty.wall_px < free.uncertainty.wall_px);
}

#[test]
fn gross_errors_hardly_pull_and_the_uncertainty_covers_the_error() {
    let views = truth();
    let (network, points) = network(&views, 0.1, 0.05, 2);
    let out = adjust(&network, &disturbed(&views, points), &AdjustParams::default()).unwrap();
    let u = &out.uncertainty;
    // Three times what the uncertainty says of a root mean square.
    assert!(worst_px(&out.views, &views) < 3.0 * u.wall_px, "{} px", worst_px(&out.views, &views));
    assert!(
        (out.views[0].lens.focal_px - 850.0).abs() < 4.0 * u.focal_px,
        "f {} ± {}",
        out.views[0].lens.focal_px,
        u.focal_px
    );
    let height = |v: &[View]| v.iter().map(|v| v.centre_in_tank().z).sum::<f64>() / v.len() as f64;
    assert!((height(&out.views) - height(&views)).abs() < 4.0 * u.height_mm);
    assert!(u.height_mm > 0.001 && u.height_mm < 0.5 && u.wall_px < 0.5, "{u:?}");
}

#[test]
fn too_few_points_are_an_error_with_a_remedy() {
    let views = truth();
    let (mut network, mut points) = network(&views, 0.1, 0.0, 3);
    network.tracks.truncate(3);
    points.truncate(3);
    let e = adjust(&network, &disturbed(&views, points), &AdjustParams::default()).unwrap_err();
    assert!(e.message.contains("3 belt points") && e.help.is_some(), "{e}");
}

#[test]
fn derivatives_agree_with_differences() {
    let views = truth();
    let mut state = poses(&views);
    state.lens.distortion.k3 = 0.01;
    let x = Vec3::new(30.0, -40.0, 25.0);
    let p = state.project(2, &x).unwrap();
    let h = 1e-6;
    for k in (0..state.size()).filter(|k| *k != COMMON - 1) {
        let mut step = DVector::zeros(state.size());
        step[k] = h;
        let difference = (state.stepped(&step).project(2, &x).unwrap().pixel - p.pixel) / h;
        let at = state.pose_index(2);
        let analytic = if k < COMMON {
            p.by_common.column(k).into_owned()
        } else if (at..at + 6).contains(&k) {
            p.by_pose.column(k - at).into_owned()
        } else {
            nalgebra::Vector2::zeros()
        };
        assert!(
            (difference - analytic).norm() < 1e-3 * (1.0 + analytic.norm()),
            "unknown {k}: {difference} {analytic}"
        );
    }
    for k in 0..3 {
        let difference = (state.project(2, &(x + Vec3::ith(k, h))).unwrap().pixel - p.pixel) / h;
        assert!((difference - p.by_point.column(k)).norm() < 1e-4, "point {k}");
    }
}

/// The state whose poses are the views.
fn poses(views: &[View]) -> State {
    State {
        lens: views[0].lens,
        thicker_mm: 0.0,
        poses: views.iter().map(|v| (v.rotation, v.translation_mm)).collect(),
        points: vec![],
        along: vec![],
        offsets: vec![],
        axis: None,
    }
}

#[test]
fn an_axis_beside_the_tanks_is_found_and_its_derivatives_agree_with_differences() {
    // The tank stands 3 mm beside the table's axis and leans by 0.02.
    let lean = Rotation3::new(Vec3::new(0.02, 0.0, 0.0)).into_inner();
    let beside = |v: &View| View {
        rotation: v.rotation * lean,
        translation_mm: v.translation_mm + v.rotation * Vec3::new(3.0, 0.0, 0.0),
        ..v.clone()
    };
    let state = poses(&truth().iter().map(beside).collect::<Vec<_>>());
    let axis = Axis::fitted(&state, 90.0);
    let play = axis.play(&state);
    let found = axis.turning(&play, &state);
    assert_eq!(found.bump, None);
    assert!(play.wobble < 1e-9 && play.play_mm < 1e-7, "{play:?}");
    assert!((found.tilt_deg.to_radians() - 0.02).abs() < 1e-6, "{found:?}");
    // At half the height the leaning has moved it by 90 sin 0.02 more, across.
    assert!((found.offset_mm - (9.0 + 1.8_f64.powi(2)).sqrt()).abs() < 0.01, "{found:?}");

    let mut state = poses(&truth());
    state.axis = Some((Axis { tilt: [0.01, -0.02], point_mm: [2.0, 1.0], ..axis }, play));
    let at = |state: &State| state.axis.unwrap().0.residual(&state.poses[3]);
    let (here, h) = (at(&state), 1e-6);
    for k in 0..state.size() {
        let mut step = DVector::zeros(state.size());
        step[k] = h;
        let there = at(&state.stepped(&step));
        let numeric = [(there.wobble - here.wobble) / h, (there.play_mm - here.play_mm) / h];
        for (part, numeric) in numeric.into_iter().enumerate() {
            let analytic = if (state.axis_index()..state.axis_index() + AXIS).contains(&k) {
                here.by_axis[part].column(k - state.axis_index()).into_owned()
            } else if (state.pose_index(3)..state.pose_index(4)).contains(&k) {
                here.by_pose[part].column(k - state.pose_index(3)).into_owned()
            } else {
                Vec3::zeros()
            };
            assert!((numeric - analytic).norm() < 1e-4 * (1.0 + analytic.norm()), "{part} {k}: {numeric} {analytic}");
        }
    }
}

#[test]
fn a_bump_is_found_where_it_was() {
    let bumped = |view: usize, moved_mm: f64| {
        let mut views = truth();
        for v in &mut views[view..] {
            v.translation_mm.y += moved_mm;
        }
        let state = poses(&views);
        let axis = Axis::fitted(&state, 90.0);
        axis.turning(&axis.play(&state), &state).bump
    };
    let found = bumped(5, 1.5).unwrap();
    assert!(found.view == 5 && (found.moved_mm - 1.5).abs() < 0.01 && found.turned_deg < 0.01, "{found:?}");
    assert_eq!(bumped(5, 0.01), None);
}

#[test]
fn one_axis_helps_where_the_table_turns_and_hardly_hurts_where_it_does_not() {
    let error = |views: &[View], one_axis: bool| {
        let sum: f64 = (10..30)
            .map(|seed| {
                let (mut network, mut points) = network(views, 0.3, 0.0, seed);
                network.tracks.truncate(60);
                points.truncate(60);
                let params = AdjustParams { one_axis, ..AdjustParams::default() };
                let out = adjust(&network, &disturbed(views, points), &params).unwrap();
                worst_px(&out.views, views)
            })
            .sum();
        sum / 20.0
    };
    let still = truth();
    let (with, without) = (error(&still, true), error(&still, false));
    assert!(with < without, "one axis: {with} px with the prior, {without} px without");
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut loose = || rng.random::<f64>() - 0.5;
    let wobbling: Vec<View> = still
        .iter()
        .map(|v| View {
            rotation: Rotation3::new(Vec3::new(loose(), loose(), loose()) * 0.01).into_inner() * v.rotation,
            translation_mm: v.translation_mm + Vec3::new(loose(), loose(), loose()) * 4.0,
            ..v.clone()
        })
        .collect();
    let (with, without) = (error(&wobbling, true), error(&wobbling, false));
    assert!(with < 1.1 * without, "no axis: {with} px with the prior, {without} px without");
}

#[test]
fn a_side_tells_as_much_of_a_pose_as_differences_say() {
    let views = truth();
    let (network, _) = network(&views, 0.0, 0.0, 4);
    let k = network.outline.iter().position(|o| network.contours[o.contour].is_side() && o.view == 2).unwrap();
    let mut state = poses(&views);
    state.offsets = vec![0.0; network.contours.len()];
    state.along = network.outline.iter().map(|o| o.along).collect();
    let here = outline_residual(&network, &state, k).unwrap();
    assert!(here.value.abs() < 1e-6 && (here.along - 12.0).abs() < 1e-3, "{} at {}", here.value, here.along);
    let (at, h) = (state.pose_index(2), 1e-6);
    for unknown in (0..COMMON).chain(at..at + 6) {
        let mut step = DVector::zeros(state.size());
        step[unknown] = h;
        let numeric = outline_residual(&network, &state.stepped(&step), k).unwrap().value / h;
        let analytic = match unknown.checked_sub(at) {
            None => here.normal.dot(&here.projection.by_common.column(unknown)),
            Some(unknown) => here.normal.dot(&here.projection.by_pose.column(unknown)),
        };
        assert!((numeric - analytic).abs() < 1e-3 * (1.0 + analytic.abs()), "{unknown}: {numeric} {analytic}");
    }
}
