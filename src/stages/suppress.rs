//! Thins rootness to ridges, across the tangent.  Paper 2.5.
//! In: rootness. Out, one row per ridge voxel in the order of the volume: index (u32, flat), rootness
//! (f32), tangent (n, [x y z] f32, unit), offset (n, [x y z] f32, voxels, from the voxel's centre to the
//! crest), scale (u8).

use super::{flat, four, slabs, three};
use crate::error::{Error, Result};
use crate::flow::{Inputs, Output, Progress, Stage};
use crate::store::Artefact;
use crate::volume::ridges::Ridges;
use crate::volume::rootness::RootVolume;
use crate::volume::suppress::{self, HALO, suppress};
use ndarray::{Array1, Array2, ArrayD};
use serde::Serialize;

/// Suppression with its parameters.
#[derive(Debug, Clone, Serialize)]
pub struct Suppress {
    /// How the tangent is taken.
    #[serde(flatten)]
    pub params: suppress::Suppress,
}

impl Stage for Suppress {
    const NAME: &'static str = "suppress";
    const VERSION: u32 = 1;

    fn peak_bytes(&self) -> u64 {
        // A slab, and ridges of some hundredths of the voxels.
        1 << 30
    }

    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
        let volume = inputs.one("rootness")?;
        let (values, tangent) = (volume.array::<f32>("rootness")?, volume.array::<i8>("tangent")?);
        let scale = volume.array::<u8>("scale")?;
        let shape: [usize; 3] = [values.shape()[0], values.shape()[1], values.shape()[2]];
        let mut ridges = Ridges { shape, ..Ridges::default() };
        progress.total(shape[0] as u64);
        for (own, with_halo) in slabs(shape[0], HALO, shape[1] * shape[2] * 8) {
            progress.check()?;
            let slab = RootVolume {
                rootness: three(values.slab(with_halo.clone())?)?,
                tangent: four(tangent.slab(with_halo.clone())?)?,
                scale: three(scale.slab(with_halo.clone())?)?,
            };
            let inner = own.start - with_halo.start..own.end - with_halo.start;
            ridges.append(suppress(&slab, inner, with_halo.start, shape[0], &self.params)?);
            progress.advance(own.len() as u64);
        }
        write(&ridges, output)
    }
}

/// Writes ridges as columns, `shape` as JSON beside them.
pub(crate) fn write(ridges: &Ridges, output: &mut Output) -> Result<()> {
    output.json("shape", &ridges.shape)?;
    output.array("index", Array1::from(ridges.index.clone()).view().into_dyn(), &["n"])?;
    output.array("rootness", Array1::from(ridges.rootness.clone()).view().into_dyn(), &["n"])?;
    output.array("tangent", Array2::from(ridges.tangent.clone()).view().into_dyn(), &["n", "c"])?;
    output.array("offset", Array2::from(ridges.offset.clone()).view().into_dyn(), &["n", "c"])?;
    output.array("scale", Array1::from(ridges.scale.clone()).view().into_dyn(), &["n"])
}

/// Reads what [`Suppress`] wrote.
pub(crate) fn read(artefact: &Artefact) -> Result<Ridges> {
    Ok(Ridges {
        shape: artefact.json("shape")?,
        index: flat(artefact.array::<u32>("index")?.read()?),
        rootness: flat(artefact.array::<f32>("rootness")?.read()?),
        tangent: triples(artefact.array::<f32>("tangent")?.read()?)?,
        offset: triples(artefact.array::<f32>("offset")?.read()?)?,
        scale: flat(artefact.array::<u8>("scale")?.read()?),
    })
}

/// Rows of three.
pub(crate) fn triples(array: ArrayD<f32>) -> Result<Vec<[f32; 3]>> {
    let flat = flat(array);
    let (rows, rest) = flat.as_chunks::<3>();
    if rest.is_empty() { Ok(rows.to_vec()) } else { Err(Error::failed("an array of the store has no rows of three")) }
}
