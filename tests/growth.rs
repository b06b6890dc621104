//! One plant photographed on three days, put back by hand, the water at another level: days in one frame and roots followed, from the
//! photographs and the size of the tank alone. Needs the data set `growth-dev` in the folder that `ROOTVOX_TEST_DATA` names, and COLMAP.

use rootvox::flow::Engine;
use rootvox::formats::{cameras_json, roots_json};
use rootvox::growth::align::Alignment;
use rootvox::growth::follow::{Growth, State};
use rootvox::growth::motion::Motion;
use rootvox::optics::{Vec3, View};
use rootvox::roots::{Root, TracedRoot};
use rootvox::store::Store;
use rootvox::study::batch::Batch;
use std::fs;
use std::path::{Path, PathBuf};

/// Radius of the printed surface, mm, and depths on it.
const PRINT_MM: f64 = 60.1;
const DEPTHS_MM: [f64; 6] = [3.0, 10.0, 20.0, 160.0, 168.0, 177.0];
/// Depths between the belts, mm.
const CLEAR_MM: std::ops::Range<f64> = 26.0..150.0;

fn data() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("ROOTVOX_TEST_DATA") else {
        eprintln!("skipped: ROOTVOX_TEST_DATA names no folder of data sets");
        return None;
    };
    let folder = PathBuf::from(folder).join("growth-dev");
    assert!(folder.is_dir(), "`{}` is missing", folder.display());
    if std::process::Command::new("colmap").arg("help").output().is_err() {
        eprintln!("skipped: there is no COLMAP here");
        return None;
    }
    Some(folder)
}

/// The motion of a day's frame as it was found into that of the truth, by what the print's pixels show.
fn into_truth(found: &[View], truth: &[View]) -> Motion {
    let mut pairs = Vec::new();
    for (f, t) in found.iter().zip(truth) {
        let (from, to) = (f.centre_in_tank(), t.centre_in_tank());
        for k in 0..72 {
            let (sin, cos) = (f64::from(k) * 5.0).to_radians().sin_cos();
            let normal = Vec3::new(cos, sin, 0.0);
            for z in DEPTHS_MM {
                let x = normal * PRINT_MM + Vec3::z() * z;
                if normal.dot(&(to - x).normalize()) < 0.6 {
                    continue;
                }
                let Some((u, v)) = t.pixel_of_direction(&(x - to)) else { continue };
                let d = f.ray_in_tank(u, v);
                let (a, b) = (d.xy().norm_squared(), from.xy().dot(&d.xy()));
                let root = b * b - a * (from.xy().norm_squared() - PRINT_MM * PRINT_MM);
                if root >= 0.0 {
                    pairs.push((from + d * ((-b - root.sqrt()) / a), x));
                }
            }
        }
    }
    let (from, to): (Vec<Vec3>, Vec<Vec3>) = pairs.into_iter().unzip();
    Motion::nearest(&from, &to).expect("views of the print")
}

fn length(root: &Root, clear: bool) -> f64 {
    let step = |w: &[[f64; 3]]| (Vec3::from(w[1]) - Vec3::from(w[0])).norm();
    root.points_mm.windows(2).filter(|w| !clear || CLEAR_MM.contains(&w[0][2])).map(step).sum()
}

/// Of each true root the traced one that most of it, and half at least, lies on.
fn covered(truth: &[Root], traced: &[Root]) -> Vec<Option<usize>> {
    let of = |root: &Root| {
        let points: Vec<Vec3> =
            root.points_mm.iter().filter(|p| CLEAR_MM.contains(&p[2])).map(|p| Vec3::from(*p)).collect();
        let mut counts = vec![0; traced.len()];
        for p in &points {
            let near = |r: &Root| r.points_mm.iter().map(|q| (Vec3::from(*q) - p).norm()).fold(f64::INFINITY, f64::min);
            let nearest = (0..traced.len()).map(|k| (near(&traced[k]), k)).min_by(|a, b| a.0.total_cmp(&b.0));
            if let Some((distance, k)) = nearest
                && distance < 1.5
            {
                counts[k] += 1;
            }
        }
        let best = (0..counts.len()).max_by_key(|&k| counts[k])?;
        (counts[best] > 0 && 2 * counts[best] >= points.len()).then_some(best)
    };
    truth.iter().map(of).collect()
}

