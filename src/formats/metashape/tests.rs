use super::*;
use nalgebra::Rotation3;
use std::fmt::Write as _;

fn model() -> SparseModel {
    let distortion = Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.01, ..Distortion::default() };
    let lens = Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.2, cy: 320.1, distortion };
    let view = |k: u32| SparseView {
        file: format!("{k:03}"),
        lens,
        rotation: Rotation3::new(Vec3::new(0.2, 0.5 * f64::from(k), -0.1)).into_inner(),
        translation: Vec3::new(1.0, -2.0, 400.0 + f64::from(k)),
    };
    SparseModel { views: (0..3).map(view).collect(), points: Vec::new() }
}

/// What Metashape would write of the model in a frame turned, moved and scaled by the chunk's transform.
fn written(model: &SparseModel, turn: &Mat3, shift: Vec3, scale: f64) -> String {
    let (l, d) = (&model.views[0].lens, &model.views[0].lens.distortion);
    let row = |m: &Mat3| m.transpose().iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\">\n<chunk label=\"Chunk 1\" enabled=\"true\">\n\
         <sensors next_id=\"1\"><sensor id=\"0\" label=\"unknown\" type=\"frame\"><resolution width=\"{w}\" height=\"{h}\"/>\n\
         <property name=\"layer_index\" value=\"0\"/><calibration type=\"frame\" class=\"adjusted\"><resolution width=\"{w}\" height=\"{h}\"/>\n\
         <f>{f}</f><cx>{cx}</cx><cy>{cy}</cy><k1>{}</k1><k2>{}</k2><k3>{}</k3><p1>{}</p1><p2>{}</p2></calibration></sensor></sensors>\n\
         <components><component id=\"0\"><transform><rotation>{}</rotation><translation>{} {} {}</translation><scale>{scale}</scale></transform></component></components>\n<cameras>\n",
        d.k1,
        d.k2,
        d.k3,
        d.p2,
        d.p1,
        row(turn),
        shift.x,
        shift.y,
        shift.z,
        w = l.width,
        h = l.height,
        f = l.focal_px,
        cx = l.cx + 0.5 - 484.0,
        cy = l.cy + 0.5 - 324.0,
    );
    for v in &model.views {
        let r = turn.transpose() * v.rotation.transpose();
        let c = turn.transpose() * (v.centre() - shift) / scale;
        let _ = writeln!(
            text,
            "<camera id=\"0\" sensor_id=\"0\" component_id=\"0\" label=\"{}\"><transform>{} {} {} {} {} {} {} {} {} {} {} {} 0 0 0 1</transform></camera>",
            v.file,
            r[(0, 0)],
            r[(0, 1)],
            r[(0, 2)],
            c.x,
            r[(1, 0)],
            r[(1, 1)],
            r[(1, 2)],
            c.y,
            r[(2, 0)],
            r[(2, 1)],
            r[(2, 2)],
            c.z
        );
    }
    text + "<camera id=\"9\" sensor_id=\"0\" label=\"lost\"/></cameras></chunk></document>"
}

fn usual() -> String {
    written(&model(), &Rotation3::new(Vec3::new(0.3, 0.2, 0.1)).into_inner(), Vec3::new(7.0, 8.0, 9.0), 12.5)
}

#[test]
fn lens_and_poses_come_back() {
    let (read, truth) = (parse("cameras.xml", &usual()).unwrap(), model());
    let (a, b) = (read.views[0].lens, truth.views[0].lens);
    assert!((a.cx - b.cx).abs() < 1e-12 && (a.cy - b.cy).abs() < 1e-12 && a.distortion == b.distortion, "{a:?}");
    assert_eq!(read.views.len(), 3);
    for (a, b) in read.views.iter().zip(&truth.views) {
        assert_eq!(a.file, b.file);
        assert!((a.rotation - b.rotation).abs().max() < 1e-12 && (a.translation - b.translation).norm() < 1e-9);
    }
}

#[test]
fn several_sensors_affinity_and_fisheye_are_read() {
    let first = usual();
    let (from, to) = (first.find("<sensor id").unwrap(), first.find("</sensors>").unwrap());
    let second = first[from..to]
        .replace("id=\"0\"", "id=\"1\"")
        .replace("<calibration type=\"frame\"", "<calibration type=\"fisheye\"")
        .replace("<f>984</f>", "<f>700</f><b1>3.5</b1><b2>-0.25</b2><k4>0.002</k4>");
    let text = format!("{}{second}{}", &first[..to], &first[to..]).replacen("sensor_id=\"0\"", "sensor_id=\"1\"", 1);
    let read = parse("cameras.xml", &text).unwrap();
    let (a, b) = (read.views[0].lens, read.views[1].lens);
    assert_eq!((b.focal_px, b.distortion), (984.0, model().views[0].lens.distortion));
    let (d, e) = (a.distortion, b.distortion);
    assert_eq!((a.focal_px, d.model, d.b1, d.b2, d.r8), (700.0, Model::Fisheye, 3.5, -0.25, 0.002));
    assert_eq!((d.k1, d.p1, d.p2), (e.k1, e.p1, e.p2));
    // Metashape's own formula for a frame camera, of a point up right of the axis.
    let lens = Lens { distortion: Distortion { model: Model::Brown, ..d }, ..a };
    let (x, y) = (0.2, -0.1);
    let r2: f64 = x * x + y * y;
    let radial = 1.0 + e.k1 * r2 + e.k2 * r2.powi(2) + e.k3 * r2.powi(3) + 0.002 * r2.powi(4);
    let (p1, p2) = (e.p2, e.p1);
    let xd = x * radial + p1 * (r2 + 2.0 * x * x) + 2.0 * p2 * x * y;
    let yd = y * radial + p2 * (r2 + 2.0 * y * y) + 2.0 * p1 * x * y;
    let (cx, cy) = (b.cx + 0.5 - 484.0, b.cy + 0.5 - 324.0);
    let want = (484.0 + cx + xd * 700.0 + xd * 3.5 - yd * 0.25 - 0.5, 324.0 + cy + yd * 700.0 - 0.5);
    let (u, v) = lens.pixel(x, y);
    assert!((u - want.0).abs() < 1e-9 && (v - want.1).abs() < 1e-9, "{u} {v} {want:?}");
}

#[test]
fn faults_are_named() {
    let says = |text: &str, word: &str| {
        let e = parse("c.xml", text).unwrap_err().to_string();
        assert!(e.contains("c.xml") && e.contains(word), "{e}");
    };
    says("", "aligned");
    says("not xml <", "line 1");
    says(&usual()[..900], "line");
    says(&usual().replace("<f>984</f>", ""), "focal length");
    says(&usual().replace("<f>984</f>", "<f>984</f><p3>350</p3>"), "p3");
    says(&usual().replace("<calibration type=\"frame\"", "<calibration type=\"spherical\""), "`spherical`");
    says(&usual().replace(" 0 0 0 1</transform>", " 0 0 1</transform>"), "15 numbers");
    says(
        &usual().replacen("<transform>0.", "<transform>NaN 0.", 2).replace(" 0 0 0 1<", " 0 0 1<"),
        "no finite number",
    );
    says(&usual().replace("<scale>12.5", "<scale>-1"), "rigid");
    says(&usual().replacen("sensor_id=\"0\"", "sensor_id=\"4\"", 1), "sensor `4`");
}
