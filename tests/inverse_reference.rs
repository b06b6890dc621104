//! The exact inverse against a slow reference that shares nothing with it: a dense search over rays traced
//! forward through both walls, refined until the ray goes through the point.

use proptest::prelude::*;
use rootvox::optics::{Distortion, Index, Lens, Mat3, Tank, Vec3, View, ViewMap, WaterRay, trace};

/// A camera at `centre` that looks at `target`, turned about its own axis by `roll`.
fn camera(centre: Vec3, target: Vec3, roll: f64, focal_px: f64) -> View {
    let forward = (target - centre).normalize();
    let right = forward.cross(&Vec3::z()).normalize();
    let down = forward.cross(&right);
    let level = Mat3::from_rows(&[right.transpose(), down.transpose(), forward.transpose()]);
    let (sin, cos) = roll.sin_cos();
    let rotation = Mat3::new(cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0) * level;
    let lens = Lens { width: 968, height: 648, focal_px, cx: 488.0, cy: 320.0, distortion: Distortion::default() };
    View { lens, rotation, translation_mm: -(rotation * centre) }
}

/// The forward rays of one camera, by the point of the outer wall at which they are aimed.
struct Forward<'a> {
    tank: &'a Tank,
    centre: Vec3,
    azimuth: f64,
}

impl Forward<'_> {
    /// Azimuth of the silhouette, from the camera's.
    fn widest(&self) -> f64 {
        (self.tank.radius_mm / self.centre.xy().norm()).acos()
    }

    fn direction(&self, side: f64, z: f64) -> Vec3 {
        let azimuth = self.azimuth + side;
        let wall = Vec3::new(self.tank.radius_mm * azimuth.cos(), self.tank.radius_mm * azimuth.sin(), z);
        (wall - self.centre).normalize()
    }

    /// None on the far side of the wall, where aims are met in reverse order.
    fn ray(&self, side: f64, z: f64) -> Option<WaterRay> {
        if side.abs() >= self.widest() {
            return None;
        }
        trace(self.tank, &self.centre, &self.direction(side, z))
    }

    /// Paper 2.3.3 by central differences over the wall: the sign of the exit map's determinant against that of
    /// the map onto the wall itself, which every ray from outside keeps.
    fn is_regular(&self, side: f64, z: f64) -> Option<bool> {
        let h = 1e-6;
        let exit = |a: f64, b: f64| self.ray(side + a * h, z + b * h * self.tank.radius_mm).map(|ray| ray.p3_mm);
        let p3 = exit(0.0, 0.0)?;
        let (da, dz) = (exit(1.0, 0.0)? - exit(-1.0, 0.0)?, exit(0.0, 1.0)? - exit(0.0, -1.0)?);
        Some(da.cross(&dz).dot(&Vec3::new(p3.x, p3.y, 0.0)) < 0.0)
    }

    /// Horizontal miss across the ray and vertical miss at the point's foot.
    fn miss(&self, side: f64, z: f64, point: &Vec3) -> Option<[f64; 2]> {
        let ray = self.ray(side, z)?;
        let plan = (ray.v2.x.powi(2) + ray.v2.y.powi(2)).sqrt();
        let (cos, sin) = (ray.v2.x / plan, ray.v2.y / plan);
        let to = point - ray.p2_mm;
        let foot = (to.x * cos + to.y * sin).clamp(0.0, (ray.p3_mm - ray.p2_mm).xy().norm());
        Some([to.x * sin - to.y * cos, ray.p2_mm.z + foot * ray.v2.z / plan - point.z])
    }

    /// The regular ray through the point: the smallest misses and every local minimum over a dense grid are
    /// refined by Newton with differences.
    fn search(&self, point: &Vec3) -> Option<(f64, f64)> {
        const SIDES: usize = 161;
        const HEIGHTS: usize = 81;
        let widest = self.widest();
        let at = |i: usize, k: usize| {
            let side = widest * (2.0 * i as f64 / (SIDES - 1) as f64 - 1.0) * 0.999;
            (side, self.tank.height_mm * k as f64 / (HEIGHTS - 1) as f64)
        };
        let size = |miss: Option<[f64; 2]>| miss.map_or(f64::INFINITY, |m| m[0].hypot(m[1]));
        let field: Vec<f64> = (0..SIDES * HEIGHTS)
            .map(|n| {
                let (side, z) = at(n / HEIGHTS, n % HEIGHTS);
                size(self.miss(side, z, point))
            })
            .collect();
        let mut starts: Vec<usize> = (0..field.len()).filter(|&n| field[n].is_finite()).collect();
        starts.sort_by(|&a, &b| field[a].total_cmp(&field[b]));
        let lowest = |&n: &usize| {
            let (i, k) = (n / HEIGHTS, n % HEIGHTS);
            (i.saturating_sub(1)..(i + 2).min(SIDES))
                .all(|a| (k.saturating_sub(1)..(k + 2).min(HEIGHTS)).all(|b| field[a * HEIGHTS + b] >= field[n]))
        };
        let minima: Vec<usize> = starts.iter().copied().filter(lowest).collect();
        starts.truncate(100);
        starts.extend(minima);
        let mut best: Option<(f64, (f64, f64))> = None;
        for n in starts {
            let (i, k) = (n / HEIGHTS, n % HEIGHTS);
            let (mut side, mut z) = at(i, k);
            for _ in 0..60 {
                let h = 1e-6;
                let (Some(m), Some(a), Some(b)) =
                    (self.miss(side, z, point), self.miss(side + h, z, point), self.miss(side, z + h, point))
                else {
                    break;
                };
                let j = [(a[0] - m[0]) / h, (b[0] - m[0]) / h, (a[1] - m[1]) / h, (b[1] - m[1]) / h];
                let det = j[0] * j[3] - j[1] * j[2];
                let step = [(m[0] * j[3] - m[1] * j[1]) / det, (m[1] * j[0] - m[0] * j[2]) / det];
                // Halved until the miss shrinks.
                let mut scale = 1.0;
                while scale > 1e-6
                    && size(self.miss(side - scale * step[0], z - scale * step[1], point)) >= m[0].hypot(m[1])
                {
                    scale *= 0.5;
                }
                if scale <= 1e-6 {
                    break;
                }
                (side, z) = (side - scale * step[0], z - scale * step[1]);
            }
            let miss = size(self.miss(side, z, point));
            if miss < 1e-7 && self.is_regular(side, z) == Some(true) && best.is_none_or(|(least, _)| miss < least) {
                best = Some((miss, (side, z)));
            }
        }
        best.map(|(_, found)| found)
    }
}

