//! From light to a photograph: samples per pixel, blur, exposure, sensor noise.
//!
//! Rays go through the corners of all pixels. Where the four corners agree, the pixel is their mean;
//! where they differ, or a root passes within a pixel of one, the pixel is sampled on a regular grid of
//! `supersampling`² points; a furnished room that fills all corners is smooth and needs no closer look. Both are a box over the pixel's area. Bands of rows are computed in parallel;
//! every number depends on its own pixel alone.

use super::bvh::Tubes;
use super::noise::{hash, normal_pair};
use super::scene::Scene;
use super::walk::{Kind, Sample, Walker};
use crate::optics::Vec3;
use crate::photo::colour::srgb_of_linear;
use ndarray::Array3;
use rayon::prelude::*;

/// Rows that are computed together: their corners are shared.
const BAND: usize = 16;
/// Corners that differ by more than this (square root of linear light, near to encoded values) need a closer look.
const DIFFERENCE: f64 = 0.02;

impl Scene {
    /// Photographs the scene from a view: (y, x, rgb), sRGB. `progress` is told of every band of rows finished, with
    /// the number of its rows.
    ///
    /// # Panics
    /// Where there is no such view.
    pub fn photograph(&self, view: usize, progress: &(dyn Fn(u64) + Sync)) -> Array3<u8> {
        let lens = &self.views[view].lens;
        let (width, height) = (lens.width, lens.height);
        let tubes = self.tubes(view);
        let mut light = vec![0f32; width * height * 3];
        light.par_chunks_mut(BAND * width * 3).enumerate().for_each(|(band, rows)| {
            self.expose(view, &tubes, band * BAND, rows);
            progress((rows.len() / (width * 3)) as u64);
        });
        let blur_px = self.params.blur_px * width as f64 / 968.0;
        if blur_px > 0.0 {
            light = blurred(&light, width, height, blur_px);
        }
        let gain = &self.gains[view];
        let table = Encoder::new();
        let mut pixels = vec![0u8; width * height * 3];
        pixels.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let bits = hash(self.seed, &[view as u64, y as u64, x as u64]);
                let (a, b) = normal_pair(bits);
                let (c, _) = normal_pair(bits ^ 0x5555_5555_5555_5555);
                for (k, noise) in [a, b, c].into_iter().enumerate() {
                    let grey = table.grey(f64::from(light[(y * width + x) * 3 + k]) * gain[k]);
                    pixel[k] = (grey + self.params.noise_sigma * noise).round().clamp(0.0, 255.0) as u8;
                }
            }
        });
        // The shape is that of the vector by construction.
        Array3::from_shape_vec((height, width, 3), pixels).unwrap_or_else(|_| Array3::zeros((height, width, 3)))
    }

    /// Light of the rows from `first` on, linear.
    fn expose(&self, index: usize, tubes: &Tubes, first: usize, rows: &mut [f32]) {
        let view = &self.views[index];
        let width = view.lens.width;
        let sample = |u: f64, v: f64, reach: f64| {
            Walker::new(self, tubes, &self.stands[index], reach).sample(&view.ray_in_tank(u, v))
        };
        let corners = |y: usize| -> Vec<Sample> {
            (0..=width).map(|x| sample(x as f64 - 0.5, y as f64 - 0.5, self.reach_mm)).collect()
        };
        let n = self.params.supersampling;
        let is_smooth = self.room.is_smooth(1.0 / view.lens.focal_px);
        let mut above = corners(first);
        for (dy, row) in rows.chunks_exact_mut(width * 3).enumerate() {
            let y = first + dy;
            let below = corners(y + 1);
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let four = [&above[x], &above[x + 1], &below[x], &below[x + 1]];
                let mut light = Vec3::zeros();
                if differ(&four) && !(is_smooth && four.iter().all(|s| s.kind == Kind::Room)) {
                    for i in 0..n * n {
                        let at = |k: usize| (k as f64 + 0.5) / n as f64 - 0.5;
                        light += sample(x as f64 + at(i % n), y as f64 + at(i / n), 0.0).light;
                    }
                    light /= (n * n) as f64;
                } else {
                    light = four.iter().map(|s| s.light).sum::<Vec3>() / 4.0;
                }
                for k in 0..3 {
                    pixel[k] = light[k] as f32;
                }
            }
            above = below;
        }
    }
}

/// Whether a pixel with these corners holds detail.
fn differ(four: &[&Sample; 4]) -> bool {
    if four.iter().any(|s| s.kind != four[0].kind) {
        return true;
    }
    if four[0].kind != Kind::Root && four.iter().any(|s| s.near) {
        return true;
    }
    (0..3).any(|k| {
        let (low, high) = four.iter().fold((f64::INFINITY, 0f64), |(a, b), s| (a.min(s.light[k]), b.max(s.light[k])));
        high.sqrt() - low.max(0.0).sqrt() > DIFFERENCE
    })
}

/// Grey levels (0..255, not rounded) of linear light, by a table of the sRGB curve over the square root of
/// light, where it is nearly straight: exact to 0.01 grey levels.
struct Encoder(Vec<f64>);

impl Encoder {
    const STEPS: usize = 2048;

    fn new() -> Self {
        let at = |i: usize| 255.0 * f64::from(srgb_of_linear((i as f64 / Self::STEPS as f64).powi(2) as f32));
        Self((0..=Self::STEPS + 1).map(at).collect())
    }

