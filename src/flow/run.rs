//! Running one node: inputs, stage, publication.

use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use super::change::{Change, Now, nearest};
use super::graph::{Graph, Kind};
use super::key::key;
use super::resident::Resident;
use super::stage::{Inputs, Progress, Work};
use crate::error::{Error, Result};
use crate::store::{Artefact, Digest, FORMAT, InputRecord, Key, Manifest, Params, Store, VirtualArtefact, digest_of};

/// A node about to run, with everything it needs copied out of the schedule.
pub(super) struct Job {
    pub(super) node: usize,
    /// Unknown while a virtual input's digest is.
    pub(super) key: Option<Key>,
    /// What is known of every node upstream: those reached through virtual nodes too.
    pub(super) upstream: BTreeMap<usize, (Option<Artefact>, Option<Digest>)>,
    /// Its values are to be fetched, not computed.
    pub(super) is_far: bool,
    pub(super) threads: usize,
    pub(super) progress: Progress,
}

/// What came of a job.
pub(super) enum Outcome {
    /// Another process, or another node with the same key, had made it.
    Found(Manifest),
    /// It could not be fetched.
    Lost,
    /// It ran; with the manifests of virtual nodes whose digests were learned.
    Ran { manifest: Manifest, same_output: bool, in_vain: bool, learned: Vec<(usize, Manifest)> },
}

/// Runs `job`; `started` is called when the stage begins.
pub(super) fn run(graph: &Graph, store: &Store, job: &Job, started: &dyn Fn(Vec<Change>)) -> Result<Outcome> {
    let Kind::Stage { work, .. } = &graph.nodes[job.node].kind else {
        return Err(Error::failed("a file cannot be run"));
    };
    if let Some(key) = job.key
        && let Some(manifest) = store.lookup_values(work.name(), key)?
    {
        return Ok(Outcome::Found(manifest)); // Another process published it before we could claim it.
    }
    if job.is_far {
        return Ok(Outcome::Lost);
    }
    let now = Now::of(graph, job.node, &|input| job.upstream.get(&input).and_then(|(_, digest)| *digest));
    let history = store.latest_history(work.name());
    let label = &graph.nodes[job.node].label;
    started(now.map_or_else(Vec::new, |now| nearest(store, &history, work.name(), label, job.key, &now).1));
    let mut open = Streams { graph, job, streams: BTreeMap::new(), order: Vec::new() };
    let mut inputs = Inputs::default();
    for (port, nodes) in &graph.nodes[job.node].ports {
        let artefacts = nodes.iter().map(|node| open.artefact(node.0)).collect::<Result<_>>()?;
        inputs.insert(port, artefacts);
    }
    let mut draft = store.draft()?;
    let begun = (jiff::Timestamp::now(), Instant::now());
    let resident = Resident::watch();
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads)
        .stack_size(8 << 20)
        .build()
        .map_err(|e| Error::failed(format!("cannot start threads: {e}")))?;
    let output = &mut draft.output;
    let ran = pool.install(|| catch_unwind(AssertUnwindSafe(|| work.run(&inputs, output, &job.progress))));
    let resident_peak_bytes = resident.peak_bytes();
    ran.unwrap_or_else(|panic| Err(panicked(&*panic)))?;

    let mut known: BTreeMap<usize, Digest> =
        job.upstream.iter().filter_map(|(&n, (_, digest))| digest.map(|digest| (n, digest))).collect();
    let mut learned = Vec::new();
    for (n, stream) in &open.order {
        if known.contains_key(n) {
            continue;
        }
        let Kind::Stage { work, .. } = &graph.nodes[*n].kind else { continue };
        let members = pool.install(|| catch_unwind(AssertUnwindSafe(|| stream.members())));
        let members = members.unwrap_or_else(|panic| Err(panicked(&*panic)))?;
        let mut manifest = describe(graph, *n, &known, &**work, job, begun)?;
        manifest.digest = digest_of(&members);
        manifest.members = members;
        manifest.is_virtual = true;
        manifest.seconds = 0.0;
        known.insert(*n, manifest.digest);
        let manifest = store.publish(store.draft()?, manifest)?;
        store.record_history(&manifest, 0.0);
        learned.push((*n, manifest));
    }
    let mut manifest = describe(graph, job.node, &known, &**work, job, begun)?;
    manifest.resident_peak_bytes = resident_peak_bytes;
    store.close(&mut draft, &mut manifest)?;
    let before = history.iter().rfind(|past| past.label == manifest.label);
    let same_output = before.is_some_and(|past| past.digest == manifest.digest);
    let mine = manifest.clone();
    let mut manifest = store.publish(draft, manifest)?;
    store.record_history(&manifest, begun.1.elapsed().as_secs_f64());
    let in_vain = manifest != mine;
    if manifest.digest != mine.digest {
        manifest
            .warnings
            .push("another run of the same work gave other values: this stage is not deterministic".into());
    }
    Ok(Outcome::Ran { manifest, same_output, in_vain, learned })
}

