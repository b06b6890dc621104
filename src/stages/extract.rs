//! Picks the ridges that are roots: double thresholds, 26-connected.  Paper 2.5.
//! In: ridges. Out, one row per root voxel: index (u32, flat), point (n, [x y z] f32, mm, tank frame, on
//! the crest), rootness (f32), component (u32, from 0); root_voxels.csv.

use super::flat;
use super::suppress::{self, triples};
use crate::error::Result;
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::tables::{self, RootVoxel};
use crate::store::Artefact;
use crate::volume::Grid;
use crate::volume::hysteresis::Hysteresis;
use ndarray::{Array1, Array2};
use serde::Serialize;

/// Hysteresis with its thresholds.
#[derive(Debug, Clone, Serialize)]
pub struct Extract {
    /// The grid that the ridges lie on.
    pub grid: Grid,
    /// The thresholds.
    #[serde(flatten)]
    pub params: Hysteresis,
}

/// A voxel that belongs to a root.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RootPoint {
    /// Flat index of the voxel.
    pub index: u32,
    /// On the crest, tank frame, mm.
    pub point_mm: [f32; 3],
    /// Sato's measure.
    pub rootness: f32,
    /// Number of its connected piece, from 0.
    pub component: u32,
}

impl Stage for Extract {
    const NAME: &'static str = "extract";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let ridges = suppress::read(inputs.one("ridges")?)?;
        self.params.check("extract")?;
        progress.check()?;
        let pieces = self.params.pieces(&ridges, self.grid.spacing_mm);
        progress.check()?;
        let points: Vec<RootPoint> = (0..ridges.len())
            .filter(|&n| pieces.label[n] > 0)
            .map(|n| RootPoint {
                index: ridges.index[n],
                point_mm: ridges.point_mm(n, &self.grid).map(|x| x as f32).into(),
                rootness: ridges.rootness[n],
                component: pieces.label[n] - 1,
            })
            .collect();
        if points.is_empty() {
            output.warn("no voxel is a root at these thresholds; lower extract.high, or look at the rootness volume");
        }
        let column = |of: fn(&RootPoint) -> u32| points.iter().map(of).collect::<Array1<u32>>();
        output.array("index", column(|p| p.index).view().into_dyn(), &["n"])?;
        output.array("component", column(|p| p.component).view().into_dyn(), &["n"])?;
        let place: Vec<[f32; 3]> = points.iter().map(|p| p.point_mm).collect();
        output.array("point", Array2::from(place).view().into_dyn(), &["n", "c"])?;
        let rootness: Array1<f32> = points.iter().map(|p| p.rootness).collect();
        output.array("rootness", rootness.view().into_dyn(), &["n"])?;
        let rows: Vec<RootVoxel> = points
            .iter()
            .map(|p| RootVoxel { x_mm: p.point_mm[0], y_mm: p.point_mm[1], z_mm: p.point_mm[2], rootness: p.rootness })
            .collect();
        output.bytes("root_voxels.csv", &tables::root_voxels(&rows)?)
    }
}

/// Reads what [`Extract`] wrote.
pub(crate) fn read(artefact: &Artefact) -> Result<Vec<RootPoint>> {
    let index = flat(artefact.array::<u32>("index")?.read()?);
    let component = flat(artefact.array::<u32>("component")?.read()?);
    let rootness = flat(artefact.array::<f32>("rootness")?.read()?);
    let points = triples(artefact.array::<f32>("point")?.read()?)?;
    Ok(index
        .into_iter()
        .zip(component)
        .zip(rootness)
        .zip(points)
        .map(|(((index, component), rootness), point_mm)| RootPoint { index, point_mm, rootness, component })
        .collect())
}
