//! Which pixels may give features to structure from motion: the printed belts, found in the photographs.
//!
//! The camera stands still while the tank turns, so that the standard deviation of a pixel over the
//! photographs tells what it shows: next to nothing in the room, something on roots and table, much on the
//! belts with their random print. What lies between the belts is seen through water and would mislead
//! structure from motion, and so would the room, which does not turn (paper 2.2.1).
//!
//! 1. Deviation per pixel over all photographs ([`Spread`]), then its mean over a square of `smooth`.
//! 2. Two thresholds that split the histogram into three classes of least variance within (Otsu's
//!    criterion, 256 bins up to the largest value); the topmost class is the belts.
//! 3. Opening by a square of `opening`: single roots go.
//! 4. Connected regions (4 neighbours) narrower than `min_width` go.
//!
//! Lengths are parts of the picture's width. One mask serves all photographs.

use crate::error::{Error, Result};
use ndarray::{Array2, ArrayView2, Zip};
use serde::{Deserialize, Serialize};

/// How belts are told from the rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MaskParams {
    /// Side of the square over which the deviation is averaged, part of the width, 0.002..0.05: a few
    /// cells of the print.
    pub smooth: f64,
    /// Side of the square that must fit into a belt, part of the width, 0..0.1: wider than roots.
    pub opening: f64,
    /// Least width of a region, part of the width, 0..1: a belt is as wide as the tank.
    pub min_width: f64,
    /// Belts given by hand instead: rectangles [left, top, width, height], px.
    pub rectangles_px: Vec<[f64; 4]>,
}

impl Default for MaskParams {
    fn default() -> Self {
        Self { smooth: 0.007, opening: 0.02, min_width: 0.1, rectangles_px: Vec::new() }
    }
}

/// Gathers sums over the photographs, one at a time.
#[derive(Debug, Clone)]
pub struct Spread {
    count: u32,
    sum: Array2<u32>,
    squares: Array2<u32>,
}

impl Spread {
    /// For gray photographs (0..255) of that height and width.
    pub fn new(height: usize, width: usize) -> Self {
        Self { count: 0, sum: Array2::zeros((height, width)), squares: Array2::zeros((height, width)) }
    }

    /// Adds a photograph.
    ///
    /// # Errors
    /// Where its size is another.
    pub fn add(&mut self, photo: ArrayView2<u8>) -> Result<()> {
        if photo.dim() != self.sum.dim() {
            let ((h, w), (height, width)) = (photo.dim(), self.sum.dim());
            return Err(Error::failed(format!("a photograph has {w} x {h} px, the first one {width} x {height}"))
                .help("all photographs of a study are taken by one camera at one resolution"));
        }
        self.count += 1;
        Zip::from(&mut self.sum).and(&mut self.squares).and(photo).for_each(|s, q, &x| {
            *s += u32::from(x);
            *q += u32::from(x) * u32::from(x);
        });
        Ok(())
    }

    /// Standard deviation per pixel, gray levels of 255.
    pub fn deviation(&self) -> Array2<f32> {
        let n = f64::from(self.count.max(1));
        Zip::from(&self.sum).and(&self.squares).map_collect(|&s, &q| {
            let mean = f64::from(s) / n;
            (f64::from(q) / n - mean * mean).max(0.0).sqrt() as f32
        })
    }
}

/// The mask: true where features may be taken.
///
/// # Errors
/// Where it hides (nearly) all of the picture or hides nothing.
pub fn belts(deviation: ArrayView2<f32>, params: &MaskParams) -> Result<Array2<bool>> {
    let (h, w) = deviation.dim();
    let mask = if params.rectangles_px.is_empty() {
        let side = |part: f64| ((part * w as f64 * 0.5).round() as usize).max(1);
        let smooth = box_mean(deviation, side(params.smooth));
        let threshold = upper_threshold(&smooth);
        let raw = smooth.mapv(|x| x > threshold);
        wide_regions(&opened(&raw, side(params.opening)), params.min_width * w as f64)
    } else {
        Array2::from_shape_fn((h, w), |(y, x)| {
            let (x, y) = (x as f64, y as f64);
            params.rectangles_px.iter().any(|r| x >= r[0] && y >= r[1] && x < r[0] + r[2] && y < r[1] + r[3])
        })
    };
    let part = mask.iter().filter(|&&m| m).count() as f64 / (h * w).max(1) as f64;
    if part < 0.002 {
        return Err(Error::failed(format!("the mask for structure from motion leaves {:.2} % of the picture", 100.0 * part))
            .help("no printed belts were found in what changes from photograph to photograph: give their place by sfm_mask.rectangles_px"));
    }
    if part > 0.7 {
        return Err(Error::failed(format!("{:.0} % of the picture changes from photograph to photograph", 100.0 * part))
            .help("the camera must stand still while the table turns, under constant light; else give the belts by sfm_mask.rectangles_px"));
    }
    Ok(mask)
}

/// Sums over all rectangles from the origin.
fn integral(values: impl Fn(usize, usize) -> f64, h: usize, w: usize) -> Array2<f64> {
    let mut sums = Array2::zeros((h + 1, w + 1));
    for y in 0..h {
        let mut row = 0.0;
        for x in 0..w {
            row += values(y, x);
            sums[(y + 1, x + 1)] = sums[(y, x + 1)] + row;
        }
    }
    sums
}