/// The virtual artefacts opened for one job, in the order in which they depend on each other.
struct Streams<'a> {
    graph: &'a Graph,
    job: &'a Job,
    streams: BTreeMap<usize, Artefact>,
    order: Vec<(usize, Arc<VirtualArtefact>)>,
}

impl Streams<'_> {
    fn artefact(&mut self, n: usize) -> Result<Artefact> {
        if let Some((Some(artefact), _)) = self.job.upstream.get(&n) {
            return Ok(artefact.clone());
        }
        if let Some(artefact) = self.streams.get(&n) {
            return Ok(artefact.clone());
        }
        let node = &self.graph.nodes[n];
        let mut inputs = Inputs::default();
        for (port, nodes) in &node.ports {
            let artefacts = nodes.iter().map(|node| self.artefact(node.0)).collect::<Result<_>>()?;
            inputs.insert(port, artefacts);
        }
        let source = match &node.kind {
            Kind::Stage { work, .. } => work.open(&inputs),
            Kind::File(_) => None,
        };
        let missing = || Error::failed(format!("the values of `{}` are not at hand", node.label));
        let stream = Arc::new(VirtualArtefact::new(source.ok_or_else(missing)?.map_err(|e| e.at(&node.label))?));
        self.order.push((n, stream.clone()));
        let artefact = Artefact::streamed(&node.label, stream);
        self.streams.insert(n, artefact.clone());
        Ok(artefact)
    }
}

fn describe(
    graph: &Graph,
    n: usize,
    known: &BTreeMap<usize, Digest>,
    work: &dyn Work,
    job: &Job,
    begun: (jiff::Timestamp, Instant),
) -> Result<Manifest> {
    let node = &graph.nodes[n];
    let mut inputs = BTreeMap::new();
    let mut ports = Vec::new();
    for (port, nodes) in &node.ports {
        let mut records = Vec::new();
        for input in nodes {
            let label = &graph.nodes[input.0].label;
            let digest = known.get(&input.0);
            let digest = *digest.ok_or_else(|| Error::failed(format!("the digest of `{label}` is not known")))?;
            records.push(InputRecord { node: label.clone(), digest });
        }
        ports.push((port.as_str(), records.iter().map(|record| record.digest).collect()));
        inputs.insert(port.clone(), records);
    }
    Ok(Manifest {
        format: FORMAT,
        stage: work.name().to_owned(),
        version: work.version(),
        label: node.label.clone(),
        key: key(work.name(), work.version(), &work.params_bytes()?, &ports),
        params: Params::of(&work.params()?)?,
        inputs,
        digest: Digest([0; 32]),
        is_virtual: false,
        members: Vec::new(),
        started: begun.0.to_string(),
        seconds: begun.1.elapsed().as_secs_f64(),
        resident_peak_bytes: None,
        threads: job.threads,
        host: gethostname::gethostname().to_string_lossy().into_owned(),
        program: concat!(env!("CARGO_PKG_NAME"), " ", env!("CARGO_PKG_VERSION")).to_owned(),
        warnings: Vec::new(),
    })
}

fn panicked(panic: &(dyn std::any::Any + Send)) -> Error {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".into());
    Error::failed(format!("the stage panicked: {text}")).help("this is a bug: please report it with this message")
}
