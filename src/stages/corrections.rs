//! Applies a person's corrections to the traced roots.
//! In: system, file (`corrections.toml`), cameras in the order of `photos`, rootness. Out: system.json, outcomes.json and corrections.csv (what
//! became of each).

use super::read3;
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::formats::{corrections_toml, tables};
use crate::optics::{Tank, View, trace};
use crate::roots::correction::evidence::Evidence;
use crate::roots::correction::{Change, CorrectionParams, Sighting, World, correct};
use crate::roots::{Field, RootSystem};
use crate::volume::Grid;
use serde::Serialize;

/// The corrections with what they are judged by.
#[derive(Debug, Clone, Serialize)]
pub struct Corrections {
    /// The tank between roots and cameras.
    pub tank: Tank,
    /// The grid of the rootness.
    pub grid: Grid,
    /// Names of the photographs, as their cameras stand.
    pub photos: Vec<String>,
    /// How places are found.
    #[serde(flatten)]
    pub params: CorrectionParams,
}

impl Stage for Corrections {
    const NAME: &'static str = "corrections";
    const VERSION: u32 = 3;

    fn peak_bytes(&self) -> u64 {
        self.grid.len() as u64 * 4
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, _: &Progress) -> Result<()> {
        let file = inputs.one("file")?;
        let name = file.path("file")?.display().to_string();
        let text = String::from_utf8(file.bytes("file")?).map_err(|_| {
            Error::usage(format!("`{name}` is no text")).help("corrections.file names a TOML file of corrections")
        })?;
        let list = corrections_toml::read(&name, &text)?;
        let system: RootSystem = inputs.one("system")?.json("system.json")?;
        let views = inputs.many("cameras");
        let ray = |seen: &Sighting| {
            let n = self.photos.iter().position(|p| *p == seen.photo).ok_or_else(|| {
                Error::usage(format!("corrections: there is no photograph `{}`", seen.photo))
                    .help(format!("the photographs are {}", self.photos.join(", ")))
            })?;
            let view = views[n].json::<View>("view")?.ideal();
            Ok(trace(&self.tank, &view.centre_in_tank(), &view.ray_in_tank(seen.px[0], seen.px[1])))
        };
        // The volume is read only where it is asked.
        let adds = list.iter().any(|c| matches!(c.change, Change::Add { .. })) && self.params.snap_mm > 0.0;
        let rootness = adds.then(|| read3::<f32>(inputs.one("rootness")?, "rootness")).transpose()?;
        let field = rootness.as_ref().map(|r| Field { grid: self.grid, rootness: r.view() });
        let evidence = field.map(|field| Evidence::new(field, &system.roots));
        let (system, outcomes) = correct(system, &list, &World { ray: &ray, evidence, params: self.params })?;
        for (n, outcome) in outcomes.iter().enumerate().filter(|(_, o)| !o.applied) {
            output.warn(format!("correction {} was not applied: {}", n + 1, outcome.told()));
        }
        output.bytes("corrections.csv", &tables::corrections(&outcomes)?)?;
        output.json("system.json", &system)?;
        output.json("outcomes.json", &outcomes)
    }
}
