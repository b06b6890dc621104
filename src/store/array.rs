//! Arrays on disk: Zarr version 3, sharded, zstd, checksums; readable by any Zarr library.
//!
//! A shard holds whole cross-sections: its depth along axis 0 is as large as [`SHARD_BYTES`] allows, so that
//! an array has few files, and one shard is written once. The inner chunks are shallow along axis 0, so that
//! reading a slab decodes little more than the slab. A trailing axis of at most four channels is kept whole.

use std::marker::PhantomData;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ndarray::{ArrayD, ArrayViewD, Axis, IxDyn, Slice};
use zarrs::array::codec::{Crc32cCodec, ShardingCodecBuilder, SubchunkWriteOrder, ZstdCodec};
use zarrs::array::{Array, ArrayBuilder, ArraySubset, DataType, data_type};
use zarrs::filesystem::FilesystemStore;

use super::digest::{ArrayHasher, Digest};
use super::element::{Dtype, Element};
use super::manifest::Member;
use super::virtual_array::VirtualArtefact;
use crate::error::{Error, Result};

/// Bytes that one shard holds at most before compression, unless a single row of inner chunks is larger.
const SHARD_BYTES: usize = 64 << 20;
/// The largest shard that is taken from others, bytes before compression.
const MOST_SHARD_BYTES: usize = 4 << 30;
/// Depth of an inner chunk along axis 0 of a volume.
const CHUNK_DEPTH: usize = 8;
/// Largest side of an inner chunk along the other axes of a volume.
const CHUNK_SIDE: usize = 128;

/// Shapes of inner chunk and shard for an array of `shape` with elements of `element_bytes`.
fn chunking(shape: &[usize], element_bytes: usize) -> (Vec<usize>, Vec<usize>) {
    let channels = usize::from(shape.len() > 1 && shape[shape.len() - 1] <= 4);
    let spatial = shape.len() - channels;
    let (depth, side) = match spatial {
        1 => (1 << 16, 0),
        2 => (256, 256),
        _ => (CHUNK_DEPTH, CHUNK_SIDE),
    };
    let mut inner: Vec<usize> = shape.to_vec();
    inner[0] = shape[0].clamp(1, depth);
    for (axis, cell) in inner.iter_mut().enumerate().skip(1) {
        *cell = if axis < spatial {
            let parts = shape[axis].div_ceil(side).max(1);
            shape[axis].div_ceil(parts).max(1)
        } else {
            shape[axis].max(1)
        };
    }
    let mut shard: Vec<usize> = shape.iter().zip(&inner).map(|(n, c)| n.div_ceil(*c).max(1) * c).collect();
    let layer: usize = shard[1..].iter().product::<usize>() * inner[0] * element_bytes;
    let layers = (SHARD_BYTES / layer.max(1)).clamp(1, shard[0] / inner[0]);
    shard[0] = layers * inner[0];
    (inner, shard)
}

fn zarr_type(dtype: Dtype) -> DataType {
    match dtype {
        Dtype::Uint8 => data_type::uint8(),
        Dtype::Uint16 => data_type::uint16(),
        Dtype::Uint32 => data_type::uint32(),
        Dtype::Uint64 => data_type::uint64(),
        Dtype::Int8 => data_type::int8(),
        Dtype::Int16 => data_type::int16(),
        Dtype::Int32 => data_type::int32(),
        Dtype::Int64 => data_type::int64(),
        Dtype::Float32 => data_type::float32(),
        Dtype::Float64 => data_type::float64(),
    }
}

/// Fails where the array in `folder` is not laid out as this program lays out such a member: a layout of others could ask
/// for any amount of memory.
pub(super) fn check_layout(folder: &Path, member: &Member) -> Result<()> {
    let path = folder.join("zarr.json");
    let text = std::fs::read(&path).map_err(|e| Error::io("read", &path, e))?;
    let found: serde_json::Value = serde_json::from_slice(&text).map_err(|e| Error::io("understand", &path, e))?;
    let element_bytes = member.dtype.map_or(8, Dtype::bytes);
    let is_empty = member.shape.is_empty();
    let (inner, shard) = if is_empty { Default::default() } else { chunking(&member.shape, element_bytes) };
    let chunk = &found["chunk_grid"]["configuration"]["chunk_shape"];
    let codecs = &found["codecs"];
    let cells = shard.iter().try_fold(element_bytes, |n, &side| n.checked_mul(side));
    let ours = *chunk == serde_json::json!(shard)
        && codecs[0]["configuration"]["chunk_shape"] == serde_json::json!(inner)
        && codecs.as_array().is_some_and(|codecs| codecs.len() == 1)
        && cells.is_some_and(|bytes| bytes <= MOST_SHARD_BYTES);
    if is_empty || !ours {
        return Err(Error::failed(format!("array `{}` has a layout of its own", member.name)));
    }
    Ok(())
}

