use super::*;
use crate::evaluation::{Place, Sight};
use crate::optics::{Index, Tank, Vec3};
use crate::report::lines::RootLine;
use crate::roots::correction::Outcome;
use crate::roots::repair::Kind;
use crate::roots::traits::{TraitParams, per_root, traits};
use crate::roots::{Repair, Root, TracedRoot};
use crate::volume::Grid;
use std::collections::BTreeMap;

fn tank() -> Tank {
    Tank {
        radius_mm: 40.0,
        height_mm: 120.0,
        wall_mm: 3.0,
        water_level_mm: 10.0,
        index: Index::default(),
        belts_mm: vec![],
    }
}

fn system() -> RootSystem {
    let root = Root {
        id: 0,
        parent: -1,
        order: 0,
        points_mm: vec![[0.0, 0.0, 20.0], [0.0, 0.0, 50.0]],
        radii_mm: vec![1.0, 0.5],
    };
    let traced = TracedRoot { root, radius_sd_mm: vec![0.1; 2], views: vec![4; 2], confidence: vec![0.75; 2] };
    let repairs = vec![Repair::new(Kind::Extended, &Vec3::new(0.0, 0.0, 50.0), 2.0, "a </script> in a reason".into())];
    RootSystem { roots: vec![traced], spread_px: Some(0.436), repairs }
}

fn html(name: &str, spread: Option<&Table>, warnings: &[Warning]) -> String {
    let (tank, system) = (tank(), system());
    let grid = Grid::of_tank(&tank, 1.0, 100.0).unwrap();
    let plain = system.plain();
    let rows = per_root::per_root(&plain, 10.0, &TraitParams::default());
    let csv = |name: &str, bytes: Vec<u8>| crate::formats::tables::read(name, &bytes).unwrap();
    let per_root = csv("per_root.csv", crate::formats::tables::per_root(&rows).unwrap());
    let sight = [Sight { place: Place::Wall, voxels: 40, unseen: 10, true_length_mm: None, unseen_length_mm: None }];
    let photo = |name: &str| Photograph {
        name: name.into(),
        size_px: [64, 48],
        from_deg: 12.4,
        jpeg: vec![255, 216, 255, 217],
        lines: vec![RootLine { id: 0, strokes: vec![vec![10, 20, 30, 40]], clear_px: 2.8 }],
    };
    let mut traced = traits(&plain, 10.0, &TraitParams::default());
    traced.iter_mut().filter(|x| x.name == "total_root_length_mm").for_each(|x| x.value = 25.0);
    let settings = BTreeMap::from([("extract.high".to_owned(), "1.5".to_owned())]);
    Page {
        name,
        tank: &tank,
        system: &system,
        traits: &traits(&plain, 10.0, &TraitParams::default()),
        spread,
        per_root: &per_root,
        profile: &Table::default(),
        evidence: Evidence {
            warnings,
            cameras: CameraOrigin::File,
            camera_errors: None,
            views: &[],
            sight: &sight,
            bands: &[],
            score: None,
            roots_score: None,
        },
        photographs: &[photo("a.jpg"), photo("b.jpg")],
        corrections: Some(Corrected { outcomes: &outcomes(), traced: &traced }),
        provenance: Provenance {
            made_by: "rootvox run a.toml",
            again: "rootvox rerun results/a/study.lock",
            grid: &grid,
            settings: &settings,
            stages: &[("merge".into(), 2)],
            inputs: &[("photo/a.jpg".into(), "00ff".into())],
        },
    }
    .html()
    .unwrap()
}

fn outcomes() -> [Outcome; 2] {
    let outcome = |kind: &str, applied, found: &str| Outcome {
        kind: kind.into(),
        applied,
        place_mm: applied.then_some([1.0, 2.04, 3.0]),
        found: found.into(),
        by: "Ada <a@b>".into(),
        when: "2026-05-01".into(),
        note: String::new(),
    };
    [outcome("cut", true, "root of order 0"), outcome("remove", false, "no root within 1 mm")]
}

/// The page without plotly.js.
fn own(page: &str) -> String {
    page.replace(&library::plotly().unwrap(), "")
}

