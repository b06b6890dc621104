//! What a stage is, what it is given, and how it tells how far it is.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::store::{Artefact, Output, SlabSource, canonical_bytes};

/// A step of the computation. The fields of the type are its parameters: they enter the key, all of them, and
/// nothing else but the inputs may influence the output.
pub trait Stage: Serialize + Send + Sync + 'static {
    /// Its name, as in folders of the store: small letters, digits and `-`.
    const NAME: &'static str;
    /// Raised whenever the same inputs and parameters give other numbers than before.
    const VERSION: u32;

    /// Computes `output` from `inputs`. The result must not depend on the number of threads.
    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()>;

    /// Bytes that a run may hold at its peak; bounds how many nodes run at once.
    fn peak_bytes(&self) -> u64 {
        256 << 20
    }
}

/// A stage that can also produce any rows of its arrays on demand, so that they need not be stored.
pub trait Streamed: Stage {
    /// Opens the arrays that [`Stage::run`] would store: same names, same values.
    fn open(&self, inputs: &Inputs) -> Result<Box<dyn SlabSource>>;
}

/// The upstream artefacts of a node, by port.
#[derive(Clone, Default)]
pub struct Inputs(BTreeMap<String, Vec<Artefact>>);

impl Inputs {
    /// Inputs from ports and their artefacts in order.
    pub fn new<const N: usize>(ports: [(&str, Vec<Artefact>); N]) -> Self {
        Self(ports.into_iter().map(|(port, artefacts)| (port.to_owned(), artefacts)).collect())
    }

    pub(super) fn insert(&mut self, port: &str, artefacts: Vec<Artefact>) {
        self.0.insert(port.to_owned(), artefacts);
    }

    /// The one artefact at `port`.
    pub fn one(&self, port: &str) -> Result<&Artefact> {
        match self.many(port) {
            [artefact] => Ok(artefact),
            several => Err(Error::failed(format!("port `{port}` has {} inputs where it needs one", several.len()))),
        }
    }

    /// All artefacts at `port` in order; empty if the port is absent.
    pub fn many(&self, port: &str) -> &[Artefact] {
        self.0.get(port).map_or(&[], Vec::as_slice)
    }
}

/// How far a run is, and whether it should stop.
#[derive(Clone, Default)]
pub struct Progress(Arc<Counters>);

#[derive(Default)]
struct Counters {
    done: AtomicU64,
    total: AtomicU64,
    cancel: Arc<AtomicBool>,
}

impl Progress {
    pub(super) fn new(cancel: Arc<AtomicBool>) -> Self {
        Self(Arc::new(Counters { cancel, ..Counters::default() }))
    }

    /// Announces how many steps there are.
    pub fn total(&self, steps: u64) {
        self.0.total.store(steps, Ordering::Relaxed);
    }

    /// Reports that `steps` more are done. Cheap; may be called from any thread.
    pub fn advance(&self, steps: u64) {
        self.0.done.fetch_add(steps, Ordering::Relaxed);
    }

    /// An error once the user asked to stop. To be called often in long loops.
    pub fn check(&self) -> Result<()> {
        if self.0.cancel.load(Ordering::Relaxed) { Err(Error::interrupted()) } else { Ok(()) }
    }

    /// Steps done and steps in all.
    pub fn state(&self) -> (u64, u64) {
        (self.0.done.load(Ordering::Relaxed), self.0.total.load(Ordering::Relaxed))
    }
}

/// A stage without its type.
pub(super) trait Work: Send + Sync {
    fn name(&self) -> &'static str;
    fn version(&self) -> u32;
    /// The parameters for people.
    fn params(&self) -> Result<serde_json::Value>;
    /// The parameters for the key.
    fn params_bytes(&self) -> Result<Vec<u8>>;
    fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()>;
    fn peak_bytes(&self) -> u64;
    /// `None` if the stage cannot stream.
    fn open(&self, inputs: &Inputs) -> Option<Result<Box<dyn SlabSource>>>;
}

/// A stage whose results are stored.
pub(super) struct Stored<S>(pub(super) S);
/// A stage whose results are streamed into their consumers.
pub(super) struct Virtual<S>(pub(super) S);

macro_rules! work {
    () => {
        fn name(&self) -> &'static str {
            S::NAME
        }
        fn version(&self) -> u32 {
            S::VERSION
        }
        fn params(&self) -> Result<serde_json::Value> {
            serde_json::to_value(&self.0)
                .map_err(|e| Error::failed(format!("cannot write the parameters of stage `{}`: {e}", S::NAME)))
        }
        fn params_bytes(&self) -> Result<Vec<u8>> {
            canonical_bytes(&self.0).map_err(|e| e.at(S::NAME))
        }
        fn run(&self, inputs: &Inputs, output: &mut Output, progress: &Progress) -> Result<()> {
            self.0.run(inputs, output, progress)
        }
        fn peak_bytes(&self) -> u64 {
            self.0.peak_bytes()
        }
    };
}

impl<S: Stage> Work for Stored<S> {
    work!();
    fn open(&self, _: &Inputs) -> Option<Result<Box<dyn SlabSource>>> {
        None
    }
}

impl<S: Streamed> Work for Virtual<S> {
    work!();
    fn open(&self, inputs: &Inputs) -> Option<Result<Box<dyn SlabSource>>> {
        Some(self.0.open(inputs))
    }
}