/// Whether moving the point by a thousandth of a mm takes it beyond the fold, or back within it.
fn is_at_fold(map: &ViewMap, point: &Vec3) -> bool {
    let is_regular = |p: &Vec3| map.project(p).is_some_and(|seen| seen.distance_mm < 1e-9);
    let here = is_regular(point);
    [Vec3::x(), Vec3::y(), Vec3::z()].iter().any(|e| {
        [1e-3, -1e-3].iter().any(|step| {
            let moved = point + e * *step;
            is_regular(&moved) != here
        })
    })
}

prop_compose! {
    fn tanks()(
        radius in 40.0..150.0f64, wall in 0.02..0.15f64, thick in prop::bool::weighted(0.2),
        wall_index in 1.33..1.6f64, water_index in 1.3..1.45f64,
    ) -> Tank {
        let wall_mm = if thick { 2.0 * wall } else { wall } * radius;
        let index = Index { air: 1.0, wall: wall_index, water: water_index };
        Tank { radius_mm: radius, height_mm: 250.0, wall_mm, water_level_mm: 12.0, index, belts_mm: vec![] }
    }
}

prop_compose! {
    fn scenes()(
        tank in tanks(), away in 2.0..10.0f64, azimuth in -3.2..3.2f64, tilt in -0.6..0.6f64,
        aside in -0.3..0.3f64, roll in -3.2..3.2f64,
    ) -> (Tank, Vec3, View) {
        let radius = tank.radius_mm;
        let r0 = away * radius;
        let centre = Vec3::new(r0 * azimuth.cos(), r0 * azimuth.sin(), 125.0 + tilt * (r0 - radius));
        let target = Vec3::new(-aside * radius * azimuth.sin(), aside * radius * azimuth.cos(), 125.0);
        (tank, centre, camera(centre, target, roll, 900.0 * away / 5.0))
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Pixels agree to 1e-3 px wherever both find a regular ray, and both find one unless the point lies within
    /// 1e-3 mm of the fold.
    #[test]
    fn the_inverse_finds_what_a_dense_search_finds(
        (tank, centre, view) in scenes(), rho in 0.0..1.0f64, turn in -3.2..3.2f64, depth in 0.2..0.8f64,
        near_wall in any::<bool>(),
    ) {
        let rho = tank.inner_radius_mm() * if near_wall { 1.0 - 0.01 * rho } else { rho.sqrt() };
        let point = Vec3::new(rho * turn.cos(), rho * turn.sin(), depth * tank.height_mm);

        let forward = Forward { tank: &tank, centre, azimuth: centre.y.atan2(centre.x) };
        let reference = forward.search(&point);
        let map = ViewMap::new(&view, &tank).unwrap();
        match (reference, map.project(&point)) {
            (Some((side, z)), Some(exact)) => {
                let (u, v) = view.pixel_of_direction(&forward.direction(side, z)).unwrap();
                prop_assert!(exact.distance_mm < 1e-3, "reference {u} {v}, inverse {exact:?}");
                prop_assert!((exact.u - u).hypot(exact.v - v) < 1e-3, "reference {u} {v}, inverse {exact:?}");
            }
            // What the search has missed must be a regular ray through the point, traced forward.
            (None, Some(exact)) if exact.distance_mm < 1e-9 => {
                let ray = trace(&tank, &centre, &view.ray_in_tank(exact.u, exact.v)).expect("a ray of the inverse");
                let side = ray.p1_mm.y.atan2(ray.p1_mm.x) - forward.azimuth;
                let side = side.sin().atan2(side.cos());
                let miss = forward.miss(side, ray.p1_mm.z, &point).map_or(f64::INFINITY, |m| m[0].hypot(m[1]));
                let confirmed = miss < 1e-4 && forward.is_regular(side, ray.p1_mm.z) == Some(true);
                prop_assert!(confirmed || is_at_fold(&map, &point), "only the inverse, by {miss} mm: {exact:?}");
            }
            (Some((side, z)), None) => {
                // Rays steeper than 48 degrees are left out by definition.
                let steep = forward.direction(side, z).z.abs() > 0.7499;
                prop_assert!(steep, "only the reference: {side} {z}");
            }
            (None, _) => {}
        }
    }

    /// Just within the fold every point of a ray is seen where the ray came from; just beyond it the ray itself is
    /// never taken for a regular one.
    #[test]
    fn the_fold_lies_where_traced_rays_turn(
        (tank, centre, view) in scenes(), height in 0.3..0.7f64, left: bool, away in -6.0..-2.0f64, along in 0.0..1.0f64,
    ) {
        let forward = Forward { tank: &tank, centre, azimuth: centre.y.atan2(centre.x) };
        let z = height * tank.height_mm;
        let sign = if left { -1.0 } else { 1.0 };
        // The fold among the rays to this height of the wall: the first one that is not regular.
        let is_regular = |part: f64| forward.is_regular(sign * part * forward.widest(), z) == Some(true);
        prop_assume!(is_regular(1e-3));
        let first = (1..=200).map(|n| f64::from(n) / 201.0).find(|&part| !is_regular(part));
        let (mut low, mut high) = first.map_or((1.0 - 1e-6, 1.0 - 1e-6), |part| (part - 1.0 / 201.0, part));
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if is_regular(middle) { low = middle } else { high = middle }
        }
        let map = ViewMap::new(&view, &tank).unwrap();
        for (part, regular) in [(low * (1.0 - 10f64.powf(away)), true), (high * (1.0 + 10f64.powf(away)), false)] {
            let side = sign * part * forward.widest();
            let direction = forward.direction(side, z);
            if direction.z.abs() > 0.7 || forward.is_regular(side, z) != Some(regular) {
                continue;
            }
            let Some(ray) = forward.ray(side, z) else { continue };
            let point = ray.p2_mm + (ray.p3_mm - ray.p2_mm) * along;
            let Some(seen) = map.project(&point) else { continue };
            let (u, v) = view.pixel_of_direction(&direction).unwrap();
            let apart = (seen.u - u).hypot(seen.v - v);
            if regular {
                prop_assert!(seen.distance_mm < 1e-3, "{seen:?} for {u} {v}");
                prop_assert!(apart < 1e-3 || is_at_fold(&map, &point), "{seen:?} for {u} {v}");
            } else {
                prop_assert!(apart > 1e-9 || is_at_fold(&map, &point), "{seen:?} is the irregular ray {u} {v}");
            }
        }
    }
}