    fn grey(&self, light: f64) -> f64 {
        let x = light.clamp(0.0, 1.0).sqrt() * Self::STEPS as f64;
        let i = x as usize;
        self.0[i] + (self.0[i + 1] - self.0[i]) * (x - i as f64)
    }
}

/// Convolution with a Gaussian, cut off at 4 sigma; borders repeat their last pixel.
fn blurred(light: &[f32], width: usize, height: usize, sigma: f64) -> Vec<f32> {
    let reach = (4.0 * sigma).ceil() as isize;
    let mut kernel: Vec<f64> = (-reach..=reach).map(|i| (-0.5 * (i as f64 / sigma).powi(2)).exp()).collect();
    let sum: f64 = kernel.iter().sum();
    kernel.iter_mut().for_each(|k| *k /= sum);
    let pass = |from: &[f32], dx: isize, dy: isize| -> Vec<f32> {
        let mut to = vec![0f32; from.len()];
        to.par_chunks_mut(width * 3).enumerate().for_each(|(y, row)| {
            for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                let mut sum = [0f64; 3];
                for (i, weight) in kernel.iter().enumerate() {
                    let offset = i as isize - reach;
                    let px = (x as isize + dx * offset).clamp(0, width as isize - 1) as usize;
                    let py = (y as isize + dy * offset).clamp(0, height as isize - 1) as usize;
                    for (k, s) in sum.iter_mut().enumerate() {
                        *s += weight * f64::from(from[(py * width + px) * 3 + k]);
                    }
                }
                for k in 0..3 {
                    pixel[k] = sum[k] as f32;
                }
            }
        });
        to
    };
    pass(&pass(light, 1, 0), 0, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Index, Tank};
    use crate::simulation::{CaptureParams, GrowthParams, capture, grow};

    fn scene() -> Scene {
        let tank = Tank {
            radius_mm: 45.0,
            height_mm: 130.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 18.0], [112.0, 130.0]],
        };
        let roots = grow(&GrowthParams::default(), &tank, 1).unwrap();
        let params = CaptureParams { width: 120, height: 90, views: 3, ..Default::default() };
        let views = capture(&params, &tank, 1).unwrap();
        Scene::new(&tank, &roots, &views, &params, 1).unwrap()
    }

    #[test]
    fn photographs_are_equal_at_any_thread_count() {
        let scene = scene();
        let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let three = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let shot = |pool: &rayon::ThreadPool| pool.install(|| scene.photograph(1, &|_| ()));
        assert_eq!(shot(&one), shot(&three));
        assert_ne!(scene.photograph(0, &|_| ()), scene.photograph(1, &|_| ()));
    }

    #[test]
    fn a_smooth_room_is_as_good_as_sampled_closely() {
        let tank = scene().tank;
        let room = crate::simulation::RoomParams { clutter: 0.8, windows: 1, lamps: 1, ..Default::default() };
        let (width, height) = (240, 160);
        let params = CaptureParams {
            width,
            height,
            focal_35mm: 130.0,
            distance_mm: 300.0,
            noise_sigma: 0.0,
            room,
            ..Default::default()
        };
        let params = CaptureParams { pan_deg: 10.0, ..params };
        let views = capture(&params, &tank, 1).unwrap();
        let scene = Scene::new(&tank, &[], &views, &params, 1).unwrap();
        assert!(scene.room.is_smooth(1.0 / views[0].lens.focal_px) && !scene.room.is_smooth(0.01));
        let picture = scene.photograph(0, &|_| ());
        let tubes = scene.tubes(0);
        let sample =
            |u: f64, v: f64| Walker::new(&scene, &tubes, &scene.stands[0], 0.0).sample(&views[0].ray_in_tank(u, v));
        let (mut count, mut squares) = (0.0, 0.0);
        for (x, y) in (0..height).step_by(3).flat_map(|y| (0..width).step_by(3).map(move |x| (x as f64, y as f64))) {
            let close: Vec<Sample> =
                (0..25).map(|i| sample(x + f64::from(i % 5) * 0.2 - 0.4, y + f64::from(i / 5) * 0.2 - 0.4)).collect();
            if close.iter().all(|s| s.kind == Kind::Room) {
                let light = close.iter().map(|s| s.light.y).sum::<f64>() / 25.0;
                let off = Encoder::new().grey(light) - f64::from(picture[[y as usize, x as usize, 1]]);
                assert!(off.abs() < 12.0, "({x}, {y}): {off}");
                (count, squares) = (count + 1.0, squares + off * off);
            }
        }
        assert!(count > 1000.0 && (squares / count).sqrt() < 1.0, "{count} {}", (squares / count).sqrt());
    }

    #[test]
    fn progress_counts_every_row() {
        let rows = std::sync::atomic::AtomicU64::new(0);
        scene().photograph(0, &|n| {
            rows.fetch_add(n, std::sync::atomic::Ordering::Relaxed);
        });
        assert_eq!(rows.into_inner(), 90);
    }

    #[test]
    fn encoding_table_is_the_curve() {
        let table = Encoder::new();
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((table.grey(x) - 255.0 * f64::from(srgb_of_linear(x as f32))).abs() < 0.01, "{x}");
        }
    }

    #[test]
    fn blur_keeps_the_light() {
        let mut light = vec![0f32; 40 * 40 * 3];
        light[(20 * 40 + 20) * 3] = 1.0;
        let sum: f32 = blurred(&light, 40, 40, 1.5).iter().sum();
        assert!((sum - 1.0).abs() < 1e-4);
    }
}
