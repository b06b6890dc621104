use super::*;
use crate::optics::{Distortion, Index, Lens, Mat3, trace};
use proptest::prelude::*;

/// A camera at `centre` that looks at `target`, turned about its own axis by `roll`.
fn camera(centre: Vec3, target: Vec3, roll: f64, focal_px: f64) -> View {
    let forward = (target - centre).normalize();
    let right = Vec3::z().cross(&forward).normalize() * -1.0;
    let down = forward.cross(&right);
    let level = Mat3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
    let (sin, cos) = roll.sin_cos();
    let rotation = Mat3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0) * level;
    let distortion = Distortion { k1: -0.08, k2: 0.04, p1: 3e-4, p2: -2e-4, k3: 0.0, ..Distortion::default() };
    let lens = Lens { width: 968, height: 648, focal_px, cx: 488.0, cy: 320.0, distortion };
    View { lens, rotation, translation_mm: -(rotation * centre) }
}

fn tank(radius_mm: f64, wall_mm: f64, index: Index) -> Tank {
    Tank { radius_mm, height_mm: 250.0, wall_mm, water_level_mm: 12.0, index, belts_mm: vec![[0.0, 28.0]] }
}

prop_compose! {
    fn scene()(
        radius in 30.0..200.0f64, wall in 0.01..0.3f64, wall_index in 1.3..1.7f64, water_index in 1.2..1.5f64,
        away in 1.3..12.0f64, azimuth in -3.2..3.2f64, height in -250.0..450.0f64, aside in -0.3..0.3f64,
        target_z in 60.0..190.0f64, roll in -3.2..3.2f64,
    ) -> (View, Tank) {
        let tank = tank(radius, wall * radius, Index { air: 1.0, wall: wall_index, water: water_index });
        let r0 = away * radius;
        let centre = Vec3::new(r0 * azimuth.cos(), r0 * azimuth.sin(), height);
        let target = Vec3::new(-aside * radius * azimuth.sin(), aside * radius * azimuth.cos(), target_z);
        (camera(centre, target, roll, 900.0), tank)
    }
}

/// Moment of a ray in air about the axis and the determinant of its exit point, from traced rays alone.
fn traced_determinant(view: &View, tank: &Tank, direction: &Vec3) -> Option<f64> {
    let centre = view.centre_in_tank();
    let exit = |d: &Vec3| trace(tank, &centre, d).map(|ray| ray.p3_mm);
    // Two directions across the ray that keep (right, down, forward) right-handed.
    let right = view.rotation.row(0).transpose();
    let a = (right - direction * direction.dot(&right)).normalize();
    let b = direction.cross(&a);
    let h = 1e-6;
    let across = |e: &Vec3| {
        let (p, m) = (exit(&(direction + e * h).normalize())?, exit(&(direction - e * h).normalize())?);
        Some((p - m) / (2.0 * h))
    };
    let p3 = exit(direction)?;
    Some(across(&a)?.cross(&across(&b)?).dot(&Vec3::new(p3.x, p3.y, 0.0).normalize()))
}

