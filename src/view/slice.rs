//! A slice of the merged volume or of the rootness, by any plane.

use super::session::Session;
use crate::error::{Error, Result};
use crate::formats::picture;
use crate::store::Artefact;
use crate::volume::Grid;
use crate::volume::plane::Plane;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ndarray::{Array3, ArrayD, Axis};
use serde::Deserialize;
use serde_json::{Value, json};
use std::ops::Range;
use std::sync::Arc;

/// Colour of what is unknown.
const UNKNOWN: [u8; 3] = [0, 0, 60];
/// Bytes of a volume read at once.
const SLAB_BYTES: usize = 64 << 20;

/// Which volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Volume {
    /// Colours, or the share of root.
    Merged,
    /// How much a voxel looks like part of a root.
    Rootness,
}

/// Which slice.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    of: Volume,
    /// Direction that the plane's normal leans to, degrees from x to y.
    turn: f64,
    /// How far it leans from straight down, degrees: 0 is a horizontal plane.
    tilt: f64,
    /// Distance from the grid's middle along it, mm.
    at: f64,
}

/// The slice as JSON: a PNG of a pixel per voxel, and where it lies.
///
/// # Errors
/// Numbers that are none, faults of the study and of the store.
pub fn slice(session: &Session, asked: &Asked) -> Result<Value> {
    if ![asked.turn, asked.tilt, asked.at].iter().all(|x| x.is_finite()) {
        return Err(Error::usage("turn, tilt and at of a slice are numbers"));
    }
    let (study, machine) = session.shown()?;
    let (settings, nodes) = study.planned()?;
    let (node, name) = match asked.of {
        Volume::Merged => (nodes.merged, "merged"),
        Volume::Rootness => (nodes.rootness, "rootness"),
    };
    let report = machine.run(study.graph(), &[node], &Arc::default(), |_| {})?;
    let grid = settings.grid;
    let plane = Plane::through(&grid, asked.turn.to_radians(), asked.tilt.to_radians(), asked.at);
    let values = values(&report.artefact(node)?, name, &plane, &grid)?;
    Ok(json!({
        "png": STANDARD.encode(picture::png(painted(&values).view())?),
        "centre": plane.centre_mm.as_slice(), "across": plane.across.as_slice(), "down": plane.down.as_slice(),
        "normal": plane.normal.as_slice(), "px": plane.px_mm, "size": plane.size_px, "reach": plane.reach_mm,
    }))
}

/// The volume's values (row, column, channel) in the plane; NaN is unknown. Only the slabs that it meets are read.
fn values(artefact: &Artefact, name: &str, plane: &Plane, grid: &Grid) -> Result<Array3<f32>> {
    let volume = artefact.array::<f32>(name)?;
    let channels = volume.shape().get(3).copied().unwrap_or(1);
    let [rows, columns] = plane.size_px;
    let mut values = Array3::from_elem((rows, columns, channels), f32::NAN);
    let mut pixels: Vec<([usize; 3], [usize; 2])> = (0..rows)
        .flat_map(|row| (0..columns).map(move |column| [row, column]))
        .filter_map(|pixel| Some((plane.voxel(grid, pixel[0], pixel[1])?, pixel)))
        .collect();
    pixels.sort_unstable();
    let at_once = (SLAB_BYTES / (grid.shape[1] * grid.shape[2] * channels * size_of::<f32>())).max(1);
    let mut slab: (Range<usize>, ArrayD<f32>) = (0..0, ArrayD::zeros(vec![0]));
    let deepest = pixels.last().map_or(0, |(voxel, _)| voxel[0] + 1);
    for ([k, j, i], [row, column]) in pixels {
        if !slab.0.contains(&k) {
            let range = k..(k + at_once).min(deepest);
            slab = (range.clone(), volume.slab(range)?);
        }
        for channel in 0..channels {
            let at = [k - slab.0.start, j, i, channel];
            values[[row, column, channel]] = slab.1[&at[..slab.1.ndim()]];
        }
    }
    Ok(values)
}

/// Gray from 0 to the slice's greatest, by the square root, for thin roots are weak beside thick ones; or colours from 0 to 1.
fn painted(values: &Array3<f32>) -> Array3<u8> {
    let (rows, columns, channels) = values.dim();
    let greatest = match channels {
        1 => values.iter().copied().filter(|v| !v.is_nan()).fold(f32::MIN_POSITIVE, f32::max),
        _ => 1.0,
    };
    let mut picture = Array3::zeros((rows, columns, 3));
    for (pixel, mut rgb) in values.lanes(Axis(2)).into_iter().zip(picture.lanes_mut(Axis(2))) {
        for c in 0..3 {
            let value = pixel[c % channels];
            let share = (value / greatest).clamp(0.0, 1.0);
            let shown = if channels == 1 { share.sqrt() } else { share };
            rgb[c] = if value.is_nan() { UNKNOWN[c] } else { (shown * 255.0).round() as u8 };
        }
    }
    picture
}
