//! Written files keep the schema and come back; files of the wild are read.

use super::schema::faults;
use super::*;
use crate::roots::Root;

fn traced(id: i64, parent: i64, order: u32, points: &[[f64; 3]]) -> TracedRoot {
    let n = points.len();
    TracedRoot {
        root: Root {
            id,
            parent,
            order,
            points_mm: points.to_vec(),
            radii_mm: (0..n).map(|k| 0.5 / (k + 1) as f64).collect(),
        },
        radius_sd_mm: vec![1e-7; n],
        views: vec![3; n],
        confidence: vec![0.25; n],
    }
}

fn system() -> Vec<TracedRoot> {
    vec![
        traced(0, -1, 0, &[[0.0, 0.0, 20.0], [0.5, -1e-9, 30.0], [1.0, 0.0, 40.125]]),
        traced(1, 0, 1, &[[0.5, 0.1, 30.2], [10.0, 0.0, 31.0]]),
        traced(2, 1, 2, &[[10.0, 0.0, 31.0], [10.0, 5.0, 33.0]]),
        traced(3, 0, 1, &[[1.0, 0.0, 40.0], [-10.0, 0.0, 41.0]]),
    ]
}

fn about() -> About {
    About {
        last_modified: "2026-05-01T12:00:00Z".into(),
        software: "rootvox 0.1.0".into(),
        user: "A & B <lab>".into(),
        file_key: "licorice".into(),
        image: Some(("000.jpg".into(), "ab12".into())),
        sequence: Some(Sequence {
            label: "days".into(),
            index: 1,
            created_days: vec![vec![0.0, 0.0, 2.5], vec![0.0, 2.5], vec![2.5, 2.5], vec![2.5, 2.5]],
        }),
    }
}

#[test]
fn written_files_keep_the_schema() {
    let text = write(&system(), &about()).unwrap();
    assert_eq!(faults(&text), Vec::<String>::new());
    assert!(text.contains("<point x=\"0.5\" y=\"0\" z=\"30\"/>"), "plain decimals, no minus zero");
    assert!(text.contains("<parent-node>1</parent-node>"));
    // Readers take properties as lists that run like the roots.
    assert_eq!(text.matches("<parent-node>").count(), system().len());
    assert!(text.matches("name=\"node_creation_time\"").count() == 4 && text.matches("value=\"2.5\"").count() == 6);
    let short = Sequence { label: "days".into(), index: 1, created_days: vec![vec![0.0]] };
    assert!(write(&system(), &About { sequence: Some(short), ..about() }).is_err());
    assert!(text.contains("<index>1</index><unified>true</unified></time-sequence>"));
}

#[test]
fn the_rules_find_faults() {
    let text = write(&system(), &about()).unwrap();
    for (good, bad) in [
        ("<resolution>1<", "<resolution>1e0<"),
        ("2026-05-01T12:00:00Z", "today"),
        (" id=\"root-2\"", " ID=\"root-2\""),
        ("x=\"10\" y=\"5\"", "x=\"1e1\" y=\"5\""),
        ("<unit>mm</unit>\n    <resolution>", "<resolution>"),
        (" domain=\"polyline\"", ""),
        ("<sample value=", "<sample position="),
    ] {
        let broken = text.replacen(good, bad, 1);
        assert_ne!(broken, text, "{good} is in the file");
        assert!(!faults(&broken).is_empty(), "{good} -> {bad}");
    }
}

#[test]
fn round_trip() {
    let reading = read("a.rsml", &write(&system(), &about()).unwrap()).unwrap();
    assert_eq!(reading.notes, Vec::<String>::new());
    let mut want: Vec<Root> = system().into_iter().map(|r| r.root).collect();
    // Numbers are given anew in the order of the file: depth first.
    assert_eq!(reading.roots.len(), want.len());
    want[0].points_mm[1][1] = 0.0;
    for (have, want) in reading.roots.iter().zip(&want) {
        assert_eq!((have.id, have.parent, have.order), (want.id, want.parent, want.order));
        assert_eq!(have.points_mm, want.points_mm);
        for (a, b) in have.radii_mm.iter().zip(&want.radii_mm) {
            assert!((a - b).abs() < 1e-5);
        }
    }
}

#[test]
fn bad_systems_are_refused() {
    assert!(write(&[], &about()).is_err());
    assert!(write(&[traced(0, -1, 0, &[[0.0; 3]])], &about()).unwrap_err().message.contains("two points"));
    assert!(write(&[traced(0, 7, 0, &[[0.0; 3]; 2])], &about()).unwrap_err().message.contains("missing"));
    let ring = [traced(0, 1, 1, &[[0.0; 3]; 2]), traced(1, 0, 1, &[[0.0; 3]; 2])];
    assert!(write(&ring, &about()).unwrap_err().message.contains("itself"));
    let mut nan = traced(0, -1, 0, &[[0.0; 3]; 2]);
    nan.root.radii_mm[0] = f64::NAN;
    assert!(write(&[nan], &about()).unwrap_err().message.contains("finite"));
}

/// Pixels at 20 px/cm, a foreign attribute, `ID`, a date in words, uniform samples as text, no z.
const WILD: &str = r#"<?xml version="1.0"?>
<rsml xmlns:po="http://www.plantontology.org/xml-dtd/po.dtd">
 <metadata><version>1</version><unit>cm</unit><resolution>20</resolution><last-modified>today</last-modified>
  <property-definitions><property-definition><label>diameter</label><type>float</type><unit>cm</unit></property-definition></property-definitions>
  <parameters><parameter name="a"/></parameters>
 </metadata>
 <scene><plant ID="1"><root ID="tap &amp; root" po:accession="PO:0020127">
  <geometry><rootnavspline/><polyline><point x="0" y="0"/><point y="20" x="0"/><point x="0" y="40"/></polyline></geometry>
  <functions><function name="diameter" domain="uniform"><sample>0.2</sample><sample>0.1</sample></function></functions>
  <annotations><annotation name="x"><point x="9" y="9"/><value>1</value><software>s</software></annotation></annotations>
  <root ID="2"><geometry><polyline><point x="0" y="20"/><point x="20" y="20"/></polyline></geometry></root>
 </root></plant></scene></rsml>"#;

#[test]
fn deviating_files_are_read() {
    let reading = read("wild.rsml", WILD).unwrap();
    let [tap, lateral] = &reading.roots[..] else { panic!("two roots") };
    assert_eq!(tap.points_mm, vec![[0.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 20.0, 0.0]]);
    assert!(tap.radii_mm.iter().zip([1.0, 0.75, 0.5]).all(|(a, b)| (a - b).abs() < 1e-12));
    assert_eq!((lateral.parent, lateral.order), (tap.id, 1));
    assert_eq!(lateral.radii_mm, vec![0.0, 0.0]);
    assert!(reading.notes.len() >= 4, "{:?}", reading.notes);
    assert!(!faults(WILD).is_empty());
}

#[test]
fn broken_files_are_errors_that_show_the_line() {
    for bad in ["", "<rsml>", "<rsml></scene>", "<a/>", &WILD.replace("x=\"20\"", "x=\"twenty\"")] {
        assert!(read("b.rsml", bad).is_err(), "{bad}");
    }
    let e = read("b.rsml", &WILD.replace("x=\"20\"", "x=\"twenty\"")).unwrap_err();
    assert!(e.message.contains("line 11") && e.message.contains("twenty"), "{e}");
}