fn wide(shape: &[usize]) -> Vec<u64> {
    shape.iter().map(|&n| n as u64).collect()
}

/// Writes an array slab by slab along axis 0. Slabs must come in order and fill the shape.
pub struct SlabWriter<T: Element> {
    array: Array<FilesystemStore>,
    folder: PathBuf,
    shape: Vec<usize>,
    /// The shard being filled, `shard` cells large, padded with the fill value.
    buffer: ArrayD<T>,
    /// Rows written before the shard being filled.
    start: usize,
    /// Rows in the shard being filled.
    filled: usize,
    hasher: ArrayHasher,
    done: Box<dyn FnOnce(Digest) -> Result<()> + Send>,
}

impl<T: Element> SlabWriter<T> {
    /// Begins an array at `folder`; `done` is called with the digest when it is complete.
    pub(super) fn create(
        folder: &Path,
        shape: &[usize],
        dimensions: &[&str],
        done: Box<dyn FnOnce(Digest) -> Result<()> + Send>,
    ) -> Result<Self> {
        if shape.is_empty() || shape.len() != dimensions.len() {
            return Err(Error::failed(format!(
                "array `{}` has shape {shape:?} but the dimension names {dimensions:?}",
                folder.display()
            )));
        }
        let (inner, shard) = chunking(shape, size_of::<T>());
        let cannot = |cause: &dyn std::fmt::Display| Error::io("create the array", folder, cause);
        let storage = Arc::new(FilesystemStore::new(folder).map_err(|e| cannot(&e))?);
        let data_type = zarr_type(T::DTYPE);
        let inner_shape = inner.iter().filter_map(|&n| std::num::NonZeroU64::new(n as u64)).collect::<Vec<_>>();
        let zstd = ZstdCodec::new(1, false);
        let sharding = ShardingCodecBuilder::new(inner_shape, &data_type)
            .bytes_to_bytes_codecs(vec![Arc::new(zstd), Arc::new(Crc32cCodec::new())])
            .build()
            .with_subchunk_write_order(SubchunkWriteOrder::C);
        let array = ArrayBuilder::new(wide(shape), wide(&shard), data_type, T::FILL)
            .array_to_bytes_codec(Arc::new(sharding))
            .dimension_names(Some(dimensions.iter().copied()))
            .build(storage, "/")
            .map_err(|e| cannot(&e))?;
        array.store_metadata().map_err(|e| cannot(&e))?;
        Ok(Self {
            array,
            folder: folder.to_owned(),
            shape: shape.to_vec(),
            buffer: ArrayD::from_elem(IxDyn(&shard), T::FILL),
            start: 0,
            filled: 0,
            hasher: ArrayHasher::default(),
            done,
        })
    }

    /// Appends `slab`, whose axes but the first have the array's lengths.
    pub fn push(&mut self, slab: ArrayViewD<'_, T>) -> Result<()> {
        let rows = slab.shape().first().copied().unwrap_or(0);
        let next = self.start + self.filled;
        if slab.ndim() != self.shape.len() || slab.shape()[1..] != self.shape[1..] || next + rows > self.shape[0] {
            return Err(Error::failed(format!(
                "a slab of shape {:?} does not fit at row {next} of array `{}` of shape {:?}",
                slab.shape(),
                self.folder.display(),
                self.shape
            )));
        }
        self.hasher.update(slab.view());
        let depth = self.buffer.shape()[0];
        let mut taken = 0;
        while taken < rows {
            let count = (rows - taken).min(depth - self.filled);
            self.copy(slab.slice_axis(Axis(0), Slice::from(taken..taken + count)));
            taken += count;
            self.filled += count;
            if self.filled == depth {
                self.store_shard()?;
            }
        }
        Ok(())
    }

    /// Copies `part` behind the rows already in the shard, run by run of cells that lie together in both.
    fn copy(&mut self, part: ArrayViewD<'_, T>) {
        let part = part.as_standard_layout();
        let shard = self.buffer.shape().to_vec();
        let Some(buffer) = self.buffer.as_slice_mut() else { return };
        let Some(source) = part.as_slice() else { return };
        // Behind the last axis that is padded, rows of array and shard are the same.
        let whole = (1..shard.len()).rev().take_while(|&axis| shard[axis] == self.shape[axis]).count();
        let split = (shard.len() - whole).saturating_sub(1);
        let cells = |shape: &[usize]| shape.iter().product::<usize>();
        let (run, stride) = (cells(&part.shape()[split..]), cells(&shard[split..]));
        let first = if split == 0 { self.filled * cells(&shard[1..]) } else { 0 };
        for (number, run) in source.chunks_exact(run.max(1)).enumerate() {
            let (mut number, mut place, mut step) = (number, first, stride);
            for axis in (0..split).rev() {
                let row = number % part.shape()[axis];
                number /= part.shape()[axis];
                place += (row + if axis == 0 { self.filled } else { 0 }) * step;
                step *= shard[axis];
            }
            for (to, from) in buffer[place..place + run.len()].iter_mut().zip(run) {
                *to = from.canonical();
            }
        }
    }

