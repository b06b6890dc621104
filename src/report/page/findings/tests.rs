use super::*;
use crate::evaluation::{AtTolerance, Place};
use crate::optics::{Distortion, Lens, Mat3, Vec3};

/// A camera that looks at the axis from that direction.
fn view(from_deg: f64) -> View {
    let lens = Lens { width: 200, height: 200, focal_px: 300.0, cx: 99.5, cy: 99.5, distortion: Distortion::default() };
    let (sin, cos) = from_deg.to_radians().sin_cos();
    let rotation = Mat3::new(-sin, cos, 0.0, 0.0, 0.0, 1.0, -cos, -sin, 0.0);
    View { lens, rotation, translation_mm: -(rotation * Vec3::new(300.0 * cos, 300.0 * sin, 50.0)) }
}

fn evidence<'a>(views: &'a [View], sight: &'a [Sight], score: Option<&'a Score>) -> Evidence<'a> {
    Evidence {
        warnings: &[],
        cameras: CameraOrigin::Simulated,
        camera_errors: None,
        views,
        sight,
        bands: &[],
        score,
        roots_score: None,
    }
}

fn about(findings: &[Finding], topic: &str) -> Finding {
    findings.iter().find(|f| f.topic == topic).expect("is said").clone()
}

#[test]
fn a_gap_in_the_ring_is_told_with_its_place() {
    let all_round: Vec<View> = (0..18).map(|k| view(20.0 * f64::from(k))).collect();
    let good = sight::coverage(&all_round).unwrap();
    assert_eq!((good.level, good.remedy.as_str()), (Level::Good, ""));
    assert!(good.text.contains("the largest gap between neighbours is 20°"), "{}", good.text);
    let gap: Vec<View> =
        all_round.iter().enumerate().filter(|(k, _)| !(3..7).contains(k)).map(|(_, v)| v.clone()).collect();
    let gap = sight::coverage(&gap).unwrap();
    assert_eq!(gap.level, Level::Warning);
    assert!(gap.text.contains("is 100°, from 40° to 140°"), "{}", gap.text);
    let half: Vec<View> = (0..18).map(|k| view(5.0 * f64::from(k))).collect();
    assert!(!sight::coverage(&half).unwrap().text.contains("all round"));
    assert_eq!(sight::coverage(&[]), None);
}

#[test]
fn unseen_water_is_told_with_its_place_and_remedy() {
    let of = |place, unseen| Sight { place, voxels: 1000, unseen, true_length_mm: None, unseen_length_mm: None };
    let found = sight::water(&[of(Place::Floor, 300), of(Place::Wall, 20)]).unwrap();
    assert_eq!(found.level, Level::Warning);
    assert!(found.text.contains("16 % of the water") && found.text.contains("is over the floor"), "{}", found.text);
    assert!(found.remedy.contains("higher"));
    assert_eq!(sight::water(&[of(Place::Wall, 0)]).unwrap().level, Level::Good);
    assert_eq!(sight::water(&[]), None);
}

#[test]
fn what_asks_for_something_stands_first() {
    let at = AtTolerance { tolerance_mm: 1.0, precision: 0.5, recall: 0.9, f1: 0.643 };
    let score =
        Score { turned_deg: None, true_length_mm: 9.0, points: 3, at: vec![at], rms_mm: None, length_bias: None };
    let views: Vec<View> = (0..14).map(|k| view(25.0 * f64::from(k))).collect();
    let all = findings(&evidence(&views, &[], Some(&score)), &RootSystem::default(), &[]);
    assert!(all.windows(2).all(|w| w[0].level <= w[1].level));
    assert_eq!(about(&all, "Roots.").level, Level::Warning);
    assert_eq!(about(&all, "Against the truth.").level, Level::Warning);
    assert_eq!(about(&all, "Coverage.").level, Level::Note);
    assert_eq!(about(&all, "Cameras.").level, Level::Good);
}
