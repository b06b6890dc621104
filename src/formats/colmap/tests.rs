use super::*;
use crate::optics::{Distortion, Lens, Mat3};

fn sparse() -> SparseModel {
    let lens = Lens {
        width: 968,
        height: 648,
        focal_px: 984.0,
        cx: 488.2,
        cy: 320.1,
        distortion: Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.0, ..Distortion::default() },
    };
    let turn = nalgebra::Rotation3::new(Vec3::new(0.1, -0.7, 0.2)).into_inner();
    let views = vec![
        SparseView { file: "a b.jpg".into(), lens, rotation: Mat3::identity(), translation: Vec3::zeros() },
        SparseView { file: "c.jpg".into(), lens, rotation: turn, translation: Vec3::new(1.0, 0.25, 3.0) },
    ];
    let seen = |du: f64| vec![Sighting { view: 0, u: 10.5 + du, v: 20.0 }, Sighting { view: 1, u: 12.0 + du, v: 21.0 }];
    let points = vec![
        SparsePoint { position: Vec3::new(0.1, 0.2, 5.0), seen: seen(0.0) },
        SparsePoint { position: Vec3::new(0.3, 0.2, 4.0), seen: seen(3.0) },
    ];
    SparseModel { views, points }.normalised()
}

fn close(a: &SparseModel, b: &SparseModel) {
    assert_eq!(a.views.len(), b.views.len());
    for (x, y) in a.views.iter().zip(&b.views) {
        assert_eq!(x.file, y.file);
        assert!((x.lens.cx - y.lens.cx).abs() < 1e-9 && x.lens.distortion == y.lens.distortion);
        assert!((x.rotation - y.rotation).norm() < 1e-9 && (x.translation - y.translation).norm() < 1e-9);
    }
    for (p, q) in a.points.iter().zip(&b.points) {
        assert!((p.position - q.position).norm() < 1e-9);
        assert!(p.seen.iter().zip(&q.seen).all(|(s, t)| s.view == t.view && (s.u - t.u).abs() < 1e-9));
    }
}

#[test]
fn text_and_binary_are_read_back() {
    let (model, want) = (from_sparse(&sparse()).unwrap(), sparse());
    let (c, i, p) = text::write(&model);
    assert_eq!(text::parse(&c, &i, &p).unwrap(), model);
    let (c, i, p) = binary::write(&model).unwrap();
    assert_eq!(binary::parse(&c, &i, &p).unwrap(), model);
    close(&to_sparse(&model, None).unwrap().normalised(), &want);
}

#[test]
fn half_a_pixel_is_added_for_colmap() {
    let model = from_sparse(&sparse()).unwrap();
    assert_eq!(model.images[0].keypoints[0].0, 11.0);
    assert!((model.cameras[0].params[2] - 488.7).abs() < 1e-12);
}

#[test]
fn every_cut_binary_file_is_refused_without_a_panic() {
    let (c, i, p) = binary::write(&from_sparse(&sparse()).unwrap()).unwrap();
    for n in 0..i.len() {
        assert!(binary::parse(&c, &i[..n], &p).is_err(), "images.bin of {n} bytes");
    }
    for n in 0..p.len() {
        assert!(binary::parse(&c, &i, &p[..n]).is_err(), "points3D.bin of {n} bytes");
    }
    let mut huge = c.clone();
    huge[..8].fill(0xff);
    assert!(binary::parse(&huge, &i, &p).unwrap_err().message.contains("room"));
}

#[test]
fn text_faults_name_file_and_line() {
    let e = text::parse("# c\n1 SIMPLE_RADIAL 10 x 5 5 5 0\n", "", "").unwrap_err();
    assert!(e.message.contains("cameras.txt") && e.message.contains("line 2") && e.message.contains("`x`"), "{e}");
    let e = text::parse("", "1 1 0 0 0 0 0 1 1 a.jpg\n", "").unwrap_err();
    assert!(e.message.contains("keypoints"), "{e}");
}

/// Pixels of the direction (0.3, -0.2, 1) by pycolmap 4.2.1, `Camera(model, 968, 648, params).img_from_cam`.
const PIXELS: [[f64; 2]; 10] = [
    [783.900000000000, 123.800000000000],
    [789.804000000000, 123.800000000000],
    [780.446160000000, 126.102560000000],
    [780.695604000000, 125.936264000000],
    [786.393997200000, 126.054344000000],
    [785.775924399205, 126.458313150846],
    [771.003775591329, 132.397482939114],
    [771.044403052700, 132.370397964867],
    [776.693216641315, 132.369139450121],
    [776.683046789926, 132.418991662811],
];

/// Every model that is read, as COLMAP's text file has it.
#[test]
fn all_models_are_read_and_written() {
    let models = [
        "SIMPLE_PINHOLE 968 648 984 488.7 320.6",
        "PINHOLE 968 648 1003.68 984 488.7 320.6",
        "SIMPLE_RADIAL 968 648 984 488.7 320.6 -0.09",
        "RADIAL 968 648 984 488.7 320.6 -0.09 0.05",
        "OPENCV 968 648 1003.68 984 488.7 320.6 -0.09 0.05 0.0004 -0.0003",
        "FULL_OPENCV 968 648 1003.68 984 488.7 320.6 -0.09 0.05 0.0004 -0.0003 0.01 0.02 -0.03 0.004",
        "SIMPLE_RADIAL_FISHEYE 968 648 984 488.7 320.6 -0.03",
        "RADIAL_FISHEYE 968 648 984 488.7 320.6 -0.03 0.01",
        "OPENCV_FISHEYE 968 648 1003.68 984 488.7 320.6 -0.03 0.01 0.004 -0.001",
        "THIN_PRISM_FISHEYE 968 648 1003.68 984 488.7 320.6 -0.03 0.01 0.0004 -0.0003 0.004 -0.001 0.001 -0.0005",
    ];
    for (model, want) in models.iter().zip(PIXELS) {
        let text = text::parse(&format!("1 {model}\n"), "1 1 0 0 0 0 0 1 1 a.jpg\n\n", "").unwrap();
        let sparse = to_sparse(&text, None).unwrap();
        let (u, v) = sparse.views[0].lens.pixel(0.3, -0.2);
        assert!((u + 0.5 - want[0]).abs() < 1e-9 && (v + 0.5 - want[1]).abs() < 1e-9, "{model}: {u} {v} {want:?}");
        let again = to_sparse(&from_sparse(&sparse).unwrap(), None).unwrap();
        let (u2, v2) = again.views[0].lens.pixel(0.3, -0.2);
        assert!((u - u2).abs() < 1e-9 && (v - v2).abs() < 1e-9, "{model}");
    }
}

#[test]
fn several_cameras_are_read_and_written() {
    let mut sparse = sparse();
    sparse.views[1].lens.distortion.b1 = 12.5;
    let model = from_sparse(&sparse).unwrap();
    assert_eq!(model.cameras.len(), 2);
    close(&to_sparse(&model, None).unwrap(), &sparse);
    assert!(sparse.one_lens().unwrap_err().message.contains("`c.jpg`"));
}

#[test]
fn lenses_that_cannot_be_expressed_are_refused() {
    let mut model = from_sparse(&sparse()).unwrap();
    model.cameras[0].model = "FOV".into();
    assert!(to_sparse(&model, None).unwrap_err().message.contains("FOV"));
    model.images[1].camera_id = 2;
    assert!(to_sparse(&model, None).is_err());
    let mut skewed = sparse();
    skewed.views[0].lens.distortion.b2 = 1.0;
    assert!(from_sparse(&skewed).unwrap_err().message.contains("skew"));
}
