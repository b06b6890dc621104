//! Photographs drawn from tubes, point by point, and what is found to explain them.

use super::*;
use crate::optics::{Distortion, Index, Lens, Mat3, Tank, View};
use crate::photo::evidence::share::{FULL, SPAN, ZERO};
use crate::roots::Root;
use ndarray::{Array2, Array3};

const VIEWS: usize = 24;
const SPREAD_PX: f64 = 0.5;
/// Places per pixel and direction at which a drawing is sampled.
const FINE: usize = 3;

pub(crate) fn tank() -> Tank {
    let index = Index { air: 1.0, wall: 1.49, water: 1.333 };
    Tank { radius_mm: 40.0, height_mm: 120.0, wall_mm: 3.0, water_level_mm: 10.0, index, belts_mm: Vec::new() }
}

/// That many cameras all round at the height of the roots' middle, 2.6 px per mm.
pub(crate) fn ring(views: usize) -> Vec<ViewMap> {
    let lens =
        Lens { width: 220, height: 220, focal_px: 650.0, cx: 109.5, cy: 109.5, distortion: Distortion::default() };
    (0..views)
        .map(|k| {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / views as f64).sin_cos();
            let forward = Vec3::new(-cos, -sin, 0.0);
            let down = Vec3::z();
            let rotation = Mat3::from_rows(&[down.cross(&forward).transpose(), down.transpose(), forward.transpose()]);
            let centre = Vec3::new(250.0 * cos, 250.0 * sin, 60.0);
            ViewMap::new(&View { lens, rotation, translation_mm: -(rotation * centre) }, &tank()).unwrap()
        })
        .collect()
}

/// A straight root.
fn straight(from: [f64; 3], to: [f64; 3], radius_mm: f64) -> (TracedRoot, f64) {
    let at = |t: f64| [0, 1, 2].map(|k| from[k] + t * (to[k] - from[k]));
    let points_mm: Vec<[f64; 3]> = (0..=60).map(|k| at(f64::from(k) / 60.0)).collect();
    let radii_mm = vec![radius_mm; points_mm.len()];
    let n = points_mm.len();
    let root = Root { id: 0, parent: -1, order: 0, points_mm, radii_mm };
    (TracedRoot { root, radius_sd_mm: vec![0.0; n], views: vec![0; n], confidence: vec![1.0; n] }, radius_mm)
}

fn upright(x: f64, y: f64, radius_mm: f64) -> (TracedRoot, f64) {
    straight([x, y, 35.0], [x, y, 85.0], radius_mm)
}

/// The evidence of a photograph of opaque tubes: discs about many points, averaged over the pixels.
fn photograph(map: &ViewMap, tubes: &[(TracedRoot, f64)]) -> Array3<u8> {
    let lens = map.view().lens;
    let (height, width) = (lens.height, lens.width);
    let mut fine = Array2::from_elem((height * FINE, width * FINE), false);
    let pixel = |p: Vec3| map.project(&p).map(|seen| (seen.u, seen.v));
    for (tube, radius_mm) in tubes {
        let points = &tube.root.points_mm;
        for (a, b) in points.iter().zip(&points[1..]) {
            for part in 0..4 {
                let place = Vec3::from(*a).lerp(&Vec3::from(*b), f64::from(part) / 4.0);
                let Some(here) = pixel(place) else { continue };
                // Across the ray, by the refraction's own scale there.
                let towards = map.view().centre_in_tank() - place;
                let across = towards.cross(&Vec3::z()).normalize();
                let Some(beside) = pixel(place + across * *radius_mm) else { continue };
                let radius = (beside.0 - here.0).hypot(beside.1 - here.1) * FINE as f64;
                let middle = [(here.1 + 0.5) * FINE as f64 - 0.5, (here.0 + 0.5) * FINE as f64 - 0.5];
                for v in (middle[0] - radius).ceil() as usize..=(middle[0] + radius) as usize {
                    for u in (middle[1] - radius).ceil() as usize..=(middle[1] + radius) as usize {
                        if (v as f64 - middle[0]).hypot(u as f64 - middle[1]) <= radius {
                            fine[[v, u]] = true;
                        }
                    }
                }
            }
        }
    }
    Array3::from_shape_fn((height, width, 3), |(v, u, channel)| match channel {
        0 => {
            let covered = fine.slice(ndarray::s![v * FINE..(v + 1) * FINE, u * FINE..(u + 1) * FINE]);
            let cover = covered.iter().filter(|c| **c).count() as f32 / (FINE * FINE) as f32;
            (ZERO + SPAN * (cover / FULL).min(1.0)) as u8
        }
        1 => 255,
        _ => 0,
    })
}

