//! Which pixels look into the water: through clear wall, below the water surface, above the floor.

use crate::optics::{Tank, View, trace};
use ndarray::{Array2, Axis};
use rayon::prelude::*;

/// Edge of the blocks whose corners are traced; blocks that agree in all corners are not looked into.
const BLOCK: usize = 8;

/// (y, x) of the pixels of `view` (an ideal lens, the photograph's size) whose rays enter the water unhindered.
pub fn clear_pixels(view: &View, tank: &Tank) -> Array2<bool> {
    let (width, height) = (view.lens.width, view.lens.height);
    let centre = view.centre_in_tank();
    let is_clear = |x: usize, y: usize| {
        trace(tank, &centre, &view.ray_in_tank(x as f64, y as f64)).is_some_and(|ray| {
            tank.is_clear(ray.p1_mm.z) && ray.p2_mm.z > tank.water_level_mm && ray.p2_mm.z < tank.floor_mm()
        })
    };
    let mut out = Array2::from_elem((height, width), false);
    out.axis_chunks_iter_mut(Axis(0), BLOCK).into_par_iter().enumerate().for_each(|(n, mut rows)| {
        let (top, bottom) = (n * BLOCK, (n * BLOCK + BLOCK).min(height) - 1);
        let mut left = [is_clear(0, top), is_clear(0, bottom)];
        for from in (0..width).step_by(BLOCK) {
            let last = (from + BLOCK).min(width) - 1;
            let right = [is_clear(last, top), is_clear(last, bottom)];
            let agree = left == right && left[0] == left[1];
            for (y, mut row) in rows.axis_iter_mut(Axis(0)).enumerate() {
                for x in from..=last {
                    row[x] = if agree { left[0] } else { is_clear(x, top + y) };
                }
            }
            left = right;
        }
    });
    out
}
