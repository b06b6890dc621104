//! Follows the ridges into pieces of roots and notes how these may hang together.
//! In: ridges, rootness; explained, where only what photographs need is followed. Out: pieces.json (centrelines with scale-space
//! radii, ties, repairs).

use super::{read3, suppress};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::optics::Vec3;
use crate::roots::explain::Explained;
use crate::roots::{Field, RidgePoint, TraceParams, trace};
use crate::volume::{Grid, Ridges};
use serde::Serialize;

/// The tracing with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Trace {
    /// The grid that the ridges lie on.
    pub grid: Grid,
    /// How it decides.
    #[serde(flatten)]
    pub params: TraceParams,
}

impl Stage for Trace {
    const NAME: &'static str = "trace";
    const VERSION: u32 = 12;

    fn peak_bytes(&self) -> u64 {
        // The dense rootness, and ridges of some hundredths of its voxels.
        self.grid.len() as u64 * 8
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let ridges = suppress::read(inputs.one("ridges")?)?;
        let strong = self.params.hysteresis().pieces(&ridges, self.grid.spacing_mm).label;
        let sigma_mm: Vec<f64> = inputs.one("rootness")?.json("sigma_mm")?;
        let rootness = read3::<f32>(inputs.one("rootness")?, "rootness")?;
        let floor = self.params.extend.share * f64::from(self.params.hysteresis().thresholds(&ridges).0);
        let mut points = points(&ridges, &strong, floor, &self.grid, &sigma_mm)?;
        let explained = inputs.many("explained");
        if let [explained, ..] = explained {
            points = explained.json::<Explained>("explained.json")?.needed(points, self.grid.spacing_mm);
        }
        progress.check()?;
        let mut pieces = trace(&points, &Field { grid: self.grid, rootness: rootness.view() }, &self.params)?;
        pieces.explained = !explained.is_empty();
        progress.check()?;
        if pieces.pieces.is_empty() {
            output.warn("no root was traced; lower trace.high, or look at the rootness volume");
        }
        output.json("pieces.json", &pieces)
    }
}

/// The ridge voxels as points: those with a number in `strong`, and of the others those of a rootness of `floor` at least.
fn points(ridges: &Ridges, strong: &[u32], floor: f64, grid: &Grid, sigma_mm: &[f64]) -> Result<Vec<RidgePoint>> {
    (0..ridges.len())
        .filter(|&n| strong[n] > 0 || f64::from(ridges.rootness[n]) >= floor)
        .map(|n| {
            let scale = usize::from(ridges.scale[n]);
            let sigma_mm = *sigma_mm.get(scale).ok_or_else(|| {
                Error::failed(format!("ridges name scale {scale}, but the rootness has {} scales", sigma_mm.len()))
            })?;
            Ok(RidgePoint {
                position_mm: ridges.point_mm(n, grid),
                tangent: Vec3::from(ridges.tangent[n].map(f64::from)).try_normalize(1e-9).unwrap_or_else(Vec3::z),
                rootness: f64::from(ridges.rootness[n]),
                sigma_mm,
                strong: strong[n] > 0,
            })
        })
        .collect()
}
