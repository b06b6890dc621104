//! Cost of rendering and merging over the grid's fineness and the number of views: the table of docs/rendering.md.
//! `cargo bench --bench scaling`, or `cargo bench --bench scaling -- --whole` to work through every plane of the finest
//! grids too (about an hour on two cores).
//!
//! The scene is the paper's tank, N cameras around it, 968 x 648 px of noise each; views are rendered slab by slab
//! into the merge (shares of root with their confidences, the default estimator), in slabs as the stages take them,
//! nothing is stored. Without `--whole` each cell works through evenly spaced slabs, some [`ENOUGH`] voxels times views, and is
//! scaled up to the grid. Seconds are processor time (user and system, from
//! /proc/self/stat), which other work on the machine does not change much.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

use ndarray::Array4;
use rayon::prelude::*;
use rootvox::optics::{Distortion, Index, Lens, Mat3, Tank, Vec3, View};
use rootvox::photo::Picture;
use rootvox::volume::merge::{Merge, merge_evidence};
use rootvox::volume::{Grid, RenderOptions, ViewRenderer};

/// Planes worked on at once at most, and the bytes that they may take, as in the stages.
const SLAB: usize = 16;
const SLAB_BYTES: usize = 512 << 20;
/// Voxels times views after which a cell is known well enough.
const ENOUGH: usize = 60_000_000;
/// Slabs worked through at least.
const FEWEST: usize = 3;

fn main() {
    let whole = std::env::args().any(|a| a == "--whole");
    let tank = Tank {
        radius_mm: 90.0,
        height_mm: 246.6,
        wall_mm: 5.0,
        water_level_mm: 12.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
    };
    let mut state = 1u32;
    let mut noise = Picture::from_elem((648, 968, 3), 0);
    for mut pixel in noise.rows_mut() {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (pixel[0], pixel[1]) = ((state >> 24) as u8, (state >> 16) as u8);
    }
    println!("spacing mm | voxels | views | render s | merge s | ns per voxel and view | share of the planes");
    for spacing in [2.0, 1.0, 0.5, 0.25] {
        let grid = Grid::of_tank(&tank, spacing, 180.0).expect("a grid in the tank");
        for views in [9, 18, 36, 72] {
            let renderers: Vec<ViewRenderer> = (0..views)
                .map(|n| {
                    let view = view(std::f64::consts::TAU * f64::from(n) / f64::from(views));
                    ViewRenderer::new(&view, &tank, &noise, RenderOptions::default()).expect("sizes agree")
                })
                .collect();
            let mut depth = SLAB;
            while depth > 1 && depth * grid.shape[1] * grid.shape[2] * (4 * renderers.len() + 17) > SLAB_BYTES {
                depth /= 2;
            }
            let slabs: Vec<usize> = (0..grid.shape[0]).step_by(depth).collect();
            let cost = grid.len() * renderers.len();
            let every = if whole { 1 } else { cost.div_ceil(ENOUGH).min(slabs.len() / FEWEST).max(1) };
            let chosen: Vec<usize> = slabs.iter().copied().skip(every / 2).step_by(every).collect();
            let (mut render_s, mut merge_s) = (0.0, 0.0);
            for &from in &chosen {
                let planes = from..(from + depth).min(grid.shape[0]);
                let begun = processor_seconds();
                let slabs: Vec<Array4<u8>> = renderers
                    .par_iter()
                    .map(|renderer| {
                        let mut slab = Array4::zeros((planes.len(), grid.shape[1], grid.shape[2], 4));
                        renderer.render_slab(&grid, planes.clone(), slab.view_mut());
                        slab
                    })
                    .collect();
                let rendered = processor_seconds();
                let of_views: Vec<_> = slabs.iter().map(|slab| slab.view()).collect();
                std::hint::black_box(merge_evidence(&of_views, &Merge::default()).expect("equal shapes"));
                render_s += rendered - begun;
                merge_s += processor_seconds() - rendered;
            }
            let scale = slabs.len() as f64 / chosen.len() as f64;
            println!(
                "{spacing} | {} | {views} | {:.1} | {:.1} | {:.1} | 1/{every}",
                grid.len(),
                render_s * scale,
                merge_s * scale,
                (render_s + merge_s) * scale / cost as f64 * 1e9
            );
        }
    }
}

/// The paper's camera at an azimuth (radians).
fn view(azimuth: f64) -> View {
    let centre = Vec3::new(480.0 * azimuth.cos(), 480.0 * azimuth.sin(), 90.0);
    let forward = Vec3::new(-azimuth.cos(), -azimuth.sin(), 0.07).normalize();
    let right = forward.cross(&Vec3::z()).normalize();
    let rotation = Mat3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
    let lens =
        Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.0, cy: 320.0, distortion: Distortion::default() };
    View { lens, rotation, translation_mm: -(rotation * centre) }
}

/// Seconds of processor time that this process has used, to a hundredth.
fn processor_seconds() -> f64 {
    let stat = std::fs::read_to_string("/proc/self/stat").expect("Linux tells");
    let fields: Vec<&str> = stat.rsplit(')').next().unwrap_or_default().split_whitespace().collect();
    let ticks = |n: usize| fields[n].parse::<f64>().expect("a number");
    (ticks(11) + ticks(12)) / 100.0
}
