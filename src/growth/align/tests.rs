use super::*;
use crate::growth::print::CELL_MM;
use ndarray::Array2;

const RADIUS_MM: f64 = 40.0;
const BELTS_MM: [[f64; 2]; 2] = [[0.0, 15.0], [100.0, 118.0]];

fn hash(seed: u64, a: i64, b: i64) -> f64 {
    let mut x = seed ^ (a as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ (b as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    x = (x ^ (x >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// Gray of a print of cells of 1.26 mm at a point of the wall, softened as a photograph does.
fn gray(seed: u64, x: &Vec3) -> f64 {
    let cells = 200;
    let (u, v) = ((x.y.atan2(x.x) / std::f64::consts::TAU).rem_euclid(1.0) * f64::from(cells), (x.z + 5.0) / 1.256);
    let at =
        |c: f64, r: f64| if hash(seed, (c as i64).rem_euclid(i64::from(cells)), r as i64) < 0.5 { 30.0 } else { 210.0 };
    let soft = |f: f64| ((f - 0.5) * 2.5 + 0.5).clamp(0.0, 1.0);
    let (u, v) = (u - 0.5, v - 0.5);
    let (fu, fv) = (soft(u - u.floor()), soft(v - v.floor()));
    let row = |r: f64| at(u.floor(), r) + fu * (at(u.floor() + 1.0, r) - at(u.floor(), r));
    row(v.floor()) + fv * (row(v.floor() + 1.0) - row(v.floor()))
}

/// The prints as a day shows them whose frame comes to that of the print by `motion`, in another light.
fn prints(seed: u64, motion: &Motion, light: f64) -> Vec<Print> {
    bent(seed, motion, light, 0.0)
}

/// The same unrolled with cameras that are off: bent smoothly, by waves around the tank of that standard deviation, mm.
fn bent(seed: u64, motion: &Motion, light: f64, by_mm: f64) -> Vec<Print> {
    // Both belts are seen by the same cameras.
    let normal = |k: i64| (0..12).map(|j| hash(seed + 500, k, j)).sum::<f64>() - 6.0;
    let wave = |side: i64, azimuth: f64| -> f64 {
        let harmonic = |m: i64| {
            let (sin, cos) = (m as f64 * azimuth).sin_cos();
            if m == 0 {
                normal(side) / 2.0_f64.sqrt()
            } else {
                normal(10 * m + side) * cos + normal(10 * m + 5 + side) * sin
            }
        };
        by_mm * (0..4).map(harmonic).sum::<f64>()
    };
    let unrolled = |belt: &[f64; 2]| {
        let columns = (std::f64::consts::TAU * RADIUS_MM / CELL_MM).round() as usize;
        let rows = ((belt[1] - belt[0]) / CELL_MM) as usize;
        let top_mm = belt[0] + 0.5 * CELL_MM;
        let value = |(r, c): (usize, usize)| {
            let azimuth = std::f64::consts::TAU * c as f64 / columns as f64;
            let (sin, cos) = (azimuth + wave(0, azimuth) / RADIUS_MM).sin_cos();
            let x = Vec3::new(RADIUS_MM * cos, RADIUS_MM * sin, top_mm + r as f64 * CELL_MM + wave(1, azimuth));
            let noise = 8.0 * (hash(seed + 77, r as i64 + (1000.0 * light) as i64, c as i64) - 0.5);
            (gray(seed, &motion.apply(&x)) * light * (0.8 + 0.2 * azimuth.cos()) + noise) as f32
        };
        Print { top_mm, radius_mm: RADIUS_MM, cell_mm: CELL_MM, gray: Array2::from_shape_fn((rows, columns), value) }
    };
    BELTS_MM.iter().map(unrolled).collect()
}

#[test]
fn a_day_is_found_in_another_to_a_twentieth_of_a_degree_and_of_a_millimetre() {
    for (seed, angle) in [(1, 0.3), (2, 3.0), (3, -1.7)] {
        let small = Motion::small(&Vec3::new(0.002, -0.003, 0.0), &Vec3::new(0.3, -0.2, 0.4));
        let truth = small.after(&Motion::turn(angle));
        let (first, later) = (prints(seed, &Motion::identity(), 1.0), prints(seed, &truth, 0.7));
        let found = align(&first, &later).unwrap();
        let off = found.motion.after(&truth.inverse());
        let worst = [[40.0, 0.0, 0.0], [0.0, 40.0, 118.0], [-40.0, 0.0, 60.0], [0.0, 0.0, 118.0]]
            .map(|p| (off.apply(&Vec3::from(p)) - Vec3::from(p)).norm())
            .into_iter()
            .fold(0.0, f64::max);
        assert!(worst < 0.05 && off.azimuth().to_degrees().abs() < 0.05, "{worst} mm, {}", off.azimuth().to_degrees());
        assert!(found.place_sd_mm < 0.05, "{}", found.place_sd_mm);
        assert!(found.by_belts && found.agreement > 0.7, "{}", found.agreement);
    }
}

#[test]
fn deviations_hold_the_truth_as_often_as_they_say() {
    let (mut within, mut azimuths) = ([0; 2], Vec::new());
    const PAIRS: usize = 24;
    for seed in 1..=PAIRS as u64 {
        let truth = Motion::small(&Vec3::new(0.001, -0.002, 0.0), &Vec3::new(0.2, -0.1, 0.3))
            .after(&Motion::turn(0.25 * seed as f64));
        let found = align(&prints(seed, &Motion::identity(), 1.0), &bent(seed, &truth, 0.8, 0.02)).unwrap();
        let off = found.motion.after(&truth.inverse()).azimuth().to_degrees().abs() / found.azimuth_sd_deg;
        within.iter_mut().zip([1.0, 2.0]).for_each(|(n, sd)| *n += usize::from(off <= sd));
        azimuths.push(off);
    }
    // 68 and 95 % of so many, give or take what chance does.
    assert!((11..=21).contains(&within[0]) && within[1] >= 20, "{within:?} of {PAIRS}: {azimuths:.2?}");
}

#[test]
fn another_print_is_refused_and_a_plain_belt_gives_nothing() {
    let first = prints(1, &Motion::identity(), 1.0);
    for other in [5, 6, 7] {
        match align(&first, &prints(other, &Motion::turn(1.0), 0.9)) {
            Err(Unmatched::Other(agreement)) => assert!(agreement < 0.2, "{agreement}"),
            other => panic!("{other:?}"),
        }
    }
    let mut plain = prints(1, &Motion::identity(), 1.0);
    plain.iter_mut().for_each(|p| p.gray.fill(180.0));
    assert!(matches!(align(&first, &plain), Err(Unmatched::Plain(_))));
}
