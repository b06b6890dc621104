use super::*;
use crate::calibration::sparse::SparseView;
use crate::optics::{Distortion, Index, Mat3};

fn tank() -> Tank {
    Tank {
        radius_mm: 60.0,
        height_mm: 180.0,
        wall_mm: 4.0,
        water_level_mm: 14.0,
        index: Index::default(),
        belts_mm: vec![],
    }
}

/// Twelve views of a bright tank before a dark room, drawn by intersecting rays.
fn scene() -> (SparseModel, Vec<Array3<u8>>, Similarity) {
    let lens =
        Lens { width: 480, height: 400, focal_px: 600.0, cx: 240.0, cy: 198.0, distortion: Distortion::default() };
    let truth = Similarity {
        scale: 100.0,
        rotation: Rotation3::new(Vec3::new(0.4, -0.3, 0.2)).into_inner(),
        translation_mm: Vec3::new(5.0, -8.0, 30.0),
    };
    let (mut views, mut photos) = (Vec::new(), Vec::new());
    for i in 0..12 {
        let a = std::f64::consts::TAU * f64::from(i) / 12.0;
        let centre = Vec3::new(420.0 * a.cos(), 420.0 * a.sin(), 10.0);
        let forward = (Vec3::new(0.0, 0.0, 90.0) - centre).normalize();
        let right = Vec3::z().cross(&forward).normalize();
        let rotation = Mat3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
        let view = View { lens, rotation, translation_mm: -(rotation * centre) };
        let sees = |y: usize, x: usize| {
            let d = view.ray_in_tank(x as f64, y as f64);
            let (a, b) = (d.x * d.x + d.y * d.y, centre.x * d.x + centre.y * d.y);
            let root = b * b - a * (centre.x.powi(2) + centre.y.powi(2) - 3600.0);
            let z = |t: f64| centre.z + t * d.z;
            if root < 0.0 {
                return false;
            }
            let (near, far) = (z((-b - root.sqrt()) / a), z((-b + root.sqrt()) / a));
            // A ray meets the closed cylinder where the part of it within the mantle meets 0..180.
            near.min(far) <= 180.0 && near.max(far) >= 0.0
        };
        let picture = Array3::from_shape_fn((400, 480, 3), |(y, x, c)| {
            let noise = ((y * 7919 + x * 104_729 + c) % 11) as u8;
            if sees(y, x) { if (y / 9 + x / 7) % 2 == 0 { 180 + noise } else { 120 + noise } } else { 40 + noise }
        });
        photos.push(shrunken(&picture, &lens, 4));
        // The same view in the frame of structure from motion.
        let sfm_rotation = rotation * truth.rotation;
        let translation = (view.translation_mm + rotation * truth.translation_mm) / truth.scale;
        views.push(SparseView { file: format!("{i}.jpg"), lens, rotation: sfm_rotation, translation });
    }
    (SparseModel { views, points: Vec::new() }, photos, truth)
}

#[test]
fn the_silhouette_is_found_from_a_start_that_is_off() {
    let (model, photos, truth) = scene();
    let start = Similarity {
        scale: truth.scale * 1.01,
        rotation: Rotation3::new(Vec3::new(0.01, -0.005, 0.0)).into_inner() * truth.rotation,
        translation_mm: truth.translation_mm + Vec3::new(2.0, 1.0, 2.0),
    };
    let found = chamfer(&model, &photos, &tank(), 60.0, &start, &ChamferParams::default()).unwrap();
    assert!(found.converged && found.median_px < 2.0, "{} px", found.median_px);
    for (a, b) in truth.views(&model).iter().zip(found.tank_from_sfm.views(&model)) {
        // 420 mm at 600 px: 1.4 px of the photograph, a third of a shrunken pixel, is one mm.
        let z = a.centre_in_tank().z - b.centre_in_tank().z;
        let out = a.centre_in_tank().xy().norm() - b.centre_in_tank().xy().norm();
        assert!(z.abs() < 1.5 && out.abs() < 3.0, "{z} {out}");
    }
}

#[test]
fn impossible_settings_are_named() {
    let (model, photos, truth) = scene();
    let params = ChamferParams { schedule: vec![], ..ChamferParams::default() };
    let e = chamfer(&model, &photos, &tank(), 60.0, &truth, &params).unwrap_err();
    assert!(e.message.contains("pose.chamfer.schedule"), "{e}");
}
