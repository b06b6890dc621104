//! Traits against systems whose traits are known.

use super::hull::{area, circle, least_width, planar, spatial};
use super::per_root::per_root;
use super::*;

fn root(id: i64, parent: i64, order: u32, from: [f64; 3], to: [f64; 3], diameter: f64, n: usize) -> Root {
    let (a, b) = (Vec3::from(from), Vec3::from(to));
    Root {
        id,
        parent,
        order,
        points_mm: (0..=n).map(|k| (a + (b - a) * (k as f64 / n as f64)).into()).collect(),
        radii_mm: vec![0.5 * diameter; n + 1],
    }
}

/// A taproot of 100 mm straight down from 10 mm under the water, two laterals to the sides, one of the second order.
fn plant() -> Vec<Root> {
    vec![
        root(0, -1, 0, [0.0, 0.0, 22.0], [0.0, 0.0, 122.0], 2.0, 200),
        root(1, 0, 1, [0.0, 0.0, 62.0], [40.0, 0.0, 62.0], 1.0, 80),
        root(2, 0, 1, [0.0, 0.0, 82.0], [0.0, 30.0, 112.0], 1.0, 80),
        root(3, 1, 2, [20.0, 0.0, 62.0], [20.0, 0.0, 72.0], 0.4, 20),
    ]
}

fn value(all: &[Trait], name: &str) -> f64 {
    all.iter().find(|t| t.name == name).unwrap_or_else(|| panic!("no {name}")).value
}

#[test]
fn a_known_plant() {
    let all = traits(&plant(), 12.0, &TraitParams::default());
    let second = 1800f64.sqrt();
    let pi = std::f64::consts::PI;
    let length = 100.0 + 40.0 + second + 10.0;
    let volume = pi * (100.0 + 0.25 * (40.0 + second) + 0.04 * 10.0);
    for (name, want) in [
        ("total_root_length_mm", length),
        ("root_volume_mm3", volume),
        ("surface_area_mm2", pi * (200.0 + 40.0 + second + 4.0)),
        ("max_diameter_mm", 2.0),
        ("length_diameter_0_to_0.5_mm", 10.0),
        ("length_diameter_over_2_mm", 100.0),
        ("root_tip_count", 4.0),
        ("branch_point_count", 3.0),
        ("count_order_1", 2.0),
        ("length_order_1_mm", 40.0 + second),
        ("lateral_density_order_1_per_mm", 0.02),
        ("depth_max_mm", 110.0),
        ("height_mm", 100.0),
        ("width_min_mm", 30.0 * 40.0 / 50.0),
        ("width_max_mm", 50.0),
        ("hull_area_xy_mm2", 600.0),
        ("altitude_links", 3.0),
        ("external_path_length_links", 3.0 + 3.0 + 3.0 + 3.0),
        ("max_roots", 2.0),
    ] {
        let have = value(&all, name);
        assert!((have - want).abs() < 1e-6 * want.abs().max(1.0), "{name}: {have} instead of {want}");
    }
    let names: std::collections::BTreeSet<&str> = all.iter().map(|t| t.name.as_str()).collect();
    assert_eq!(names.len(), all.len(), "one definition each");
}

#[test]
fn angles_and_insertions() {
    let rows = per_root(&plant(), 12.0, &TraitParams::default());
    assert!((rows[1].insertion_angle_deg - 90.0).abs() < 1e-6 && (rows[1].emergence_angle_deg - 90.0).abs() < 1e-6);
    assert!((rows[2].insertion_angle_deg - 45.0).abs() < 1e-6 && (rows[2].insertion_mm - 60.0).abs() < 1e-6);
    assert!((rows[3].insertion_angle_deg - 90.0).abs() < 1e-6 && rows[3].tip_angle_deg < 1e-3);
    assert!((rows[0].tortuosity - 1.0).abs() < 1e-9 && rows[0].laterals == 2);
    assert!(rows[0].insertion_mm.is_nan());
}

