use super::*;
use crate::optics::{Distortion, Lens, Mat3};

fn sparse() -> SparseModel {
    let lens = Lens {
        width: 968,
        height: 648,
        focal_px: 984.0,
        cx: 488.2,
        cy: 320.1,
        distortion: Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.0 },
    };
    let turn = nalgebra::Rotation3::new(Vec3::new(0.1, -0.7, 0.2)).into_inner();
    let views = vec![
        SparseView { file: "a b.jpg".into(), rotation: Mat3::identity(), translation: Vec3::zeros() },
        SparseView { file: "c.jpg".into(), rotation: turn, translation: Vec3::new(1.0, 0.25, 3.0) },
    ];
    let seen = |du: f64| vec![Sighting { view: 0, u: 10.5 + du, v: 20.0 }, Sighting { view: 1, u: 12.0 + du, v: 21.0 }];
    let points = vec![
        SparsePoint { position: Vec3::new(0.1, 0.2, 5.0), seen: seen(0.0) },
        SparsePoint { position: Vec3::new(0.3, 0.2, 4.0), seen: seen(3.0) },
    ];
    SparseModel { lens, views, points }.normalised()
}

fn close(a: &SparseModel, b: &SparseModel) {
    assert_eq!(a.views.len(), b.views.len());
    assert!((a.lens.cx - b.lens.cx).abs() < 1e-9 && a.lens.distortion == b.lens.distortion);
    for (x, y) in a.views.iter().zip(&b.views) {
        assert_eq!(x.file, y.file);
        assert!((x.rotation - y.rotation).norm() < 1e-9 && (x.translation - y.translation).norm() < 1e-9);
    }
    for (p, q) in a.points.iter().zip(&b.points) {
        assert!((p.position - q.position).norm() < 1e-9);
        assert!(p.seen.iter().zip(&q.seen).all(|(s, t)| s.view == t.view && (s.u - t.u).abs() < 1e-9));
    }
}

#[test]
fn text_and_binary_are_read_back() {
    let (model, want) = (from_sparse(&sparse()), sparse());
    let (c, i, p) = text::write(&model);
    assert_eq!(text::parse(&c, &i, &p).unwrap(), model);
    let (c, i, p) = binary::write(&model).unwrap();
    assert_eq!(binary::parse(&c, &i, &p).unwrap(), model);
    close(&to_sparse(&model, None).unwrap().normalised(), &want);
}

#[test]
fn half_a_pixel_is_added_for_colmap() {
    let model = from_sparse(&sparse());
    assert_eq!(model.images[0].keypoints[0].0, 11.0);
    assert!((model.cameras[0].params[2] - 488.7).abs() < 1e-12);
}

#[test]
fn every_cut_binary_file_is_refused_without_a_panic() {
    let (c, i, p) = binary::write(&from_sparse(&sparse())).unwrap();
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

#[test]
fn lenses_that_cannot_be_expressed_are_refused() {
    let mut model = from_sparse(&sparse());
    model.cameras[0].params[0] *= 1.01;
    assert!(to_sparse(&model, None).unwrap_err().message.contains("differ"));
    model.cameras[0].model = "OPENCV_FISHEYE".into();
    assert!(to_sparse(&model, None).unwrap_err().message.contains("OPENCV_FISHEYE"));
    let mut two = from_sparse(&sparse());
    two.images[1].camera_id = 2;
    assert!(to_sparse(&two, None).unwrap_err().help.unwrap().contains("single_camera"));
}
