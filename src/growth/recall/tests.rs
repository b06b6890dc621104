//! Photographs drawn with roots fainter than any threshold takes, and what other days' lines find there.

use super::*;
use crate::optics::ViewMap;
use crate::photo::evidence::share::{SPAN, ZERO};
use crate::roots::explain::tests::{ring, tank};
use crate::roots::explain::{ExplainParams, explain};
use ndarray::Array3;

const VIEWS: usize = 18;
const SPREAD_PX: f64 = 0.6;

fn noise(a: usize, b: usize, c: usize) -> f64 {
    let unit = |salt: u64| {
        let mut x = (a as u64 * 1_000_003 + b as u64 * 7919 + c as u64).wrapping_add(salt);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    };
    (0..6).map(|k| unit(k * 0x9E37_79B9_7F4A_7C15)).sum::<f64>() - 3.0
}

/// A root from its base on, `length` of its way to `to`.
fn root(id: i64, parent: i64, from: [f64; 3], to: [f64; 3], length: f64) -> TracedRoot {
    let way = Vec3::from(to) - Vec3::from(from);
    let n = (length.min(way.norm()) * 2.0) as usize;
    let points_mm: Vec<[f64; 3]> =
        (0..=n).map(|k| (Vec3::from(from) + way.normalize() * (k as f64 / 2.0)).into()).collect();
    let root = Root { id, parent, order: u32::from(parent >= 0), radii_mm: vec![0.4; n + 1], points_mm };
    TracedRoot { root, radius_sd_mm: vec![0.0; n + 1], views: vec![9; n + 1], confidence: vec![1.0; n + 1] }
}

/// Evidence of photographs in which each root shows as much as is said, beneath noise of a fifth of a root.
fn photographs(maps: &[ViewMap], roots: &[(&TracedRoot, f64)]) -> Vec<Array3<u8>> {
    let one = |(n, map): (usize, &ViewMap)| {
        let mut share = ndarray::Array2::from_shape_fn((220, 220), |(v, u)| 0.2 * noise(n, v, u));
        for (root, shows) in roots {
            let mut most = ndarray::Array2::<f64>::zeros((220, 220));
            for p in &root.root.points_mm {
                let Some(seen) = map.project(&Vec3::from(*p)) else { continue };
                for v in seen.v as usize - 3..=seen.v as usize + 4 {
                    for u in seen.u as usize - 3..=seen.u as usize + 4 {
                        let off_2 = (v as f64 - seen.v).powi(2) + (u as f64 - seen.u).powi(2);
                        most[[v, u]] = most[[v, u]].max(shows * (-off_2 / (2.0 * 1.1 * 1.1)).exp());
                    }
                }
            }
            share += &most;
        }
        Array3::from_shape_fn((220, 220, 3), |(v, u, channel)| match channel {
            0 => (f64::from(ZERO) + f64::from(SPAN) * share[[v, u]]).clamp(0.0, 255.0) as u8,
            1 => 255,
            _ => 0,
        })
    };
    maps.iter().enumerate().map(one).collect()
}

struct Day(Vec<ViewMap>, Vec<Array3<u8>>);

impl Day {
    fn showing(roots: &[(&TracedRoot, f64)]) -> Self {
        let maps = ring(VIEWS);
        let pictures = photographs(&maps, roots);
        Self(maps, pictures)
    }

    fn witnesses(&self) -> Vec<Witness<'_>> {
        let all = self.0.iter().zip(&self.1);
        all.map(|(map, evidence)| Witness { map, evidence: evidence.view(), spread_px: SPREAD_PX }).collect()
    }

    fn finds(&self, known: &[TracedRoot], line: &TracedRoot) -> Vec<Recalled> {
        let wanted = vec![Wanted { line: line.clone(), by: 1, least_mm: 0.0 }];
        recall(0, known, wanted, &self.witnesses(), &tank(), &RecallParams { enabled: true, ..RecallParams::default() })
    }
}

fn main() -> TracedRoot {
    root(0, -1, [2.0, 1.0, 25.0], [2.0, 1.0, 95.0], 70.0)
}

/// A lateral as long as it is on the later day, 0.5 mm off its place on the day before, or less of it.
fn lateral(length: f64, off: f64) -> TracedRoot {
    root(3, 0, [2.5, 1.0 + off, 40.0], [20.0, 14.0 + off, 60.0], length)
}