#[test]
fn layers_add_up() {
    let layers = depth::profile(&plant(), 12.0, &TraitParams::default());
    let all = traits(&plant(), 12.0, &TraitParams::default());
    let sum: f64 = layers.iter().map(|l| l.length_mm).sum();
    assert!((sum - value(&all, "total_root_length_mm")).abs() < 1e-9);
    assert_eq!(layers.iter().map(|l| l.tips).sum::<usize>(), 4);
    assert!((layers[1].length_mm - 10.0).abs() < 1e-9);
}

#[test]
fn hulls_of_a_box() {
    let mut corners = Vec::new();
    for k in 0..8 {
        let bit = |b: i32| if k >> b & 1 == 1 { 1.0 } else { 0.0 };
        corners.push(Vec3::new(2.0 * bit(0), 3.0 * bit(1), 4.0 * bit(2)));
    }
    corners.extend((0..50).map(|k| Vec3::new(1.0, 1.5, 0.08 * f64::from(k))));
    let hull = spatial(&corners);
    assert!((hull.volume - 24.0).abs() < 1e-9);
    let flat = planar(&[[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0], [2.0, 1.0], [2.0, 0.0]]);
    assert_eq!(flat.len(), 4);
    assert!((area(&flat) - 12.0).abs() < 1e-12 && (least_width(&flat) - 3.0).abs() < 1e-12);
    let (centre, radius) = circle(&flat);
    assert!((radius - 2.5).abs() < 1e-12 && (centre[0] - 2.0).abs() < 1e-12);
}

#[test]
fn a_nearly_straight_stretch_of_a_root_keeps_the_hull_closed() {
    // Of a traced centreline: faces along it are slivers, seen or not by less than rounding.
    let points = [
        Vec3::new(-52.459_992_10, -8.449_319_15, 129.870_684_50),
        Vec3::new(-52.387_245_41, -7.955_293_95, 129.887_288_91),
        Vec3::new(-52.331_235_82, -7.458_815_53, 129.885_802_72),
        Vec3::new(-52.287_824_62, -6.961_299_76, 129.870_798_81),
        Vec3::new(-52.252_803_21, -6.463_472_63, 129.846_839_57),
        Vec3::new(13.757_319_19, -11.956_402_54, 112.648_237_00),
        Vec3::new(14.034_298_69, -11.904_882_32, 113.061_277_75),
        Vec3::new(15.762_994_16, -11.265_185_91, 116.031_276_23),
        Vec3::new(8.972_637_27, 25.240_022_72, 145.117_834_53),
    ];
    // Qhull 2020.2 (`scipy.spatial.ConvexHull(points).volume`).
    let volume = spatial(&points).volume;
    assert!((volume / 1_995.060_36 - 1.0).abs() < 1e-6, "{volume} mm³");
}

#[test]
fn points_of_a_lattice_have_the_hull_of_its_box() {
    let n = [5_usize, 7, 9];
    for step in [4.0, 0.1, 1.0 / 3.0] {
        let points: Vec<Vec3> = (0..n[0] * n[1] * n[2])
            .map(|k| Vec3::new((k % n[0]) as f64, (k / n[0] % n[1]) as f64, (k / n[0] / n[1]) as f64) * step)
            .collect();
        // Turned, so that the planes are planes up to rounding only.
        let turn = nalgebra::Rotation3::from_euler_angles(0.3, 0.7, 1.1);
        let turned: Vec<Vec3> = points.iter().map(|p| turn * p).collect();
        for points in [points, turned] {
            let (hull, want) = (spatial(&points), 4.0 * 6.0 * 8.0 * step.powi(3));
            assert!((hull.volume / want - 1.0).abs() < 1e-4, "{} for {want}", hull.volume);
        }
    }
}

#[test]
fn no_roots_no_panic() {
    let all = traits(&[], 12.0, &TraitParams::default());
    assert_eq!(value(&all, "total_root_length_mm"), 0.0);
    assert!(per_root(&[], 12.0, &TraitParams::default()).is_empty());
    assert!(depth::profile(&[], 12.0, &TraitParams::default()).is_empty());
    let flat = traits(&plant()[..1], 12.0, &TraitParams::default());
    assert!(value(&flat, "convex_hull_volume_mm3") == 0.0);
}
