//! How the table turned from photograph to photograph, seen on the belts' print, without cameras.
//!
//! 1. The belts' rows of each photograph, without their slow shading, are unrolled: column u of a cylinder with its axis at
//!    `axis` and its sides at ± `radius` shows the azimuth φ with `u = radius sin φ √(D² - 1) / (D - cos φ)`, D the camera's
//!    distance in radii. It is not known and taken as 4.5: angles are wrong by a common factor, 0.85 to 1.05 as a rule. A belt's
//!    rows bend towards the picture's middle row as its sides are farther off, by `(D - 1) / (D - cos φ)`; the camera looks level.
//! 2. Two photographs share print where their correlation, at the best shift of one against the other, is at least
//!    `LEAST`, and stands out by `MARGIN` from the best at other shifts. Unrelated print correlates by 0.2 at most.
//! 3. After each photograph comes the one that is turned on the least, in the direction in which most of them turn. Where
//!    that closes a ring, the common factor makes the steps 360 degrees.

use ndarray::{Array2, s};
use rayon::prelude::*;

/// The camera's distance from the axis in radii, as it is taken to be.
const DISTANCE: f64 = 4.5;
/// Azimuths that are unrolled, degrees to either side, one column a degree.
const REACH: i32 = 60;
/// Columns that two photographs have to share.
const SHARED: usize = 40;
/// Correlation of print that is the same, at least.
const LEAST: f32 = 0.24;
/// By how much it has to stand out.
const MARGIN: f32 = 0.07;
/// Turns that are shifts of the same place, degrees.
const NEAR: f64 = 5.0;

/// Where the belts are in the pictures.
#[derive(Debug, Clone, PartialEq)]
pub struct Belts {
    /// Rows of the belts.
    pub rows: Vec<usize>,
    /// Column of the tank's axis.
    pub axis: f64,
    /// Half the tank's width, px.
    pub radius: f64,
}

impl Belts {
    /// From a mask of the belts; `None` where it holds none of the tank's width.
    pub fn of(mask: &Array2<bool>) -> Option<Self> {
        let extent = |y: usize| {
            let row = mask.row(y);
            let left = row.iter().position(|m| *m)?;
            let right = row.iter().rposition(|m| *m)?;
            Some((y, left as f64, right as f64))
        };
        let wide = |(_, left, right): &(usize, f64, f64)| right - left > 0.1 * mask.ncols() as f64;
        let extents: Vec<_> = (0..mask.nrows()).filter_map(extent).filter(wide).collect();
        let middle = |of: &dyn Fn(&(usize, f64, f64)) -> f64| {
            let mut all: Vec<f64> = extents.iter().map(of).collect();
            all.sort_unstable_by(f64::total_cmp);
            all.get(all.len() / 2).copied()
        };
        let (left, right) = (middle(&|e| e.1)?, middle(&|e| e.2)?);
        Some(Self {
            rows: extents.iter().map(|e| e.0).collect(),
            axis: 0.5 * (left + right),
            radius: 0.5 * (right - left + 1.0),
        })
    }
}

/// How two photographs' prints lie against each other.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Turn {
    /// Correlation at the best shift.
    correlation: f32,
    /// That shift, degrees; positive where the second is turned on to the right.
    deg: f64,
    /// Whether it is the same print.
    is_sure: bool,
}

/// The photographs around the tank.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Ring {
    /// Photographs in the order in which the table turned, from the first.
    pub order: Vec<usize>,
    /// Turn from each of them to the next, degrees; `None` where they share no print. The last one leads to the first.
    pub steps_deg: Vec<Option<f64>>,
    /// Photographs that share print with none.
    pub alone: Vec<usize>,
    /// Pairs that show the tank in the same place: turned against each other by less than a fifth of the middle step.
    pub alike: Vec<(usize, usize)>,
}

