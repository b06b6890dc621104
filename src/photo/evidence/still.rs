//! Which views see the same still room.
//!
//! Room pixels are those whose ray passes beside the tank, above its floor: nothing there turns with the table. Two views
//! agree where nine room pixels in ten differ by no more than noise does; views that are linked by agreement form a group.
//! A bumped tripod or another light starts a new group. A plain room looks the same from anywhere, and may.

use super::drift::Even;
use crate::optics::{Tank, View};
use crate::photo::Picture;
use rayon::prelude::*;

/// A ray passes beside the tank at so many radii: the tank stands a little off the table's axis.
const BESIDE: f64 = 1.1;
/// Share of room pixels that may differ by more: roots' shoots and passers-by.
const AGREEING: f64 = 0.9;
/// Difference that agreeing pixels may show, in noise deviations of a single view: twice what noise alone leaves at
/// `AGREEING`, and two codes for steps and compression.
const DEVIATIONS: f32 = 6.0;
const CODES: f32 = 2.0;

/// Up to `most` room pixels (y, x), evenly spread, that every view shows beside the tank.
pub fn room_pixels(views: &[View], tank: &Tank, most: usize) -> Vec<(usize, usize)> {
    let Some(first) = views.first() else { return Vec::new() };
    let (width, height) = (first.lens.width, first.lens.height);
    let step = (((width * height) as f64 / (4 * most) as f64).sqrt().floor() as usize).max(1);
    let beside = |view: &View, y: usize, x: usize| {
        let (centre, ray) = (view.centre_in_tank(), view.ray_in_tank(x as f64, y as f64));
        let across = ray.x * ray.x + ray.y * ray.y;
        let s = -(centre.x * ray.x + centre.y * ray.y) / across;
        let nearest = centre + s * ray;
        // Pictures of several lenses differ in size.
        view.holds(x as f64, y as f64)
            && nearest.x.hypot(nearest.y) > BESIDE * tank.radius_mm
            && nearest.z < 0.9 * tank.height_mm
    };
    let all: Vec<(usize, usize)> = (step..height.saturating_sub(1))
        .step_by(step)
        .flat_map(|y| (step..width.saturating_sub(1)).step_by(step).map(move |x| (y, x)))
        .filter(|&(y, x)| views.iter().all(|view| beside(view, y, x)))
        .collect();
    let keep = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(keep).collect()
}

/// Group of every view, numbered from 0 by first views.
pub fn groups(photos: &[Picture], even: &[Even], room: &[(usize, usize)]) -> Vec<usize> {
    let colours: Vec<Vec<[f32; 3]>> = photos
        .par_iter()
        .zip(even)
        .map(|(photo, even)| room.iter().map(|&(y, x)| even.pixel(photo, y, x)).collect())
        .collect();
    let noise: Vec<f32> = photos.par_iter().map(|photo| noise_between_pixels(photo, room)).collect();
    let mut group: Vec<usize> = (0..photos.len()).collect();
    for later in 1..photos.len() {
        for earlier in 0..later {
            if group[later] == group[earlier] {
                continue;
            }
            let limit = DEVIATIONS * noise[earlier].max(noise[later]) + CODES;
            if ninth_decile(&colours[earlier], &colours[later]) <= limit {
                let (from, to) = (group[later].max(group[earlier]), group[later].min(group[earlier]));
                group.iter_mut().filter(|g| **g == from).for_each(|g| *g = to);
            }
        }
    }
    let mut firsts: Vec<usize> = group.clone();
    firsts.sort_unstable();
    firsts.dedup();
    group.into_iter().map(|g| firsts.partition_point(|&f| f < g)).collect()
}

/// What the greatest channel's difference stays under in most pixels.
fn ninth_decile(a: &[[f32; 3]], b: &[[f32; 3]]) -> f32 {
    let mut differences: Vec<f32> =
        a.iter().zip(b).map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max)).collect();
    if differences.is_empty() {
        return 0.0;
    }
    let at = ((differences.len() - 1) as f64 * AGREEING) as usize;
    *differences.select_nth_unstable_by(at, f32::total_cmp).1
}

/// Noise deviation of a view, codes, from second differences along rows: slopes and shades vanish in them.
fn noise_between_pixels(photo: &Picture, room: &[(usize, usize)]) -> f32 {
    let mut differences: Vec<f32> = room
        .iter()
        .map(|&(y, x)| {
            let code = |x: usize| f32::from(photo[[y, x, 1]]);
            (code(x - 1) - 2.0 * code(x) + code(x + 1)).abs()
        })
        .collect();
    if differences.is_empty() {
        return 0.0;
    }
    let middle = differences.len() / 2;
    // The median of |second difference| is 0.6745 √6 deviations.
    *differences.select_nth_unstable_by(middle, f32::total_cmp).1 / 1.652
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A room of stripes seen from `shift` pixels aside, with noise.
    fn photo(shift: usize, light: f32, seed: usize) -> Picture {
        let mut state = seed as u32;
        Picture::from_shape_fn((60, 80, 3), |(_, x, _)| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let room = if ((x + shift) / 9).is_multiple_of(2) { 60.0 } else { 140.0 * light };
            let noise = (state >> 24) as f32 / 256.0 * 6.0 - 3.0;
            (room + noise).round() as u8
        })
    }

    #[test]
    fn a_bump_and_another_light_start_groups() {
        let photos = [
            photo(0, 1.0, 1),
            photo(0, 1.0, 2),
            photo(4, 1.0, 3),
            photo(4, 1.0, 4),
            photo(0, 0.7, 5),
            photo(0, 1.0, 6),
        ];
        let even = vec![Even::new([1.0; 3]); photos.len()];
        let room: Vec<_> = (1..59).flat_map(|y| (1..79).map(move |x| (y, x))).collect();
        assert_eq!(groups(&photos, &even, &room), [0, 0, 1, 1, 2, 0]);
    }
}