#[test]
fn a_faint_root_that_is_sure_on_another_day_is_found_as_long_as_it_was() {
    let (main, there) = (main(), lateral(16.0, 0.0));
    let day = Day::showing(&[(&main, 1.0), (&there, 0.22)]);
    // The thresholds of the day alone leave it.
    let pieces = [main.clone(), there.clone()];
    let kept = explain(&pieces, &day.witnesses(), &ExplainParams::default()).unwrap().kept;
    let on_it = |p: &&[f64; 3]| there.root.points_mm.iter().any(|q| (Vec3::from(*q) - Vec3::from(**p)).norm() < 0.1);
    assert!(kept.iter().flatten().filter(on_it).count() < 5, "it is not faint");
    let found = day.finds(&[main], &lateral(30.0, 0.5));
    assert_eq!(found.len(), 1, "it was not found");
    let length = 0.5 * (found[0].root.root.points_mm.len() - 1) as f64;
    assert!((length - 16.0).abs() <= 2.0 && found[0].chance <= 0.03, "{length} mm, {}", found[0].chance);
    assert!(found[0].days == [0, 1] && (0.05..0.3).contains(&found[0].contrast), "{}", found[0].contrast);
    // Where it was, not where it lies on the other day.
    let way = |p: &[f64; 3]| {
        let far = |q: &[f64; 3]| (Vec3::from(*p) - Vec3::from(*q)).norm();
        there.root.points_mm.iter().map(far).fold(f64::INFINITY, f64::min)
    };
    assert!(found[0].root.root.points_mm[..20].iter().all(|p| way(p) < 0.45));
}

#[test]
fn nothing_is_invented_where_there_is_no_root() {
    let main = main();
    let day = Day::showing(&[(&main, 1.0)]);
    // Laterals that are not there yet, all round the main root: at the most what chance allows.
    let mut invented = 0;
    for k in 0..12 {
        let (sin, cos) = (f64::from(k) * 0.52).sin_cos();
        let base = [2.0 + 0.5 * cos, 1.0 + 0.5 * sin, 35.0 + 3.0 * f64::from(k)];
        let line = root(3, 0, base, [base[0] + 18.0 * cos, base[1] + 18.0 * sin, base[2] + 10.0], 20.0);
        invented += day.finds(std::slice::from_ref(&main), &line).len();
    }
    assert!(invented <= 1, "{invented} of 12");
    // What is there is known already; nor does a lateral hang on what is not there.
    let again = TracedRoot { root: Root { id: 7, ..main.root.clone() }, ..main.clone() };
    assert!(day.finds(std::slice::from_ref(&main), &again).is_empty());
    let day = Day::showing(&[(&lateral(20.0, 0.0), 1.0)]);
    assert!(day.finds(&[], &lateral(20.0, 0.0)).is_empty(), "without its parent");
}

#[test]
fn what_was_found_is_followed() {
    use crate::growth::follow::{FollowParams, State, follow};
    let day = |length: f64| (length, vec![main(), lateral(length, 0.0)]);
    let mut days = [day(10.0), (14.0, vec![main()]), day(18.0)];
    let growth = follow(&mut days, &FollowParams::default());
    assert!(growth.intervals.iter().any(|i| i.state == State::Vanished));
    let named: Vec<_> = days.iter().enumerate().map(|(n, (_, roots))| growth.day(n, roots)).collect();
    let first_from_day = crate::growth::motion::Motion::turn(0.3);
    let wanted = wanted(&growth, &named, 1, &first_from_day);
    assert!(wanted.len() == 1 && wanted[0].by == 2 && (wanted[0].least_mm - 10.0).abs() < 0.1, "{wanted:?}");
    assert!(first_from_day.root(&wanted[0].line.root).points_mm[4][1] - named[2][1].root.points_mm[4][1] < 1e-9);
    let found = Recalled { root: named[2][1].clone(), days: [1, 2], contrast: 0.2, chance: 0.025 };
    let mut timed: Vec<_> = named.into_iter().enumerate().map(|(n, roots)| (n as f64, roots)).collect();
    let joined = joined(growth, &mut timed, &[found], &FollowParams::default());
    assert!(joined.intervals.iter().all(|i| i.state == State::Followed) && timed[1].1.len() == 2, "{joined:?}");
    assert!(joined.tracks.iter().all(|t| t.seen.iter().all(Option::is_some)));
}
