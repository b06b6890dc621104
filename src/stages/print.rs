//! Unrolls the tank's printed belts from the photographs.
//! In: photos (undistorted) and cameras, alike in order. Out: per belt `belt-N` (row, column; gray 0 to 255, NaN where unseen), prints
//! (JSON: depth of the first row, radius, cell).

use super::photographs;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::growth::print::{self, unroll};
use crate::optics::{Tank, View};
use crate::photo::gray::gray;
use crate::store::Artefact;
use ndarray::Ix2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// The belts of one day.
#[derive(Debug, Clone, Serialize)]
pub struct Print {
    /// Radius of the printed surface, mm.
    pub radius_mm: f64,
    /// Depths of the belts, mm, from and to.
    pub belts_mm: Vec<[f64; 2]>,
}

/// An unrolled belt but for its gray values.
#[derive(Serialize, Deserialize)]
struct Measures {
    top_mm: f64,
    radius_mm: f64,
    cell_mm: f64,
}

impl Print {
    /// The print of the belts of `tank`, of paper so thick.
    pub fn of(tank: &Tank, thickness_mm: f64) -> Self {
        Self { radius_mm: tank.radius_mm + thickness_mm, belts_mm: tank.belts_mm.clone() }
    }
}

impl Stage for Print {
    const NAME: &'static str = "print";
    const VERSION: u32 = 1;

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let pairs: Vec<(&Artefact, &Artefact)> = inputs.many("photos").iter().zip(inputs.many("cameras")).collect();
        let photographs = pairs
            .into_par_iter()
            .map(|(photo, camera)| Ok((camera.json::<View>("view")?.ideal(), gray(&photographs::picture(photo)?))))
            .collect::<Result<Vec<_>>>()?;
        let mut measures = Vec::new();
        for (n, belt) in self.belts_mm.iter().enumerate() {
            let print = unroll(&photographs, self.radius_mm, *belt);
            measures.push(Measures { top_mm: print.top_mm, radius_mm: print.radius_mm, cell_mm: print.cell_mm });
            output.array(&format!("belt-{n}"), print.gray.view().into_dyn(), &["z", "azimuth"])?;
        }
        output.json("prints", &measures)
    }
}

/// The belts of a day.
pub(super) fn read(artefact: &Artefact) -> Result<Vec<print::Print>> {
    let measures: Vec<Measures> = artefact.json("prints")?;
    let one = |(n, m): (usize, Measures)| {
        let gray = artefact.array::<f32>(&format!("belt-{n}"))?.read()?.into_dimensionality::<Ix2>();
        let gray = gray.map_err(|e| Error::failed(format!("belt {n} has other axes: {e}")))?;
        Ok(print::Print { top_mm: m.top_mm, radius_mm: m.radius_mm, cell_mm: m.cell_mm, gray })
    };
    measures.into_iter().enumerate().map(one).collect()
}