/// Whether ray (b, s) is regular and passes a point given in the turned frame.
fn meets(map: &ViewMap, (b, s): (f64, f64), point: &Vec3) -> bool {
    let m = map.path.misses(b, s, point.x, point.y, point.z);
    let [fold] = map.fold_moments(&[s]);
    m.f1.abs() < 1e-6 && m.f2.abs() < 1e-6 && b.abs() <= fold * (1.0 + 1e-9)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, max_global_rejects: 100_000, ..ProptestConfig::default() })]

    /// A point on a traced ray is seen where the ray came from, if the ray is regular.
    #[test]
    fn points_of_regular_rays_come_home((view, tank) in scene(), b in -1.0..1.0f64, up in 0.02..0.98f64, along in 0.0..1.0f64) {
        let map = ViewMap::new(&view, &tank).unwrap();
        // Aim at a point of the outer wall that the camera can see.
        let centre = view.centre_in_tank();
        let widest = (tank.radius_mm / map.path.r0).acos();
        let azimuth = centre.y.atan2(centre.x) + b * widest;
        let target = Vec3::new(tank.radius_mm * azimuth.cos(), tank.radius_mm * azimuth.sin(), up * tank.height_mm);
        let direction = (target - centre).normalize();
        prop_assume!(direction.z > map.s_range.0 && direction.z < map.s_range.1);
        let Some(ray) = trace(&tank, &centre, &direction) else { return Ok(()) };
        let Some(determinant) = traced_determinant(&view, &tank, &direction) else { return Ok(()) };
        prop_assume!((view.rotation * direction).z > 0.3);
        let Some((u, v)) = view.pixel_of_direction(&direction) else { return Ok(()) };
        let moment = centre.x * direction.y - centre.y * direction.x;
        let [fold] = map.fold_moments(&[direction.z]);
        if (moment.abs() - fold).abs() > 1e-3 {
            prop_assert_eq!(determinant >= 0.0, moment.abs() < fold, "moment {} fold {} determinant {}", moment, fold, determinant);
        }
        if moment.abs() < fold * (1.0 - 1e-7) {
            let point = ray.p2_mm + (ray.p3_mm - ray.p2_mm) * along;
            let (px, py) = map.turned(point.x, point.y);
            let seen = map.project(&point).ok_or_else(|| TestCaseError::fail(format!("unseen: rho {} of {} {:?} range {:?} s {} fold {} b {}", px.hypot(py), map.path.inner, map.solve(px, py, point.z), map.s_range, direction.z, fold, moment)))?;
            prop_assert!(seen.distance_mm < 1e-6, "{seen:?}");
            if (seen.u - u).hypot(seen.v - v) >= 1e-3 {
                // Steep rays behind a thick wall: two regular ones may pass a point. Either is right.
                let found = map.solve(px, py, point.z).unwrap();
                prop_assert!((found.b - moment).abs() > 1e-6 * tank.inner_radius_mm(), "{found:?} {moment}");
                prop_assert!(meets(&map, (found.b, found.s), &Vec3::new(px, py, point.z)), "{found:?}");
                return Ok(());
            }
            prop_assert!((seen.wall_z_mm - ray.p1_mm.z).abs() < 1e-4 && (seen.water_z_mm - ray.p2_mm.z).abs() < 1e-4);
        }
    }

    /// Rows marched abreast give what single points give; only points beyond the reach rest.
    #[test]
    fn rows_equal_single_points(
        (view, tank) in scene(), height in 0.1..0.9f64, first in -1.0..1.0f64, spacing in 0.02..0.2f64, rests: bool,
    ) {
        let map = ViewMap::new(&view.ideal(), &tank).unwrap();
        let inner = tank.inner_radius_mm();
        let y: [f64; LANES] = std::array::from_fn(|l| (first + spacing * 0.2 * l as f64) * inner);
        let (z, step) = (height * tank.height_mm, spacing * 0.2 * inner);
        let reach = if rests { step } else { f64::INFINITY };
        let mut march = March::new(&map, -inner, &y, z, step, reach);
        for i in 0..(2.0 * inner / step) as usize {
            let x = step * i as f64 - inner;
            let wanted: [bool; LANES] = std::array::from_fn(|l| x.hypot(y[l]) <= inner);
            let lanes = march.column(i, &wanted);
            let Pixels { u, v, .. } = map.clear_pixels(&lanes);
            for l in (0..LANES).filter(|&l| wanted[l]) {
                let one = map.project(&Vec3::new(x, y[l], z));
                if lanes.distance[l] == f64::INFINITY {
                    prop_assert!(rests && one.is_none_or(|one| one.distance_mm >= reach - 1e-6), "{one:?} {l}");
                    continue;
                }
                let Some(one) = one else {
                    prop_assert!(lanes.distance[l].is_nan() || u[l].is_nan());
                    continue;
                };
                let (px, py) = map.turned(x, y[l]);
                if one.distance_mm < 1e-9 && lanes.distance[l] < 1e-9 {
                    let (b, s) = (lanes.b[l], lanes.s[l]);
                    prop_assert!(meets(&map, (b, s), &Vec3::new(px, py, z)), "{lanes:?} {l} {:?}", map.path.misses(b, s, px, py, z));
                    let solved = map.solve(px, py, z).unwrap();
                    if (solved.b - lanes.b[l]).abs() > 1e-6 * inner {
                        // The other of two regular rays through one point.
                        prop_assert!(meets(&map, (solved.b, solved.s), &Vec3::new(px, py, z)), "{solved:?} {b} {s} {:?} {:?}", map.path.misses(solved.b, solved.s, px, py, z), map.fold_moments(&[solved.s]));
                        continue;
                    }
                }
                prop_assert!((one.distance_mm - lanes.distance[l]).abs() < 1e-6, "{one:?} {lanes:?} {l}");
                // Pixels matter in the picture and around it; towards the camera's own plane they run away.
                let pictured = (-968.0..1936.0).contains(&one.u) && (-648.0..1296.0).contains(&one.v);
                if !pictured || one.distance_mm > step {
                    continue;
                }
                if one.clear && !u[l].is_nan() {
                    prop_assert!((one.u - u[l]).hypot(one.v - v[l]) < 1e-3, "{one:?} {lanes:?} {l} {} {}", u[l], v[l]);
                }
                // Both know whether the ray is clear, but for a thousandth of a mm.
                prop_assert!(is_at_an_edge(&tank, &one) || one.clear != u[l].is_nan(), "{one:?} {lanes:?} {l} {}", u[l]);
            }
        }
    }
}