#[test]
fn all_stands_in_one_page_that_asks_for_nothing() {
    let page = own(&html("a<b>", None, &[]));
    assert!(page.contains("<title>a&lt;b&gt; – root system</title>") && !page.contains("a<b> "));
    assert_eq!(page.matches("src=\"data:image/jpeg;base64,/9j/2Q==\"").count(), 2);
    for word in ["src=\"", "href=\"", "url("] {
        for (at, _) in page.match_indices(word) {
            let rest = &page[at + word.len()..];
            assert!(["data:", "#"].iter().any(|own| rest.starts_with(own)), "{word}{}", &rest[..40]);
        }
    }
    assert!(!page.contains("@import") && !page.contains("https://"), "the page names an address");
    assert!(page.contains("default-src 'none'"));
    assert!(
        page.contains("rootvox rerun results/a/study.lock") && page.contains("<th scope=\"row\">high</th><td>1.5</td>")
    );
}

#[test]
fn the_data_is_json_that_no_text_can_end() {
    let page = html("plant", None, &[]);
    let begin = "<script type=\"application/json\" id=\"data\">";
    let from = page.find(begin).unwrap() + begin.len();
    let text = &page[from..from + page[from..].find("</script>").unwrap()];
    let data: serde_json::Value = serde_json::from_str(text).unwrap();
    assert_eq!(data["repairs"][0]["why"], "a </script> in a reason");
    assert_eq!(data["roots"][0]["xyz"], serde_json::json!([0.0, 0.0, 20.0, 0.0, 0.0, 50.0]));
    assert_eq!(data["roots"][0]["d"], serde_json::json!([2.0, 1.0]));
    assert_eq!(data["views"][1]["lines"], serde_json::json!([[0, 2.8, [[10, 20, 30, 40]]]]));
    assert_eq!(data["perRoot"]["rows"][0][3], "30.0");
    assert_eq!(page, html("plant", None, &[]), "equal values, equal bytes");
}

#[test]
fn traits_stand_with_definition_and_uncertainty() {
    let page = own(&html("plant", None, &[]));
    assert!(page.contains("data-trait=\"total_root_length_mm\">30</td><td>mm</td>"), "no uncertainty is asked for");
    assert!(page.contains("Sum of the lengths of all centrelines.") && page.contains("traits.resample=20"));
    let spread = "trait,value,draws,mean,sd,quantile_2.5,quantile_97.5\ntotal_root_length_mm,30,20,29,0.5,28,31\n";
    let page = own(&html("plant", Some(&crate::formats::tables::read("", spread.as_bytes()).unwrap()), &[]));
    assert!(page.contains("20 random halves"));
    assert!(page.contains("total_root_length_mm\">30</td><td class=\"n\">0.5</td><td class=\"n\">28 to 31</td>"));
}

#[test]
fn corrections_stand_with_their_record_and_what_they_did() {
    let page = own(&html("plant", None, &[]));
    assert!(page.contains("2 corrections by a person, 1 applied"));
    assert!(
        page.contains("<td>cut</td><td>yes</td><td>1.0, 2.0, 3.0</td><td>root of order 0</td><td>Ada &lt;a@b&gt;</td>")
    );
    assert!(page.contains("<td>remove</td><td><strong>no</strong></td><td>–</td><td>no root within 1 mm</td>"));
    let section = &page[page.find("id=\"corrections\"").unwrap()..];
    let section = &section[..section.find("</section>").unwrap()];
    assert!(section.contains("<td class=\"n\">25</td><td class=\"n\">30</td><td>mm</td>"));
    assert_eq!(section.matches("<td class=\"n\">").count(), 2, "traits that did not change are left out");
}

#[test]
fn warnings_come_first() {
    let warning = Warning { stage: "pose".into(), place: "pose".into(), text: "the rim <is> off".into() };
    let page = own(&html("plant", None, &[warning]));
    let list = page.find("<ul class=\"findings\">").unwrap();
    assert!(page[list..].starts_with(
        "<ul class=\"findings\">\n<li class=\"warning\"><span class=\"level\">Warning</span><div><strong>pose"
    ));
    assert!(page.contains("the rim &lt;is&gt; off") && page.contains("calibration/ beside this page"));
}

#[test]
fn many_photographs_are_smaller() {
    assert_eq!((preview_px(3), preview_px(40)), (1280, 1280));
    assert_eq!((preview_px(160), preview_px(10_000)), (640, 480));
}
