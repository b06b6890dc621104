//! Arrays that are computed while they are read, and whose digests are learned on the way.

use std::any::Any;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use ndarray::{ArrayD, Axis, Slice};

use super::digest::ArrayHasher;
use super::element::{Dtype, Element};
use super::manifest::{Member, MemberKind};
use crate::error::{Error, Result};

/// Name, type and shape of an array that a source offers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ArraySpec {
    /// Member name.
    pub name: String,
    /// Data type.
    pub dtype: Dtype,
    /// Lengths of the axes.
    pub shape: Vec<usize>,
    /// Names of the axes.
    pub dimensions: Vec<String>,
}

impl ArraySpec {
    /// An array of elements `T`.
    pub fn new<T: Element>(name: &str, shape: &[usize], dimensions: &[&str]) -> Self {
        Self {
            name: name.to_owned(),
            dtype: T::DTYPE,
            shape: shape.to_vec(),
            dimensions: dimensions.iter().map(|&d| d.to_owned()).collect(),
        }
    }

    /// Rows along axis 0 that make up about 16 MiB.
    pub fn slab_rows(&self) -> usize {
        let row: usize = self.shape[1..].iter().product::<usize>().max(1) * 8;
        ((16 << 20) / row).clamp(1, self.shape[0].max(1))
    }
}

trait Values: Send {
    fn hash_from(&self, row: usize, hasher: &mut ArrayHasher);
    fn shape(&self) -> &[usize];
    fn into_any(self: Box<Self>) -> Box<dyn Any>;
}

impl<T: Element> Values for ArrayD<T> {
    fn hash_from(&self, row: usize, hasher: &mut ArrayHasher) {
        hasher.update(self.slice_axis(Axis(0), Slice::from(row..)));
    }

    fn shape(&self) -> &[usize] {
        self.shape()
    }

    fn into_any(self: Box<Self>) -> Box<dyn Any> {
        self
    }
}

/// Some rows of an array of any element type.
pub struct Slab(Box<dyn Values>);

impl<T: Element> From<ArrayD<T>> for Slab {
    fn from(mut values: ArrayD<T>) -> Self {
        values.mapv_inplace(T::canonical);
        Self(Box::new(values))
    }
}

impl Slab {
    /// The rows as the elements that they are of.
    ///
    /// # Errors
    /// Where they are of another type.
    pub fn into_array<T: Element>(self, name: &str) -> Result<ArrayD<T>> {
        self.0.into_any().downcast::<ArrayD<T>>().map(|values| *values).map_err(|_| {
            Error::failed(format!("the source of array `{name}` does not give elements of type {}", T::DTYPE.as_str()))
        })
    }
}

/// Computes the rows of its arrays on demand.
pub trait SlabSource: Send + Sync {
    /// The arrays on offer.
    fn arrays(&self) -> Vec<ArraySpec>;
    /// The rows `rows` along axis 0 of `array`; any range may be asked for, mostly in increasing order.
    fn slab(&self, array: &str, rows: Range<usize>) -> Result<Slab>;
}

struct Stream {
    spec: ArraySpec,
    hasher: ArrayHasher,
    /// Rows hashed so far.
    next: usize,
}

/// The artefact of a virtual node while a consumer reads it.
pub struct VirtualArtefact {
    source: Box<dyn SlabSource>,
    streams: BTreeMap<String, Mutex<Stream>>,
}

impl VirtualArtefact {
    /// Wraps `source`.
    pub fn new(source: Box<dyn SlabSource>) -> Self {
        let streams = source
            .arrays()
            .into_iter()
            .map(|spec| (spec.name.clone(), Mutex::new(Stream { spec, hasher: ArrayHasher::default(), next: 0 })))
            .collect();
        Self { source, streams }
    }

    /// The arrays on offer.
    pub fn arrays(&self) -> Vec<ArraySpec> {
        self.source.arrays()
    }

    /// Rows of one array; rows not seen before enter its digest, skipped ones are computed for it.
    pub fn slab<T: Element>(&self, name: &str, rows: Range<usize>) -> Result<ArrayD<T>> {
        let slab = self.source.slab(name, rows.clone())?;
        let stream =
            self.streams.get(name).ok_or_else(|| Error::failed(format!("no array `{name}` in this source")))?;
        let mut stream = stream.lock().unwrap_or_else(PoisonError::into_inner);
        if slab.0.shape().first() != Some(&rows.len()) || slab.0.shape()[1..] != stream.spec.shape[1..] {
            return Err(Error::failed(format!(
                "the source of array `{name}` gave shape {:?} for rows {rows:?} of shape {:?}",
                slab.0.shape(),
                stream.spec.shape
            )));
        }
        self.drain(&mut stream, rows.start)?;
        if rows.end > stream.next {
            let from = stream.next - rows.start;
            slab.0.hash_from(from, &mut stream.hasher);
            stream.next = rows.end;
        }
        drop(stream);
        slab.into_array(name)
    }

    /// Computes and hashes the rows up to `end` that nobody asked for.
    fn drain(&self, stream: &mut Stream, end: usize) -> Result<()> {
        let step = stream.spec.slab_rows();
        while stream.next < end {
            let rows = stream.next..end.min(stream.next + step);
            let slab = self.source.slab(&stream.spec.name, rows.clone())?;
            slab.0.hash_from(0, &mut stream.hasher);
            stream.next = rows.end;
        }
        Ok(())
    }

    /// The members with their digests, after computing whatever no consumer has read.
    pub fn members(&self) -> Result<Vec<Member>> {
        let mut members = Vec::new();
        for (name, stream) in &self.streams {
            let mut stream = stream.lock().unwrap_or_else(PoisonError::into_inner);
            let end = stream.spec.shape[0];
            self.drain(&mut stream, end)?;
            members.push(Member {
                name: name.clone(),
                kind: MemberKind::Array,
                dtype: Some(stream.spec.dtype),
                shape: stream.spec.shape.clone(),
                digest: std::mem::take(&mut stream.hasher).finish(),
                bytes: 0,
            });
        }
        Ok(members)
    }
}