    fn store_shard(&mut self) -> Result<()> {
        let depth = self.buffer.shape()[0];
        if self.filled < depth {
            self.buffer.slice_axis_mut(Axis(0), Slice::from(self.filled..)).fill(T::FILL);
        }
        let mut index = vec![0; self.shape.len()];
        index[0] = (self.start / depth) as u64;
        self.array.store_chunk(&index, &self.buffer).map_err(|e| Error::io("write the array", &self.folder, e))?;
        self.start += self.filled;
        self.filled = 0;
        Ok(())
    }

    /// Completes the array; an error if rows are missing.
    pub fn finish(mut self) -> Result<()> {
        if self.filled > 0 {
            self.store_shard()?;
        }
        if self.start != self.shape[0] {
            return Err(Error::failed(format!(
                "array `{}` was given {} of its {} rows",
                self.folder.display(),
                self.start,
                self.shape[0]
            )));
        }
        (self.done)(self.hasher.finish())
    }
}

enum Source {
    Stored(Box<Array<FilesystemStore>>, PathBuf),
    Virtual(Arc<VirtualArtefact>, String),
}

/// Reads an array, whole or by slabs along axis 0.
pub struct ArrayReader<T: Element> {
    source: Source,
    shape: Vec<usize>,
    element: PhantomData<T>,
}

impl<T: Element> ArrayReader<T> {
    /// Opens the Zarr array in `folder`, which the manifest says has `shape`.
    pub(super) fn open(folder: &Path, shape: &[usize]) -> Result<Self> {
        let cannot = |cause: &dyn std::fmt::Display| {
            Error::io("open the array", folder, cause).help("the store is damaged: run `rootvox cache verify`")
        };
        let storage = Arc::new(FilesystemStore::new(folder).map_err(|e| cannot(&e))?);
        let array = Array::open(storage, "/").map_err(|e| cannot(&e))?;
        // Chunks that hold nothing but the fill value are not on the disk: another one would be read for them.
        let mut fill = Vec::new();
        T::extend_le(&[T::FILL], &mut fill);
        if array.shape() != wide(shape) || array.fill_value().as_ne_bytes() != fill {
            return Err(cannot(&"its shape or fill value is not what was written"));
        }
        Ok(Self {
            source: Source::Stored(Box::new(array), folder.to_owned()),
            shape: shape.to_vec(),
            element: PhantomData,
        })
    }

    /// Reads from a source that is computed as it is read.
    pub(super) fn streamed(source: Arc<VirtualArtefact>, name: &str, shape: &[usize]) -> Self {
        Self { source: Source::Virtual(source, name.to_owned()), shape: shape.to_vec(), element: PhantomData }
    }

    /// Lengths of the axes.
    pub fn shape(&self) -> &[usize] {
        &self.shape
    }

    /// The whole array, shard by shard: read at once a large one would stand in memory twice.
    pub fn read(&self) -> Result<ArrayD<T>> {
        let (depth, shard) = (self.shape[0], chunking(&self.shape, size_of::<T>()).1[0]);
        if shard >= depth {
            return self.slab(0..depth);
        }
        let mut whole = ArrayD::from_elem(IxDyn(&self.shape), T::FILL);
        for start in (0..depth).step_by(shard) {
            let end = (start + shard).min(depth);
            whole.slice_axis_mut(Axis(0), Slice::from(start..end)).assign(&self.slab(start..end)?);
        }
        Ok(whole)
    }

    /// The rows `rows` along axis 0.
    pub fn slab(&self, rows: Range<usize>) -> Result<ArrayD<T>> {
        if rows.start > rows.end || rows.end > self.shape[0] {
            return Err(Error::failed(format!("rows {rows:?} lie outside of an array of shape {:?}", self.shape)));
        }
        match &self.source {
            Source::Stored(array, folder) => {
                let ranges: Vec<Range<u64>> = std::iter::once(rows.start as u64..rows.end as u64)
                    .chain(self.shape[1..].iter().map(|&n| 0..n as u64))
                    .collect();
                array.retrieve_array_subset(&ArraySubset::new_with_ranges(&ranges)).map_err(|e| {
                    Error::io("read the array", folder, e).help("the store is damaged: run `rootvox cache verify`")
                })
            }
            Source::Virtual(source, name) => source.slab(name, rows),
        }
    }
}
