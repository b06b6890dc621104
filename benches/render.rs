//! From photograph to voxels: cost of each step.
//! `cargo bench --bench render`; one thread: `RAYON_NUM_THREADS=1 cargo bench --bench render`.
//!
//! The scene is the paper's: tank of 90 mm, 171 x 171 x 180 voxels of 1 mm, a camera 39 cm before the wall; the
//! picture is noise, which costs as much as any.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

use divan::Bencher;
use ndarray::Array4;
use rootvox::optics::inverse::{LANES, March};
use rootvox::optics::{Distortion, Index, Lens, Mat3, Tank, Vec3, View, ViewMap};
use rootvox::photo::{self, Picture};
use rootvox::volume::patch_rbf::lattice;
use rootvox::volume::{Grid, PatchMap, PatchRbf, PatchRbfRenderer, RenderOptions, ViewRenderer};

fn main() {
    divan::main();
}

fn tank() -> Tank {
    Tank {
        radius_mm: 90.0,
        height_mm: 246.6,
        wall_mm: 5.0,
        water_level_mm: 12.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
    }
}

/// The paper's camera, 968 x 648 px at scale 1 and 3872 x 2592 px at scale 4.
fn view(scale: usize) -> View {
    let forward = Vec3::new(-1.0, 0.0, 0.07).normalize();
    let right = forward.cross(&Vec3::z()).normalize();
    let rotation = Mat3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
    let s = scale as f64;
    let distortion = Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.0, ..Distortion::default() };
    let lens =
        Lens { width: 968 * scale, height: 648 * scale, focal_px: 984.0 * s, cx: 488.0 * s, cy: 320.0 * s, distortion };
    View { lens, rotation, translation_mm: -(rotation * Vec3::new(480.0, 0.0, 90.0)) }
}

fn picture(scale: usize) -> Picture {
    let mut state = 1u32;
    Picture::from_shape_simple_fn((648 * scale, 968 * scale, 3), || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    })
}

fn grid() -> Grid {
    Grid::of_tank(&tank(), 1.0, 180.0).expect("the paper's grid")
}

/// The pixels of every voxel of the grid, nothing sampled; sums them, so that nothing is left out.
struct MapAll<'a> {
    grid: &'a Grid,
    map: &'a ViewMap,
}

impl pulp::WithSimd for MapAll<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f64 {
        let (grid, map) = (self.grid, self.map);
        let [depth, rows, columns] = grid.shape;
        let mut sum = 0.0;
        for k in 0..depth {
            for j in (0..rows).step_by(LANES) {
                let y: [f64; LANES] = std::array::from_fn(|l| grid.point_mm(0.0, (j + l) as f64, 0.0).y);
                let mut march = March::new(map, grid.origin_mm[0], &y, k as f64, 1.0, 1.0);
                for i in 0..columns {
                    let x = grid.point_mm(0.0, 0.0, i as f64).x;
                    let wanted: [bool; LANES] =
                        std::array::from_fn(|l| j + l < rows && x * x + y[l] * y[l] <= 85.0 * 85.0);
                    if wanted.contains(&true) {
                        let lanes = march.column(i, &wanted);
                        sum += map.clear_pixels(&lanes).v.iter().filter(|v| v.is_finite()).sum::<f64>();
                    }
                }
            }
        }
        sum
    }
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn map_one_view(bencher: Bencher) {
    let (grid, tank) = (grid(), tank());
    let map = ViewMap::new(&view(1).ideal(), &tank).expect("a camera outside");
    bencher.bench_local(|| pulp::Arch::new().dispatch(MapAll { grid: &grid, map: &map }));
}

#[divan::bench(args = [1, 4], sample_count = 3, sample_size = 1)]
fn render_one_view(bencher: Bencher, scale: usize) {
    let (grid, picture) = (grid(), picture(scale));
    let mut out = Array4::zeros((180, 171, 171, 4));
    bencher.bench_local(|| {
        let renderer =
            ViewRenderer::new(&view(scale), &tank(), &picture, RenderOptions::default()).expect("sizes agree");
        renderer.render_slab(&grid, 0..180, out.view_mut());
    });
}

#[divan::bench(args = [1, 4], sample_count = 3, sample_size = 1)]
fn undistort(bencher: Bencher, scale: usize) {
    let (picture, view) = (picture(scale), view(scale));
    bencher.bench_local(|| photo::undistort(&picture, &view.lens));
}

#[divan::bench(args = [1, 4], sample_count = 3, sample_size = 1)]
fn decode_jpeg(bencher: Bencher, scale: usize) {
    let raw = picture(scale).into_raw_vec_and_offset().0;
    let image = image::RgbImage::from_raw(968 * scale as u32, 648 * scale as u32, raw).expect("three bytes a pixel");
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Jpeg).expect("writing to memory");
    bencher.bench_local(|| photo::decode(bytes.get_ref(), "noise.jpg"));
}

#[divan::bench(sample_count = 2, sample_size = 1)]
fn patch_rbf_lattice(bencher: Bencher) {
    bencher.bench_local(|| lattice(&view(1), &tank(), &grid(), &PatchRbf::default()));
}

#[divan::bench(sample_count = 2, sample_size = 1)]
fn patch_rbf_render(bencher: Bencher) {
    let (picture, grid) = (picture(1), grid());
    let nodes = lattice(&view(1), &tank(), &grid, &PatchRbf::default()).expect("sizes are not zero");
    let map = PatchMap::new(&view(1), &tank(), &grid, PatchRbf::default(), nodes);
    let renderer = PatchRbfRenderer::new(map, &picture);
    let mut out = Array4::zeros((180, 171, 171, 4));
    bencher.bench_local(|| renderer.render_slab(0..180, out.view_mut()));
}