/// Whether the ray of a point meets an edge of what is clear to a thousandth of a mm.
fn is_at_an_edge(tank: &Tank, seen: &Projection) -> bool {
    [0.0, 28.0, tank.height_mm].iter().any(|e| (seen.wall_z_mm - e).abs() < 1e-3)
        || [tank.water_level_mm, tank.floor_mm()].iter().any(|e| (seen.water_z_mm - e).abs() < 1e-3)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, max_global_rejects: 100_000, ..ProptestConfig::default() })]

    /// Stacks give what single points give, whichever planes are asked for.
    #[test]
    fn stacks_equal_single_points(
        (view, tank) in scene(), height in 0.05..0.8f64, first in -1.0..1.0f64, spacing in 0.005..0.03f64, planes in 1usize..33,
    ) {
        let map = ViewMap::new(&view.ideal(), &tank).unwrap();
        let inner = tank.inner_radius_mm();
        let step = spacing * inner;
        let y: [f64; LANES] = std::array::from_fn(|l| first * inner + step * l as f64);
        let heights: Vec<f64> = (0..planes).map(|k| height * tank.height_mm + step * k as f64).collect();
        let mut stack = Stack::new(&map, -inner, &y, heights.clone(), step, false);
        let mut alone = Stack::new(&map, -inner, &y, heights.clone(), step, false);
        for i in 0..(2.0 * inner / step) as usize {
            let x = step * i as f64 - inner;
            let wanted: [bool; LANES] = std::array::from_fn(|l| x.hypot(y[l]) <= inner);
            stack.go_to(i, &wanted);
            alone.go_to(i, &wanted);
            for (k, &z) in heights.iter().enumerate() {
                let found = stack.pixels(k);
                if k == planes / 2 {
                    let same = alone.pixels(k);
                    let bits = |p: &Pixels| [p.u, p.v, p.px_per_mm].map(|v| v.map(f64::to_bits));
                    prop_assert_eq!(bits(&found), bits(&same));
                }
                for l in (0..LANES).filter(|&l| wanted[l]) {
                    let is_seen = !found.u[l].is_nan();
                    let Some(one) = map.project(&Vec3::new(x, y[l], z)) else {
                        prop_assert!(!is_seen);
                        continue;
                    };
                    let pictured = (-968.0..1936.0).contains(&one.u) && (-648.0..1296.0).contains(&one.v);
                    if !pictured || is_at_an_edge(&tank, &one) || (one.distance_mm - step).abs() < 1e-6 {
                        continue;
                    }
                    prop_assert_eq!(is_seen, one.clear && one.distance_mm <= step, "{:?} {} {} {}", one, k, i, l);
                    prop_assert!(
                        !is_seen || (one.u - found.u[l]).hypot(one.v - found.v[l]) < 2e-3,
                        "{:?} {} {} {}: {} {}", one, k, i, l, found.u[l], found.v[l]
                    );
                }
            }
        }
    }
}

#[test]
fn cameras_inside_the_tank_are_refused() {
    let view = camera(Vec3::new(50.0, 0.0, 100.0), Vec3::new(0.0, 0.0, 100.0), 0.0, 900.0);
    let error = ViewMap::new(&view, &tank(90.0, 5.0, Index::default())).unwrap_err();
    assert!(error.message.contains("inside its outer wall"), "{error}");
}

#[test]
fn rays_through_belts_and_over_the_water_are_not_clear() {
    let view = camera(Vec3::new(480.0, 0.0, 100.0), Vec3::new(0.0, 0.0, 100.0), 0.0, 900.0);
    let map = ViewMap::new(&view, &tank(90.0, 5.0, Index::default())).unwrap();
    assert!(!map.project(&Vec3::new(80.0, 0.0, 25.0)).unwrap().clear);
    assert!(map.project(&Vec3::new(80.0, 0.0, 31.0)).unwrap().clear);
    let above = camera(Vec3::new(480.0, 0.0, -100.0), Vec3::new(0.0, 0.0, 100.0), 0.0, 900.0);
    let open = Tank { belts_mm: vec![], ..tank(90.0, 5.0, Index::default()) };
    let map_from_above = ViewMap::new(&above, &open).unwrap();
    assert!(!map_from_above.project(&Vec3::new(-60.0, 0.0, 40.0)).unwrap().clear);
    assert!(map_from_above.project(&Vec3::new(60.0, 0.0, 40.0)).unwrap().clear);
    assert!(map.project(&Vec3::new(86.0, 0.0, 100.0)).is_none());
}