/// Mean over the square of `radius` about each pixel, as much of it as lies on the picture.
fn box_means(values: impl Fn(usize, usize) -> f64, h: usize, w: usize, radius: usize) -> Array2<f32> {
    let sums = integral(values, h, w);
    Array2::from_shape_fn((h, w), |(y, x)| {
        let (t, b) = (y.saturating_sub(radius), (y + radius + 1).min(h));
        let (l, r) = (x.saturating_sub(radius), (x + radius + 1).min(w));
        let sum = sums[(b, r)] - sums[(t, r)] - sums[(b, l)] + sums[(t, l)];
        (sum / ((b - t) * (r - l)) as f64) as f32
    })
}

fn box_mean(values: ArrayView2<f32>, radius: usize) -> Array2<f32> {
    box_means(|y, x| f64::from(values[(y, x)]), values.nrows(), values.ncols(), radius)
}

/// Erosion, then dilation by the square of `radius`.
fn opened(mask: &Array2<bool>, radius: usize) -> Array2<bool> {
    let (h, w) = mask.dim();
    let full = |m: &Array2<bool>| box_means(|y, x| f64::from(u8::from(m[(y, x)])), h, w, radius);
    let eroded = full(mask).mapv(|part| part > 1.0 - 1e-6);
    full(&eroded).mapv(|part| part > 0.0)
}

/// The upper of the two thresholds that split the values into three classes of least variance within.
fn upper_threshold(values: &Array2<f32>) -> f32 {
    const BINS: usize = 256;
    let top = values.iter().copied().fold(0.0_f32, f32::max).max(f32::MIN_POSITIVE);
    let mut count = [0.0_f64; BINS];
    for v in values {
        count[((v / top * BINS as f32) as usize).min(BINS - 1)] += 1.0;
    }
    // Σ n and Σ n i up to each bin; the variance between is Σ (Σ n i)² / Σ n over the classes.
    let (mut n, mut s) = ([0.0; BINS + 1], [0.0; BINS + 1]);
    for k in 0..BINS {
        n[k + 1] = n[k] + count[k];
        s[k + 1] = s[k] + count[k] * (k as f64 + 0.5);
    }
    let class = |from: usize, to: usize| {
        let (n, s) = (n[to] - n[from], s[to] - s[from]);
        if n > 0.0 { s * s / n } else { 0.0 }
    };
    let mut best = (f64::NEG_INFINITY, BINS - 1);
    for i in 1..BINS - 1 {
        for j in i + 1..BINS {
            let between = class(0, i) + class(i, j) + class(j, BINS);
            if between > best.0 {
                best = (between, j);
            }
        }
    }
    best.1 as f32 / BINS as f32 * top
}

/// Keeps the connected regions whose bounding box is at least `min_width` wide.
fn wide_regions(mask: &Array2<bool>, min_width: f64) -> Array2<bool> {
    let (h, w) = mask.dim();
    let mut kept = Array2::from_elem((h, w), false);
    let mut visited = kept.clone();
    for start in mask.indexed_iter().filter(|(_, m)| **m).map(|(at, _)| at) {
        if visited[start] {
            continue;
        }
        visited[start] = true;
        let mut region = vec![start];
        let (mut left, mut right) = (start.1, start.1);
        let mut next = 0;
        while next < region.len() {
            let (y, x) = region[next];
            next += 1;
            (left, right) = (left.min(x), right.max(x));
            let around = [(y.wrapping_sub(1), x), (y + 1, x), (y, x.wrapping_sub(1)), (y, x + 1)];
            for at in around {
                if at.0 < h && at.1 < w && mask[at] && !visited[at] {
                    visited[at] = true;
                    region.push(at);
                }
            }
        }
        if (right - left + 1) as f64 >= min_width {
            region.into_iter().for_each(|at| kept[at] = true);
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Room, two belts that flicker much, a thin root and a table that flicker less.
    fn capture() -> Spread {
        let mut spread = Spread::new(120, 200);
        for k in 0..12_u32 {
            let photo = Array2::from_shape_fn((120, 200), |(y, x)| {
                let hash = (y as u32 * 7919 + x as u32 * 104_729 + k * 1_299_709).wrapping_mul(2_654_435_761) >> 24;
                let noise = (hash % 4) as u8;
                match (y, x) {
                    (20..40 | 80..100, 60..140) => {
                        if hash > 127 {
                            190
                        } else {
                            30
                        }
                    }
                    (40..80, 98..102) => {
                        if hash > 127 {
                            170
                        } else {
                            40
                        }
                    }
                    (100..115, 40..160) => 60 + (hash / 4) as u8,
                    _ => 60 + noise,
                }
            });
            spread.add(photo.view()).unwrap();
        }
        spread
    }

    #[test]
    fn belts_are_found_and_root_table_and_room_left_out() {
        let mask = belts(capture().deviation().view(), &MaskParams::default()).unwrap();
        assert!(mask[(30, 100)] && mask[(90, 62)] && mask[(25, 137)]);
        assert!(!mask[(60, 100)], "the root");
        assert!(!mask[(110, 100)], "the table");
        assert!(!mask[(10, 100)] && !mask[(60, 30)], "the room");
    }

    #[test]
    fn a_mask_that_hides_all_is_an_error_with_a_remedy() {
        let params = MaskParams { rectangles_px: vec![[500.0, 0.0, 10.0, 10.0]], ..MaskParams::default() };
        let e = belts(capture().deviation().view(), &params).unwrap_err();
        assert!(e.message.contains("0.00 %") && e.help.unwrap().contains("rectangles_px"));
    }

    #[test]
    fn photographs_of_another_size_are_refused() {
        assert!(Spread::new(4, 4).add(Array2::zeros((4, 5)).view()).is_err());
    }
}
