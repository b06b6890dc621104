//! The voxels' edge, where a study leaves `grid.spacing` out: the pixel's footprint at the tank's axis.
//!
//! Finer voxels hold nothing that the photographs show, coarser ones blur what they do. Known cameras tell the footprint,
//! distance over focal length in px, in the middle of all views; where cameras are yet to be found, the tank is taken to fill four fifths
//! of the picture's height. The edge is rounded up to a twentieth of a millimetre, so that cameras found a little otherwise give the same
//! grid; it is no finer than [`FINEST_MM`] and leaves no more than [`MOST_VOXELS`].

use super::inputs::{CameraSource, Cameras, Frame};
use super::settings::{Simulate, Source};
use crate::error::Result;
use crate::formats::camera_file;
use crate::optics::{Tank, View};
use crate::photo;
use crate::simulation::capture;
use crate::volume::Grid;
use std::path::{Path, PathBuf};

/// Half the width of the thinnest roots that are common in hydroponics, 0.5 mm.
const FINEST_MM: f64 = 0.25;
/// Voxels whose rootness, traced in memory, stays well under a gigabyte.
const MOST_VOXELS: f64 = 80e6;
/// Steps of a millimetre.
const STEPS: f64 = 20.0;
/// Share of the picture's height that a tank usually fills.
const FILLED: f64 = 0.8;

/// A spacing and why.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Scale {
    /// Edge of a voxel, mm.
    pub spacing_mm: f64,
    /// One sentence for people.
    pub reason: String,
}

/// The spacing for a study of this tank down to `depth_mm`.
///
/// # Errors
/// Where the grid of a tank cannot be made at all.
pub(super) fn of(source: &Source, cameras: &Cameras, input_dir: &Path, tank: &Tank, depth_mm: f64) -> Result<Scale> {
    let known = match (source, cameras.source, cameras.frame) {
        (Source::Simulated(simulate), ..) => simulated(simulate, tank),
        (Source::Files(_), CameraSource::File, Frame::Tank) => in_file(cameras, input_dir),
        _ => None,
    };
    let (footprint_mm, whence) = match (known, source) {
        (Some(footprint_mm), _) => (footprint_mm, "a pixel at the tank's axis"),
        (None, Source::Files(paths)) => match height_px(paths) {
            Some(height) => {
                let footprint_mm = tank.height_mm / (FILLED * height);
                (footprint_mm, "a pixel at the tank's axis, were the tank four fifths of the picture's height")
            }
            None => (1.0, "taken where neither cameras nor photographs can be read"),
        },
        (None, Source::Simulated(_)) => (1.0, "taken where the simulated camera cannot be placed"),
    };
    let wanted_mm = rounded(footprint_mm.max(FINEST_MM));
    let mut spacing_mm = wanted_mm;
    while (Grid::of_tank(tank, spacing_mm, depth_mm)?.len() as f64) > MOST_VOXELS {
        spacing_mm = rounded(spacing_mm + 0.5 / STEPS);
    }
    let bound = match (spacing_mm > wanted_mm, footprint_mm < FINEST_MM) {
        (true, _) => format!("; the tank holds {:.0} million voxels of that", MOST_VOXELS / 1e6),
        (false, true) => "; roots are no finer".to_owned(),
        (false, false) => String::new(),
    };
    Ok(Scale { spacing_mm, reason: format!("grid.spacing = {spacing_mm} mm: {footprint_mm:.2} mm is {whence}{bound}") })
}

/// The next step up.
fn rounded(mm: f64) -> f64 {
    (mm * STEPS - 1e-6).ceil() / STEPS
}

/// Middle footprint of a pixel at the axis.
fn footprint(views: impl Iterator<Item = View>) -> Option<f64> {
    let mut all: Vec<f64> =
        views.map(|view| 1.0 / photo::evidence::px_per_mm(&view)).filter(|f| f.is_finite()).collect();
    all.sort_unstable_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}

fn simulated(simulate: &Simulate, tank: &Tank) -> Option<f64> {
    footprint(capture(&simulate.capture, tank, simulate.seed).ok()?.into_iter())
}

/// From a camera file; one that cannot be read is told of by the node that reads it.
fn in_file(cameras: &Cameras, input_dir: &Path) -> Option<f64> {
    let read = |path: PathBuf| Some((path.display().to_string(), std::fs::read(&path).ok()?));
    let files = cameras.files(input_dir).ok()?.into_iter().map(read).collect::<Option<Vec<_>>>()?;
    let model = camera_file::parse(&files).ok()?;
    footprint(model.views.into_iter().map(|v| View {
        lens: v.lens,
        rotation: v.rotation,
        translation_mm: v.translation,
    }))
}

/// Height of the first photograph, px.
fn height_px(paths: &[PathBuf]) -> Option<f64> {
    let first = paths.first()?;
    let head = photo::head(&std::fs::read(first).ok()?, &first.display().to_string()).ok()?;
    Some(head.size.1 as f64).filter(|h| *h > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn tank(radius_mm: f64, height_mm: f64) -> Tank {
        Tank { radius_mm, height_mm, wall_mm: 4.0, water_level_mm: 12.0, index: Index::default(), belts_mm: Vec::new() }
    }

    fn scale(width: usize, tank: &Tank) -> Scale {
        let mut simulate = Simulate::default();
        (simulate.capture.width, simulate.capture.height) = (width, width * 2 / 3);
        let source = Source::Simulated(Box::new(simulate));
        of(&source, &Cameras::default(), Path::new("."), tank, 0.8 * tank.height_mm).unwrap()
    }

    #[test]
    fn voxels_are_as_wide_as_pixels_within_bounds() {
        let usual = scale(968, &tank(60.0, 180.0));
        assert!((0.3..0.5).contains(&usual.spacing_mm) && usual.reason.contains("axis"), "{usual:?}");
        assert_eq!((usual.spacing_mm * STEPS).round(), usual.spacing_mm * STEPS);
        let coarse = scale(240, &tank(60.0, 180.0));
        assert!(coarse.spacing_mm > 3.0 * usual.spacing_mm, "{coarse:?}");
        let fine = scale(4000, &tank(40.0, 120.0));
        assert!(fine.spacing_mm == FINEST_MM && fine.reason.contains("no finer"), "{fine:?}");
        let vast = scale(968, &tank(300.0, 600.0));
        let grid = Grid::of_tank(&tank(300.0, 600.0), vast.spacing_mm, 480.0).unwrap();
        assert!(grid.len() as f64 <= MOST_VOXELS && (vast.spacing_mm * STEPS).fract().abs() < 1e-9, "{vast:?}");
    }

    #[test]
    fn without_anything_to_go_by_it_is_a_millimetre() {
        let source = Source::Files(vec!["nowhere.jpg".into()]);
        let scale = of(&source, &Cameras::default(), Path::new("."), &tank(60.0, 180.0), 150.0).unwrap();
        assert_eq!(scale.spacing_mm, 1.0);
    }
}