/// Which of the candidates stay, as the share of their length, where the photographs show the first `true_ones` of them.
fn stays(candidates: &[(TracedRoot, f64)], true_ones: usize) -> Vec<f64> {
    let maps = ring(VIEWS);
    let pictures: Vec<Array3<u8>> = maps.iter().map(|map| photograph(map, &candidates[..true_ones])).collect();
    let witnesses: Vec<Witness<'_>> = maps
        .iter()
        .zip(&pictures)
        .map(|(map, picture)| Witness { map, evidence: picture.view(), spread_px: SPREAD_PX })
        .collect();
    let pieces: Vec<TracedRoot> = candidates.iter().map(|c| c.0.clone()).collect();
    let explained = explain(&pieces, &witnesses, &ExplainParams::default()).unwrap();
    let count = |lines: &[Vec<[f64; 3]>], piece: &TracedRoot| {
        let own = |p: &&[f64; 3]| {
            let way = |q: &[f64; 3]| (Vec3::from(*q) - Vec3::from(**p)).norm();
            piece
                .root
                .points_mm
                .windows(2)
                .any(|w| (way(&w[0]) + way(&w[1]) - (Vec3::from(w[0]) - Vec3::from(w[1])).norm()).abs() < 1e-6)
        };
        lines.iter().flatten().filter(own).count() as f64
    };
    pieces
        .iter()
        .map(|piece| {
            let (kept, left) = (count(&explained.kept, piece), count(&explained.left, piece));
            kept / (kept + left)
        })
        .collect()
}

#[test]
fn true_roots_stay_and_what_others_account_for_goes() {
    let stay = stays(
        &[
            upright(0.0, 0.0, 2.0),
            upright(12.0, 3.0, 1.5),
            upright(-9.0, 8.0, 1.0),
            straight([-6.0, -12.0, 40.0], [10.0, -9.0, 80.0], 0.3),
            // Within the silhouette of the thick root; in open water; and at the side of a root.
            upright(0.9, 0.5, 0.4),
            upright(5.0, -18.0, 0.4),
            upright(13.4, 3.4, 0.4),
        ],
        4,
    );
    assert!(stay[..4].iter().all(|s| *s > 0.95), "{stay:?}");
    assert!(stay[4..].iter().all(|s| *s == 0.0), "{stay:?}");
}

#[test]
fn a_ridge_goes_on_into_the_water_and_is_cut_there() {
    let (whole, radius_mm) = upright(0.0, 0.0, 0.5);
    let half = straight([0.0, 0.0, 35.0], [0.0, 0.0, 60.0], radius_mm);
    // The photographs show the half; the only candidate is the whole.
    let maps = ring(VIEWS);
    let pictures: Vec<Array3<u8>> = maps.iter().map(|map| photograph(map, std::slice::from_ref(&half))).collect();
    let witnesses: Vec<Witness<'_>> = maps
        .iter()
        .zip(&pictures)
        .map(|(map, picture)| Witness { map, evidence: picture.view(), spread_px: SPREAD_PX })
        .collect();
    let explained = explain(&[whole], &witnesses, &ExplainParams::default()).unwrap();
    let [kept] = &explained.kept[..] else { panic!("{} stretches", explained.kept.len()) };
    let last = kept.last().unwrap()[2];
    assert!((59.0..62.0).contains(&last), "kept to {last}");
}

/// A thin root, last in the list, behind a fence of thick ones all round but for those `left_out` of 36; and how many
/// photographs show it.
fn behind_a_fence(left_out: &[usize]) -> (Vec<(TracedRoot, f64)>, usize) {
    let fence = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * (k as f64 + 0.5) / 36.0).sin_cos();
        // 3.1 mm apart, each 3.2 mm wide.
        (!left_out.contains(&k)).then(|| upright(18.0 * cos, 18.0 * sin, 1.6))
    };
    let mut roots: Vec<_> = (0..36).filter_map(fence).collect();
    let fences = roots.len();
    roots.push(straight([0.0, 0.3, 40.0], [0.5, -0.4, 80.0], 0.35));
    let shows = |map: &&ViewMap| photograph(map, &roots[..fences]) != photograph(map, &roots);
    let showing = ring(VIEWS).iter().filter(shows).count();
    (roots, showing)
}

#[test]
fn a_thin_root_that_only_four_photographs_see_stays() {
    let (roots, showing) = behind_a_fence(&[35, 0, 1, 17, 18, 19]);
    assert_eq!(showing, 4);
    let stay = stays(&roots, roots.len());
    assert!(stay[roots.len() - 1] > 0.9, "{stay:?}");
}

#[test]
fn a_thin_root_that_only_two_photographs_see_stays_and_a_ghost_beside_it_goes() {
    let (mut roots, showing) = behind_a_fence(&[35, 0, 17, 18]);
    assert_eq!(showing, 2);
    let true_ones = roots.len();
    roots.push(straight([3.0, 2.0, 40.0], [4.0, 3.0, 80.0], 0.35));
    let stay = stays(&roots, true_ones);
    assert!(stay[true_ones - 1] > 0.9 && stay[true_ones] < 0.1, "{stay:?}");
}

#[test]
fn the_judgement_is_the_same_at_any_thread_count() {
    let candidates = [upright(0.0, 0.0, 2.0), upright(12.0, 3.0, 0.4), upright(0.9, 0.5, 0.4), upright(-9.0, 8.0, 0.3)];
    let judged = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| stays(&candidates, 2))
    };
    assert_eq!(judged(1), judged(3));
}

#[test]
fn no_pieces_and_no_photographs_explain_nothing() {
    let params = ExplainParams::default();
    assert_eq!(explain(&[], &[], &params).unwrap(), Explained::default());
    let unseen = explain(&[upright(0.0, 0.0, 1.0).0], &[], &params).unwrap();
    assert!(unseen.kept.is_empty(), "nothing needs it");
    let error = explain(&[], &[], &ExplainParams { photographs: f64::NAN, share: 2.0, ..params }).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("explain.photographs") && text.contains("explain.share"), "{text}");
}