#[test]
fn a_plant_is_followed_over_three_days_from_photographs_and_tank_alone() {
    let Some(data) = data() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let rows: String = (1..=3).map(|d| format!("1,{d},{}/day{d}\n", data.display())).collect();
    fs::write(folder.path().join("plants.csv"), format!("plant,date,photos\n{rows}")).expect("can write");
    let study = "[plants]\ntable = \"plants.csv\"\n[photos]\nimages = \"images/*\"\n[cameras]\nsource = \"sfm\"\n\
        [tank]\nfile = \"tank.json\"\nbelts = [[0.0, 24.0], [156.0, 180.0]]\n[grid]\ndepth = 154.0\n";
    let path = folder.path().join("trial.toml");
    fs::write(&path, study).expect("can write");
    let batch = Batch::load(&path, &[]).expect("a sound trial");
    let days = &batch.trial.as_ref().expect("a trial").days[0];
    // Kept between runs of the test: structure from motion takes its time.
    let store = Store::open(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("growth")).expect("a store");
    let report = Engine::new(&store).run(&batch.graph, &[days.follow]).expect("runs");

    // Days in one frame.
    let (mut frames, mut truths) = (Vec::new(), Vec::new());
    for (n, study) in batch.studies.iter().enumerate() {
        let (_, nodes) = study.points[0].planned.as_ref().expect("sound");
        let found: Vec<rootvox::formats::NamedView> =
            report.artefact(nodes.cameras).expect("cameras").json("cameras").expect("views");
        let read = |name: &str| fs::read_to_string(data.join(format!("day{}/{name}", n + 1))).expect("the truth");
        let truth = cameras_json::parse("cameras.json", &read("cameras.json")).expect("views");
        let views = |v: &[rootvox::formats::NamedView]| v.iter().map(|v| v.view.clone()).collect::<Vec<_>>();
        frames.push(into_truth(&views(&found), &views(&truth)));
        truths.push(roots_json::parse("roots.json", &read("roots.json")).expect("roots"));
    }
    let followed = report.artefact(days.follow).expect("the days");
    let alignments: Vec<Alignment> = followed.json("alignments").expect("alignments");
    let mut motions = vec![Motion::identity()];
    motions.extend(alignments.iter().map(|a| a.motion));
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        let found = motions[a].inverse().after(&motions[b]);
        let off = found.after(&frames[a].inverse().after(&frames[b]).inverse());
        let places = (0..12).flat_map(|k| DEPTHS_MM.map(|z| (f64::from(k) * 30.0, z)));
        let worst = places
            .map(|(turn, z)| {
                let x = Vec3::new(60.0 * turn.to_radians().cos(), 60.0 * turn.to_radians().sin(), z);
                (off.apply(&x) - x).norm()
            })
            .fold(0.0, f64::max);
        eprintln!("days {}-{}: azimuth {:.4} degrees, places {worst:.4} mm", a + 1, b + 1, off.azimuth().to_degrees());
        assert!(off.azimuth().to_degrees().abs() < 0.05 && worst < 0.05);
    }

    // Roots over days.
    let growth: Growth = followed.json("growth.json").expect("growth");
    let named: Vec<Vec<TracedRoot>> = followed.json("days.json").expect("roots");
    let traced: Vec<Vec<Root>> =
        named.iter().map(|day| day.iter().map(|r| frames[0].root(&r.root)).collect()).collect();
    let cover: Vec<Vec<Option<usize>>> = truths.iter().zip(&traced).map(|(t, r)| covered(t, r)).collect();
    let seen = |day: usize, id: i64| {
        let at = truths[day].iter().position(|r| r.id == id && length(r, true) >= 2.0)?;
        Some((at, cover[day][at].map(|k| traced[day][k].id)))
    };
    let (mut both, mut kept, mut births, mut found, mut right, mut all_told) = (0, 0, 0, 0, 0, 0);
    let mut rates = Vec::new();
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let mut born = Vec::new();
        for root in &truths[b] {
            let Some((at, now)) = seen(b, root.id) else { continue };
            let Some((before, then)) = seen(a, root.id) else {
                born.extend(Some(now).filter(|_| root.parent >= 0));
                continue;
            };
            both += 1;
            let same = now.is_some() && now == then;
            kept += usize::from(same);
            let interval = growth.intervals.iter().find(|i| i.days == [a, b] && same && Some(i.root) == now);
            let tips = [(a, before), (b, at)].map(|(d, n)| truths[d][n].points_mm.last().expect("a tip")[2]);
            let grown = length(&truths[b][at], false) - length(&truths[a][before], false);
            if let Some(i) = interval
                && length(&truths[b][at], false) > 15.0
                && grown > 1.0
                && tips.iter().all(|z| CLEAR_MM.contains(z))
            {
                rates.push(i.elongation_mm.map_or(9.0, |told| (told / grown - 1.0).abs()));
            }
        }
        if b == a + 1 {
            let clear = |id: i64| traced[b].iter().any(|r| r.id == id && length(r, true) >= 2.0);
            let told = growth.intervals.iter().filter(|i| i.days == [a, b] && i.state == State::Appeared);
            let told: Vec<i64> = told.map(|i| i.root).filter(|id| clear(*id)).collect();
            births += born.len();
            found += born.iter().filter(|id| id.is_some_and(|id| told.contains(&id))).count();
            right += told.iter().filter(|id| born.contains(&Some(**id))).count();
            all_told += told.len();
        }
    }
    rates.sort_by(f64::total_cmp);
    let median = rates[rates.len() / 2];
    eprintln!(
        "identity {kept} of {both}; new laterals {found} of {births}, {right} of {all_told} told; elongation {median:.3} of {}",
        rates.len()
    );
    assert!(kept as f64 >= 0.92 * both as f64 && found as f64 >= 0.85 * births as f64);
    assert!(right as f64 >= 0.85 * all_told as f64);
    assert!(median <= 0.06 && rates.len() > 25);
}