/// The ring of photographs; `pictures` are gray, alike in size; `shifts` by how much the camera moved each, px, where it is
/// known.
pub fn ring(pictures: &[&Array2<f32>], belts: &Belts, shifts: Option<&[[f64; 2]]>) -> Ring {
    let of = |(k, picture): (usize, &&Array2<f32>)| unrolled(picture, belts, shifts.map_or([0.0; 2], |s| s[k]));
    let prints: Vec<Array2<f32>> = pictures.par_iter().enumerate().map(of).collect();
    let n = prints.len();
    let pairs: Vec<(usize, usize)> = (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))).collect();
    let found: Vec<Turn> = pairs.par_iter().map(|&(i, j)| turn(&prints[i], &prints[j])).collect();
    let mut turns = Array2::from_elem((n, n), None);
    for (&(i, j), turn) in pairs.iter().zip(&found) {
        if turn.is_sure {
            turns[(i, j)] = Some(turn.deg);
            turns[(j, i)] = Some(-turn.deg);
        }
    }
    in_order(&turns)
}

/// The order of photographs with known turns between some of them.
fn in_order(turns: &Array2<Option<f64>>) -> Ring {
    let n = turns.nrows();
    let alone: Vec<usize> = (0..n).filter(|&i| turns.row(i).iter().all(Option::is_none)).collect();
    let mut follow: Vec<f64> = (0..n).filter_map(|i| turns[(i, (i + 1) % n)]).filter(|t| t.abs() > 1.0).collect();
    follow.sort_unstable_by(f64::total_cmp);
    let right = follow.iter().filter(|t| **t > 0.0).count() * 2 >= follow.len();
    let direction = if right { 1.0 } else { -1.0 };
    follow.iter_mut().for_each(|t| *t = t.abs());
    follow.sort_unstable_by(f64::total_cmp);
    let same = 0.2 * follow.get(follow.len() / 2).copied().unwrap_or(0.0);
    let mut alike = Vec::new();
    for i in 0..n {
        alike.extend((i + 1..n).filter(|&j| turns[(i, j)].is_some_and(|t| t.abs() < same)).map(|j| (i, j)));
    }
    // Of photographs of one place, those that come later stand aside.
    let stands_aside = |k: usize| alike.iter().any(|&(_, later)| later == k) || alone.contains(&k);
    let next = |i: usize| {
        let on = |j: usize| turns[(i, j)].map(|t| direction * t).filter(|t| *t >= same.max(0.5)).map(|t| (j, t));
        let ahead = (0..n).filter(|&j| j != i && !stands_aside(j)).filter_map(on);
        ahead.min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let mut left: Vec<usize> = (0..n).filter(|&k| !stands_aside(k)).collect();
    let (mut order, mut steps_deg) = (Vec::new(), Vec::new());
    // A run begins where nothing leads to it, else with the first photograph.
    while !left.is_empty() {
        let leads = |k: usize| left.iter().any(|&i| next(i).is_some_and(|(j, _)| j == k));
        let mut at = left.iter().copied().find(|&k| !leads(k)).unwrap_or(left[0]);
        loop {
            left.retain(|&k| k != at);
            order.push(at);
            match next(at) {
                Some((j, step)) if left.contains(&j) => {
                    steps_deg.push(Some(step));
                    at = j;
                }
                Some((j, step)) if left.is_empty() && j == order[0] => {
                    steps_deg.push(Some(step));
                    break;
                }
                _ => {
                    steps_deg.push(None);
                    break;
                }
            }
        }
    }
    let first = order.iter().enumerate().min_by_key(|(_, k)| **k).map_or(0, |(at, _)| at);
    order.rotate_left(first);
    steps_deg.rotate_left(first);
    if steps_deg.iter().all(Option::is_some) && order.len() > 2 {
        let sum: f64 = steps_deg.iter().flatten().sum();
        let round = 360.0 * (sum / 360.0).round().max(1.0);
        steps_deg.iter_mut().flatten().for_each(|step| *step *= round / sum);
    }
    Ring { order, steps_deg, alone, alike }
}

/// The belts' print by azimuth, its slow shading taken off: (band of three rows, degree).
fn unrolled(picture: &Array2<f32>, belts: &Belts, shift: [f64; 2]) -> Array2<f32> {
    let (height, width) = picture.dim();
    let middle = 0.5 * (height as f64 - 1.0);
    let columns: Vec<(f64, f64)> = (-REACH..=REACH)
        .map(|deg| {
            let (sin, cos) = f64::from(deg).to_radians().sin_cos();
            let u = belts.axis + belts.radius * sin * (DISTANCE * DISTANCE - 1.0).sqrt() / (DISTANCE - cos);
            (u, nearness(cos))
        })
        .collect();
    let at = |u: f64, v: f64| {
        let inside = |p: f64, n: usize| p.clamp(0.0, n.saturating_sub(2) as f64);
        let (u, v) = (inside(u, width), inside(v, height));
        let (x, y, across, down) = (u as usize, v as usize, u.fract() as f32, v.fract() as f32);
        let row = |y: usize| picture[(y, x)] * (1.0 - across) + picture[(y, x + 1)] * across;
        row(y) * (1.0 - down) + row(y + 1) * down
    };
    let mut bands = Array2::zeros((belts.rows.len() / 3, columns.len()));
    for (mut band, rows) in bands.rows_mut().into_iter().zip(belts.rows.chunks_exact(3)) {
        for (value, &(u, near)) in band.iter_mut().zip(&columns) {
            let rows = rows.iter().map(|&y| middle + (y as f64 - middle) * near);
            *value = rows.map(|v| at(u + shift[0], v + shift[1])).sum();
        }
        let smooth: Vec<f32> = (0..columns.len())
            .map(|k| {
                let near = band.slice(s![k.saturating_sub(8)..(k + 9).min(columns.len())]);
                near.sum() / near.len() as f32
            })
            .collect();
        band.iter_mut().zip(smooth).for_each(|(value, smooth)| *value -= smooth);
    }
    bands
}

/// Size of what lies at an azimuth with that cosine over that of the front.
fn nearness(cos: f64) -> f64 {
    (DISTANCE - 1.0) / (DISTANCE - cos)
}

/// By how much the second print is turned on.
fn turn(first: &Array2<f32>, second: &Array2<f32>) -> Turn {
    let columns = first.ncols();
    let most = columns.saturating_sub(SHARED) as i32;
    let correlation = |shift: i32| {
        let (from, to) = (shift.max(0) as usize, (columns as i32 + shift.min(0)) as usize);
        let other = |k: usize| (k as i32 - shift) as usize;
        let (a, b) = (first.slice(s![.., from..to]), second.slice(s![.., other(from)..other(to - 1) + 1]));
        let (mut both, mut one, mut two) = (0.0_f32, 1e-6_f32, 1e-6_f32);
        for (a, b) in a.rows().into_iter().zip(b.rows()) {
            for (a, b) in a.iter().zip(b.iter()) {
                both += a * b;
                one += a * a;
                two += b * b;
            }
        }
        both / (one * two).sqrt()
    };
    let all: Vec<f32> = (-most..=most).map(correlation).collect();
    let Some(best) = (0..all.len()).max_by(|a, b| all[*a].total_cmp(&all[*b])) else {
        return Turn { correlation: 0.0, deg: 0.0, is_sure: false };
    };
    let peak = all[best];
    let off = if best > 0 && best + 1 < all.len() {
        let (l, r) = (all[best - 1], all[best + 1]);
        0.5 * f64::from(l - r) / f64::from(l - 2.0 * peak + r).min(-1e-6)
    } else {
        0.0
    };
    let shift = best as f64 - f64::from(most);
    let elsewhere = all.iter().enumerate().filter(|(k, _)| (*k as f64 - best as f64).abs() > NEAR).map(|(_, c)| *c);
    let elsewhere = elsewhere.fold(-1.0, f32::max);
    // Print that moves to the right in the second photograph lies at greater columns there: at a negative shift.
    Turn { correlation: peak, deg: -(shift + off), is_sure: peak >= LEAST && peak - elsewhere >= MARGIN }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: f64 = 120.0;
    const RADIUS: f64 = 80.0;

    /// A photograph of a random print on a cylinder that is turned by that angle; cells of 4 degrees.
    fn photograph(deg: f64) -> Array2<f32> {
        Array2::from_shape_fn((60, 240), |(y, x)| {
            let across = (x as f64 - AXIS) / RADIUS;
            if across.abs() >= 1.0 {
                return 30.0;
            }
            // The row of the front that lies at this height.
            let y = (29.5 + (y as f64 - 29.5) / nearness(across.asin().cos())).round().max(0.0) as usize;
            if y % 40 > 24 {
                return 30.0;
            }
            // The camera stands far off.
            let azimuth = (across.asin().to_degrees() - deg).rem_euclid(360.0);
            let cell = (azimuth / 4.0) as u64 * 64 + y as u64 / 4;
            // The finish of SplitMix64: a print whose cells have nothing to do with each other.
            let bits = (cell.wrapping_add(1)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            if (bits ^ (bits >> 31)).is_multiple_of(2) { 60.0 } else { 200.0 }
        })
    }

    fn belts() -> Belts {
        let rows = (0..60).filter(|y| y % 40 <= 24).collect();
        Belts { rows, axis: AXIS, radius: RADIUS }
    }

    fn of(turns: &[f64]) -> Ring {
        let pictures: Vec<Array2<f32>> = turns.iter().map(|t| photograph(*t)).collect();
        ring(&pictures.iter().collect::<Vec<_>>(), &belts(), None)
    }

    #[test]
    fn steps_around_the_ring_are_found_either_way() {
        let turns = [
            0.0, 22.0, 41.0, 60.0, 85.0, 104.0, 130.0, 150.0, 171.0, 190.0, 215.0, 233.0, 260.0, 282.0, 300.0, 320.0,
            341.0,
        ];
        for sign in [1.0, -1.0] {
            let ring = of(&turns.map(|t| sign * t));
            assert_eq!(ring.order, (0..17).collect::<Vec<_>>());
            for (k, step) in ring.steps_deg.iter().enumerate() {
                let want = (turns[(k + 1) % 17] - turns[k]).rem_euclid(360.0);
                assert!((step.unwrap() - want).abs() < 3.0, "{k}: {step:?} {want}");
            }
            assert!(ring.alone.is_empty() && ring.alike.is_empty());
        }
    }

    #[test]
    fn photographs_out_of_order_twice_or_missing_are_told() {
        let all: Vec<f64> = (0..18).map(|k| 20.0 * f64::from(k)).collect();
        let mut exchanged = all.clone();
        exchanged.swap(4, 11);
        let ring = of(&exchanged);
        assert_eq!((ring.order[4], ring.order[11]), (11, 4));
        let mut twice = all.clone();
        twice.insert(7, all[7] - 1.0);
        assert_eq!(of(&twice).alike, [(7, 8)]);
        let ring = of(&all[..11]);
        assert_eq!(ring.order, (0..11).collect::<Vec<_>>());
        assert!(ring.steps_deg[10].is_none() && ring.steps_deg[..10].iter().all(Option::is_some));
    }

    #[test]
    fn a_belt_without_print_shares_nothing() {
        let plain = Array2::from_elem((60, 240), 90.0_f32);
        let ring = ring(&[&plain, &plain, &plain], &belts(), None);
        assert_eq!(ring.alone, [0, 1, 2]);
    }

    #[test]
    fn the_tank_is_as_wide_as_its_belts() {
        let mask = Array2::from_shape_fn((60, 240), |(y, x)| y % 40 <= 24 && (x as f64 - AXIS).abs() < RADIUS);
        let found = Belts::of(&mask).unwrap();
        assert!((found.axis - AXIS).abs() <= 0.5 && (found.radius - RADIUS).abs() <= 1.0, "{found:?}");
        assert_eq!(found.rows, belts().rows);
        assert_eq!(Belts::of(&Array2::from_elem((9, 9), false)), None);
    }
}
