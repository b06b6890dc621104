//! What the paper's two-step search costs in accuracy against the exact inverse: a table, and the figure of
//! docs/rendering.md.  `cargo bench --bench map_error -- docs/map-error.svg`
//!
//! The scene is the paper's: tank of 90 mm, 171 x 171 x 180 voxels of 1 mm, a camera 39 cm before the wall,
//! 968 x 648 px.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

use plotters::prelude::*;
use rootvox::optics::{Distortion, Index, Lens, Mat3, Tank, Vec3, View, ViewMap};
use rootvox::volume::map_error::{Deviation, MapError, deviations};
use rootvox::volume::patch_rbf::lattice;
use rootvox::volume::{Grid, PatchMap, PatchRbf};

/// Distances between sampled voxels: prime to the lattice's ten.
const STEP: usize = 7;
/// Width of the figure's rings, mm.
const RING_MM: f64 = 5.0;

fn main() {
    let tank = Tank {
        radius_mm: 90.0,
        height_mm: 246.6,
        wall_mm: 5.0,
        water_level_mm: 12.0,
        index: Index::default(),
        belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
    };
    let forward = Vec3::new(-1.0, 0.0, 0.07).normalize();
    let right = forward.cross(&Vec3::z()).normalize();
    let rotation = Mat3::from_rows(&[right.transpose(), forward.cross(&right).transpose(), forward.transpose()]);
    let distortion = Distortion { k1: -0.09, k2: 0.05, p1: 4e-4, p2: -3e-4, k3: 0.0, ..Distortion::default() };
    let lens = Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.0, cy: 320.0, distortion };
    let view = View { lens, rotation, translation_mm: -(rotation * Vec3::new(480.0, 0.0, 90.0)) };
    let grid = Grid::of_tank(&tank, 1.0, 180.0).expect("the paper's grid");
    let map = ViewMap::new(&view.ideal(), &tank).expect("a camera outside");

    println!("patch px | every | where | median px | p95 px | max px | voxels | lost");
    for (patch_px, every) in [(64, 10), (64, 5), (128, 10)] {
        let sizes = PatchRbf { patch_px, every, ..PatchRbf::default() };
        let nodes = lattice(&view, &tank, &grid, &sizes).expect("sizes are not zero");
        let search = PatchMap::new(&view, &tank, &grid, sizes, nodes);
        let found = deviations(&search, &map, &grid, STEP);
        for (name, e) in ["inside", "near the wall"].into_iter().zip(MapError::inside_and_near_wall(&found)) {
            println!(
                "{patch_px} | {every} | {name} | {:.3} | {:.3} | {:.2} | {} | {}",
                e.median_px, e.p95_px, e.max_px, e.voxels, e.lost
            );
        }
        let wanted = std::env::args().skip(1).find(|a| a.ends_with(".svg"));
        if let (Some(path), (64, 10)) = (wanted, (patch_px, every)) {
            draw(&path, &found).expect("the figure can be drawn");
        }
    }
}

/// Median, 95 of 100 and largest deviation over the distance from the wall.
fn draw(path: &str, found: &[Deviation]) -> Result<(), Box<dyn std::error::Error>> {
    let rings: Vec<(f64, MapError)> = (0..17)
        .map(|n| f64::from(n) * RING_MM)
        .map(|from| (from + RING_MM / 2.0, MapError::of(found, |d| (from..from + RING_MM).contains(&d.to_wall_mm))))
        .filter(|(_, error)| error.voxels > 0)
        .collect();
    let root = SVGBackend::new(path, (760, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(12)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(0.0..85.0, (0.01..20.0).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("distance from the inner wall, mm")
        .y_desc("patch-rbf against the exact inverse, px")
        .label_style(("sans-serif", 14))
        .draw()?;
    type Value = fn(&MapError) -> f64;
    let curves: [(&str, Value, RGBColor); 3] = [
        ("largest", |e| e.max_px, RGBColor(200, 30, 30)),
        ("95 of 100 below", |e| e.p95_px, RGBColor(220, 140, 0)),
        ("median", |e| e.median_px, RGBColor(30, 90, 200)),
    ];
    for (name, value, colour) in curves {
        let points: Vec<(f64, f64)> = rings.iter().map(|(at, error)| (*at, value(error))).collect();
        chart
            .draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        chart.draw_series(points.into_iter().map(|at| Circle::new(at, 3, colour.filled())))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE)
        .border_style(BLACK)
        .label_font(("sans-serif", 14))
        .draw()?;
    root.present()?;
    Ok(())
}
