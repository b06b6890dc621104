//! Storing what a stage streams, so that its stored and its streamed values cannot differ.

use super::stage::{Inputs, Progress, Streamed};
use crate::error::Result;
use crate::store::{ArraySpec, Dtype, Element, Output, SlabSource};

/// The `run` of a [`Streamed`] stage: writes all its arrays, slab by slab.
///
/// # Errors
/// As the source and the store.
pub fn store_streamed<S: Streamed>(stage: &S, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
    let source = stage.open(inputs)?;
    let source = source.as_ref();
    let arrays = source.arrays();
    progress.total(arrays.iter().map(|spec| spec.shape[0] as u64).sum());
    for spec in &arrays {
        match spec.dtype {
            Dtype::Uint8 => copy::<u8>(source, spec, output, progress),
            Dtype::Uint16 => copy::<u16>(source, spec, output, progress),
            Dtype::Uint32 => copy::<u32>(source, spec, output, progress),
            Dtype::Uint64 => copy::<u64>(source, spec, output, progress),
            Dtype::Int8 => copy::<i8>(source, spec, output, progress),
            Dtype::Int16 => copy::<i16>(source, spec, output, progress),
            Dtype::Int32 => copy::<i32>(source, spec, output, progress),
            Dtype::Int64 => copy::<i64>(source, spec, output, progress),
            Dtype::Float32 => copy::<f32>(source, spec, output, progress),
            Dtype::Float64 => copy::<f64>(source, spec, output, progress),
        }?;
    }
    Ok(())
}

fn copy<T: Element>(source: &dyn SlabSource, spec: &ArraySpec, output: &mut Output, progress: &Progress) -> Result<()> {
    let dimensions: Vec<&str> = spec.dimensions.iter().map(String::as_str).collect();
    let mut writer = output.slabs::<T>(&spec.name, &spec.shape, &dimensions)?;
    let (rows, step) = (spec.shape[0], spec.slab_rows());
    for start in (0..rows).step_by(step) {
        progress.check()?;
        let end = rows.min(start + step);
        writer.push(source.slab(&spec.name, start..end)?.into_array::<T>(&spec.name)?.view())?;
        progress.advance((end - start) as u64);
    }
    writer.finish()
}
