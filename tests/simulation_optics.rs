//! The simulated photographs against light that obeys Fermat's principle.
//!
//! The judge knows nothing of Snell's law in vector form: it finds the points on the outer and inner wall for which the
//! optical length n₁|C p₁| + n₂|p₁ p₂| + n₃|p₂ P| from camera C to water point P is stationary, by Newton's method in
//! their azimuths and depths.

#![allow(clippy::print_stdout, reason = "the figures are what the test is for")]

use rootvox::optics::{Index, Tank, Vec3, View, trace};
use rootvox::roots::Root;
use rootvox::simulation::{CaptureParams, Scene, capture};

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

/// Gradient of the optical length in (azimuth, z) of p₁ and p₂.
fn gradient(tank: &Tank, c: &Vec3, p: &Vec3, q: &[f64; 4]) -> [f64; 4] {
    let (r1, r2) = (tank.radius_mm, tank.inner_radius_mm());
    let on = |r: f64, a: f64, z: f64| Vec3::new(r * a.cos(), r * a.sin(), z);
    let around = |r: f64, a: f64| Vec3::new(-r * a.sin(), r * a.cos(), 0.0);
    let (p1, p2) = (on(r1, q[0], q[1]), on(r2, q[2], q[3]));
    let n = tank.index;
    let u0 = (p1 - c).normalize() * n.air;
    let u1 = (p2 - p1).normalize() * n.wall;
    let u2 = (p - p2).normalize() * n.water;
    [(u0 - u1).dot(&around(r1, q[0])), (u0 - u1).z, (u1 - u2).dot(&around(r2, q[2])), (u1 - u2).z]
}

/// Point on the outer wall through which the camera at `c` sees the water point `p`.
fn fermat(tank: &Tank, c: &Vec3, p: &Vec3) -> Vec3 {
    // Start: where the straight line from P to C crosses the walls.
    let along = (c - p).normalize();
    let crossing = |r: f64| {
        let (_, t) = trace::cylinder_hits(p, &along, r).unwrap();
        let x = p + along * t;
        (x.y.atan2(x.x), x.z)
    };
    let (a1, z1) = crossing(tank.radius_mm);
    let (a2, z2) = crossing(tank.inner_radius_mm());
    let mut q = [a1, z1, a2, z2];
    for _ in 0..60 {
        let g = gradient(tank, c, p, &q);
        let mut jacobian = nalgebra::Matrix4::zeros();
        for j in 0..4 {
            let h = if j % 2 == 0 { 1e-6 } else { 1e-4 };
            let (mut lower, mut upper) = (q, q);
            lower[j] -= h;
            upper[j] += h;
            let (a, b) = (gradient(tank, c, p, &lower), gradient(tank, c, p, &upper));
            for i in 0..4 {
                jacobian[(i, j)] = (b[i] - a[i]) / (2.0 * h);
            }
        }
        let step = jacobian.lu().solve(&nalgebra::Vector4::from(g)).unwrap();
        for j in 0..4 {
            q[j] -= step[j];
        }
        if step.amax() < 1e-13 {
            break;
        }
    }
    assert!(gradient(tank, c, p, &q).iter().all(|g| g.abs() < 1e-9), "the judge did not converge for {p}");
    Vec3::new(tank.radius_mm * q[0].cos(), tank.radius_mm * q[0].sin(), q[1])
}

fn water_points() -> Vec<Vec3> {
    let mut points = Vec::new();
    for rho in [0.0f64, 20.0, 40.0, 55.0] {
        for (k, z) in [50.0, 90.0, 130.0, 190.0].into_iter().enumerate() {
            let azimuth = 0.9 + 1.7 * k as f64 + rho / 20.0;
            points.push(Vec3::new(rho * azimuth.cos(), rho * azimuth.sin(), z));
        }
    }
    points
}

fn views() -> (CaptureParams, Vec<View>) {
    let params = CaptureParams {
        views: 5,
        noise_sigma: 0.0,
        supersampling: 8,
        // Black balls before a bright room: no shading moves their centroids.
        root_rgb: [0.0; 3],
        background_rgb: [0.7; 3],
        background_variation: 0.0,
        water_loss_per_mm: [0.0; 3],
        ..Default::default()
    };
    let views = capture(&params, &tank(), 3).unwrap();
    (params, views)
}

#[test]
fn the_forward_ray_obeys_fermat() {
    let tank = tank();
    for view in views().1 {
        let centre = view.centre_in_tank();
        for p in water_points() {
            let p1 = fermat(&tank, &centre, &p);
            let ray = trace::trace(&tank, &centre, &(p1 - centre).normalize()).unwrap();
            let w = p - ray.p2_mm;
            let miss = (w - ray.v2 * w.dot(&ray.v2)).norm();
            assert!(miss < 1e-9, "misses {p} by {miss:.1e} mm");
        }
    }
}

#[test]
fn photographed_balls_lie_where_fermat_puts_them() {
    let tank = tank();
    let (params, views) = views();
    let ball = |p: &Vec3| Root {
        id: 0,
        parent: -1,
        order: 0,
        points_mm: vec![[p.x, p.y, p.z - 0.005], [p.x, p.y, p.z + 0.005]],
        radii_mm: vec![0.5, 0.5],
    };
    let balls: Vec<Root> = water_points().iter().map(ball).collect();
    let with = Scene::new(&tank, &balls, &views, &params, 1).unwrap();
    let params = CaptureParams { stem: false, ..params };
    let without = Scene::new(&tank, &[], &views, &params, 1).unwrap();
    let (mut worst, mut sum, mut count) = (0f64, 0.0, 0);
    for (i, view) in views.iter().enumerate().take(2) {
        let (a, b) = (with.photograph(i, &|_| ()), without.photograph(i, &|_| ()));
        let linear = |x: u8| f64::from(rootvox::photo::colour::linear_of_srgb(f32::from(x) / 255.0));
        let centre = view.centre_in_tank();
        let seen: Vec<(f64, f64)> = water_points()
            .iter()
            .map(|p| view.pixel_of_direction(&(fermat(&tank, &centre, p) - centre)).unwrap())
            .collect();
        for (p, &(u, v)) in water_points().iter().zip(&seen) {
            if seen.iter().filter(|(a, b)| (a - u).hypot(b - v) < 12.0).count() > 1 {
                continue;
            }
            let (mut light, mut x, mut y) = (0.0, 0.0, 0.0);
            for py in v as usize - 4..=v as usize + 5 {
                for px in u as usize - 4..=u as usize + 5 {
                    let weight: f64 = (0..3).map(|c| linear(b[(py, px, c)]) - linear(a[(py, px, c)])).sum();
                    // Mirrored balls are faint; they must not pull.
                    if weight > 0.02 {
                        light += weight;
                        x += weight * px as f64;
                        y += weight * py as f64;
                    }
                }
            }
            assert!(light > 0.5, "the ball at {p} is not seen at ({u:.1}, {v:.1})");
            let miss = (x / light - u).hypot(y / light - v);
            worst = worst.max(miss);
            sum += miss * miss;
            count += 1;
        }
    }
    let rms = (sum / f64::from(count)).sqrt();
    println!("{count} balls: rms {rms:.3} px, worst {worst:.3} px");
    assert!(rms < 0.04 && worst < 0.12, "rms {rms} px, worst {worst} px");
}
