//! What stands still beside the tank: whether the camera does, and how even the light is.
//!
//! The middle of each pixel over all photographs, without the tank's columns, is the room. Pixels whose middle deviation is as
//! small as noise stand still. Each photograph's gain is its sum over them against the room's; its shift, by one step of least
//! squares on the room's slopes, is how far the camera's picture has moved.

use super::ring::Belts;
use ndarray::{Array2, Array3, Axis};
use rayon::prelude::*;

/// Columns beside the tank that are left out, part of its radius: it stands a little off the table's axis.
const BESIDE: f64 = 1.1;
/// Deviations over the noise that a pixel that stands still may show.
const STILL: f32 = 3.0;
/// Steps of gray values: no noise is smaller.
const STEP: f32 = 1.0;

/// The room as all photographs show it.
#[derive(Debug, Clone)]
pub struct Room {
    /// Share of the pixels beside the tank that stand still.
    pub still: f64,
    /// Gray values of each photograph over those of the room.
    pub gains: Vec<f64>,
    /// (right, down) by which each photograph's room is moved against the middle one, px of the pictures; `None` where the
    /// room is too plain to tell.
    pub shifts: Option<Vec<[f64; 2]>>,
}

/// The room beside the tank; `pictures` are gray, alike in size, at least one.
pub fn room(pictures: &[&Array2<f32>], belts: Option<&Belts>) -> Room {
    let (height, width) = pictures.first().map_or((0, 0), |p| p.dim());
    let middle = middle(pictures, |value, _| value);
    let deviation = self::middle(pictures, |value, at| (value - middle[at]).abs());
    let beside = |x: usize| belts.is_none_or(|b| (x as f64 - b.axis).abs() > BESIDE * b.radius);
    let inside = |(y, x): &(usize, usize)| *y > 0 && *x > 0 && y + 1 < height && x + 1 < width && beside(*x);
    let all: Vec<(usize, usize)> = (0..height).flat_map(|y| (0..width).map(move |x| (y, x))).filter(inside).collect();
    let mut deviations: Vec<f32> = all.iter().map(|at| deviation[*at]).collect();
    deviations.sort_unstable_by(f32::total_cmp);
    let noise = deviations.get(deviations.len() / 2).copied().unwrap_or(0.0).min(8.0) + STEP;
    let still: Vec<(usize, usize)> = all.iter().copied().filter(|at| deviation[*at] < STILL * noise).collect();
    let sum = |of: &Array2<f32>| still.iter().map(|at| f64::from(of[*at])).sum::<f64>();
    let whole = sum(&middle).max(1.0);
    let gains: Vec<f64> = pictures.par_iter().map(|picture| sum(picture) / whole).collect();
    let slope = |(y, x): (usize, usize)| {
        let half = |a: (usize, usize), b: (usize, usize)| 0.5 * f64::from(middle[a] - middle[b]);
        [half((y, x + 1), (y, x - 1)), half((y + 1, x), (y - 1, x))]
    };
    let slopes: Vec<[f64; 2]> = still.iter().map(|at| slope(*at)).collect();
    let noise = f64::from(noise);
    let shift = |(picture, gain): (&&Array2<f32>, &f64)| {
        let (mut a, mut b, mut c, mut right, mut down) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (at, [across, along]) in still.iter().zip(&slopes) {
            let off = f64::from(picture[*at]) / gain.max(1e-3) - f64::from(middle[*at]);
            let weight = 1.0 / (1.0 + (off / (f64::from(STILL) * noise)).powi(2));
            a += weight * across * across;
            b += weight * across * along;
            c += weight * along * along;
            right -= weight * across * off;
            down -= weight * along * off;
        }
        let det = a * c - b * b;
        // The smaller eigenvalue holds the less certain direction: a shift of a tenth of a pixel must stand out.
        let least = 0.5 * (a + c) - (0.25 * (a - c).powi(2) + b * b).sqrt();
        (least.sqrt() > 30.0 * noise).then(|| [(c * right - b * down) / det, (a * down - b * right) / det])
    };
    let shifts = pictures.par_iter().zip(&gains).map(shift).collect();
    Room { still: still.len() as f64 / all.len().max(1) as f64, gains, shifts }
}

/// The middle of what each pixel's values become.
fn middle(pictures: &[&Array2<f32>], of: impl Fn(f32, (usize, usize)) -> f32 + Sync) -> Array2<f32> {
    let (height, width) = pictures.first().map_or((0, 0), |p| p.dim());
    let mut out = Array2::zeros((height, width));
    out.axis_iter_mut(Axis(0)).into_par_iter().enumerate().for_each(|(y, mut row)| {
        let mut values = vec![0.0_f32; pictures.len()];
        for (x, out) in row.iter_mut().enumerate() {
            values.iter_mut().zip(pictures).for_each(|(value, picture)| *value = of(picture[(y, x)], (y, x)));
            let half = values.len() / 2;
            *out = *values.select_nth_unstable_by(half, f32::total_cmp).1;
        }
    });
    out
}

/// Standard deviation of each pixel over the pictures, gray values.
pub fn deviation(pictures: &[&Array2<f32>]) -> Array2<f32> {
    let (height, width) = pictures.first().map_or((0, 0), |p| p.dim());
    let all = Array3::from_shape_fn((pictures.len(), height, width), |(k, y, x)| pictures[k][(y, x)]);
    all.std_axis(Axis(0), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room with things in it, moved to the right by `shift` px and lit by `gain`, with noise.
    fn photograph(view: usize, shift: f64, gain: f64) -> Array2<f32> {
        Array2::from_shape_fn((80, 160), |(y, x)| {
            let (u, v) = (x as f64 - shift, y as f64);
            let noise = ((view * 31 + y * 7919 + x * 104_729).wrapping_mul(2_654_435_761) >> 16) % 5;
            ((90.0 + 50.0 * (u / 7.0).sin() * (v / 9.0).cos()) * gain + noise as f64 - 2.0) as f32
        })
    }

    fn of(pictures: &[Array2<f32>]) -> Room {
        room(&pictures.iter().collect::<Vec<_>>(), None)
    }

    #[test]
    fn a_camera_that_stands_still_has_no_shift() {
        let room = of(&(0..12).map(|k| photograph(k, 0.0, 1.0)).collect::<Vec<_>>());
        assert!(room.still > 0.95 && room.gains.iter().all(|g| (g - 1.0).abs() < 0.01), "{room:?}");
        assert!(room.shifts.unwrap().iter().flatten().all(|s| s.abs() < 0.03));
    }

    #[test]
    fn a_bump_and_a_gain_are_measured() {
        let room = of(&(0..12)
            .map(|k| photograph(k, if k < 4 { 0.6 } else { 0.0 }, if k == 9 { 0.8 } else { 1.0 }))
            .collect::<Vec<_>>());
        let shifts = room.shifts.unwrap();
        let moved = [shifts[2][0] - shifts[8][0], shifts[2][1] - shifts[8][1]];
        assert!((moved[0] - 0.6).abs() < 0.08 && moved[1].abs() < 0.05, "{shifts:?}");
        assert!((room.gains[9] - 0.8).abs() < 0.02 && (room.gains[3] - 1.0).abs() < 0.02, "{:?}", room.gains);
    }

    #[test]
    fn a_plain_room_tells_no_shift() {
        let plain = of(&(0..5).map(|k| photograph(k, 0.0, 0.0)).collect::<Vec<_>>());
        assert!(plain.shifts.is_none());
    }
}
