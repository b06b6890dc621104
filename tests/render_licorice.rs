//! The true roots of licorice-sim, mapped through the refraction, lie on the roots of the photographs.

#![allow(clippy::print_stdout, reason = "the figures are what it is for")]

use ndarray::Axis;
use rootvox::optics::{Tank, Vec3, View, ViewMap};
use rootvox::photo;
use rootvox::volume::{RenderOptions, ViewRenderer};
use std::path::PathBuf;

/// Folder of the photographed data sets; `None` where the variable is unset.
fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("ROOTVOX_TEST_DATA").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("skipped: ROOTVOX_TEST_DATA (the folder that holds licorice-sim/) is not set");
    }
    folder
}

fn views(folder: &std::path::Path) -> (Vec<(String, View)>, Tank) {
    let cameras: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.join("cameras.json")).unwrap()).unwrap();
    let lens: rootvox::optics::Lens = serde_json::from_value(cameras["intrinsics"].clone()).unwrap();
    let number = |v: &serde_json::Value| v.as_f64().unwrap();
    let views = cameras["views"].as_array().unwrap().iter().map(|view| {
        let rotation = rootvox::optics::Mat3::from_fn(|i, j| number(&view["R"][i][j]));
        let translation_mm = Vec3::from_fn(|i, _| number(&view["t"][i]));
        (view["file"].as_str().unwrap().to_owned(), View { lens, rotation, translation_mm })
    });
    let tank: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.join("tank.json")).unwrap()).unwrap();
    let tank = Tank {
        radius_mm: number(&tank["r"]),
        height_mm: number(&tank["h"]),
        wall_mm: number(&tank["tau"]),
        water_level_mm: number(&tank["z_w"]),
        index: rootvox::optics::Index {
            air: number(&tank["n_air"]),
            wall: number(&tank["n_wall"]),
            water: number(&tank["n_water"]),
        },
        belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
    };
    (views.collect(), tank)
}

#[test]
fn true_roots_lie_on_the_photographed_roots() {
    let Some(folder) = data() else { return };
    let folder = folder.join("licorice-sim");
    let (views, tank) = views(&folder);
    let roots: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.join("roots.json")).unwrap()).unwrap();
    let roots = roots.get("roots").unwrap_or(&roots).as_array().unwrap().clone();
    for index in [0, 13] {
        let (file, view) = &views[index];
        let bytes = std::fs::read(folder.join(file)).unwrap();
        let photograph = photo::undistort(&photo::decode(&bytes, file).unwrap().into_picture(), &view.lens);
        let map = ViewMap::new(&view.ideal(), &tank).unwrap();
        let (height, width, _) = photograph.dim();
        let mut painted = photograph.clone();
        let gray = |u: f64, v: f64| {
            let (x, y) = (u.round() as usize, v.round() as usize);
            (0..3).map(|c| f64::from(photograph[[y, x, c]])).sum::<f64>() / 3.0
        };
        // On the centreline it is brighter than 4 px to either side.
        let (mut on, mut beside, mut count) = (0.0, 0.0, 0);
        for root in &roots {
            let points: Vec<Vec3> = root["points"]
                .as_array()
                .unwrap()
                .iter()
                .map(|p| Vec3::from_fn(|i, _| p[i].as_f64().unwrap()))
                .collect();
            for pair in points.windows(2) {
                let (Some(a), Some(b)) = (map.project(&pair[0]), map.project(&pair[1])) else { continue };
                let (du, dv) = (b.u - a.u, b.v - a.v);
                let length = du.hypot(dv);
                let inside = a.u > 6.0 && a.v > 6.0 && a.u < width as f64 - 7.0 && a.v < height as f64 - 7.0;
                if !a.clear || a.distance_mm > 1e-3 || !inside || length < 1e-3 {
                    continue;
                }
                on += gray(a.u, a.v);
                for side in [-4.0, 4.0] {
                    beside += 0.5 * gray(a.u - side * dv / length, a.v + side * du / length);
                }
                count += 1;
                let (x, y) = (a.u.round() as usize, a.v.round() as usize);
                (painted[[y, x, 0]], painted[[y, x, 1]], painted[[y, x, 2]]) = (255, 40, 40);
            }
        }
        let (on, beside) = (on / f64::from(count), beside / f64::from(count));
        eprintln!("{file}: {count} points, {on:.1} on the roots, {beside:.1} beside them");
        if let Some(out) = std::env::var_os("ROOTVOX_TEST_PICTURES") {
            let name = PathBuf::from(out).join(format!("licorice-{index:03}.png"));
            let raw = painted.into_raw_vec_and_offset().0;
            image::RgbImage::from_raw(width as u32, height as u32, raw).unwrap().save(name).unwrap();
        }
        assert!(count > 5000 && on > beside + 15.0);
    }
}

/// Cost and coverage of one view on the paper's grid.
#[test]
fn a_view_fills_the_water_that_it_sees() {
    let Some(folder) = data() else { return };
    let folder = folder.join("licorice-sim");
    let (views, tank) = views(&folder);
    let (file, view) = &views[0];
    let photograph = photo::decode(&std::fs::read(folder.join(file)).unwrap(), file).unwrap().into_picture();
    let picture = photo::undistort(&photograph, &view.lens);
    let renderer = ViewRenderer::new(view, &tank, &picture, RenderOptions::default()).unwrap();
    let grid = rootvox::volume::Grid::of_tank(&tank, 1.0, 180.0).unwrap();
    let mut out = ndarray::Array4::<u8>::zeros((180, 171, 171, 4));
    let start = std::time::Instant::now();
    renderer.render_slab(&grid, 0..180, out.view_mut());
    eprintln!("one view, 171 x 171 x 180: {:.3} s", start.elapsed().as_secs_f64());
    let seen = out.index_axis(Axis(0), 120).index_axis(Axis(2), 3).iter().filter(|&&m| m == 255).count() as f64;
    let disc = std::f64::consts::PI * 85.0 * 85.0;
    eprintln!("seen at z = 120 mm: {:.3} of the water", seen / disc);
    assert!(seen / disc > 0.7 && seen / disc < 0.99);
    // The same bits slab by slab.
    let mut slab = ndarray::Array4::<u8>::zeros((7, 171, 171, 4));
    renderer.render_slab(&grid, 100..107, slab.view_mut());
    assert_eq!(slab, out.slice_axis(Axis(0), (100..107).into()));
    if let Some(folder) = std::env::var_os("ROOTVOX_TEST_PICTURES") {
        let raw = out.index_axis(Axis(0), 120).iter().copied().collect();
        image::RgbaImage::from_raw(171, 171, raw).unwrap().save(PathBuf::from(folder).join("slice-120.png")).unwrap();
    }
}
