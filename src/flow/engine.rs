//! Brings the targets of a graph up to date.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::change::Change;
use super::event::Event;
use super::found::read_files;
use super::graph::{Graph, NodeId};
use super::plan::{self, Plan, Step};
use super::run::{self, Job, Outcome};
use super::schedule::{Schedule, Taken, Want};
use super::stage::Progress;
use crate::error::{Error, Result};
use crate::store::{Artefact, Digest, InUse, Key, Manifest, Store};

/// How often progress is reported.
const TICK: Duration = Duration::from_millis(100);

/// How soon, and how often at the least, workers look whether other processes are done: many machines that wait must
/// not keep a file server busy.
const PATIENCE: (Duration, Duration) = (Duration::from_millis(20), Duration::from_secs(1));

/// Nodes fetched at once beside the work: fetching waits for answers, hardly for the processor.
const FETCHERS: usize = 8;

/// Runs graphs over a store.
pub struct Engine<'a> {
    store: &'a Store,
    threads: usize,
    memory_bytes: u64,
    cancel: Arc<AtomicBool>,
    until: Option<Instant>,
    log: Option<String>,
    on_event: Box<dyn Fn(&Event) + Send + Sync + 'a>,
}

impl<'a> Engine<'a> {
    /// An engine with as many threads as the process may use, 4 GiB of memory, and nobody listening.
    pub fn new(store: &'a Store) -> Self {
        Self {
            store,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            memory_bytes: 4 << 30,
            cancel: Arc::default(),
            until: None,
            log: None,
            on_event: Box::new(|_| {}),
        }
    }

    /// Nodes at once, and threads inside of nodes; at least 1.
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Bytes that the nodes running at once may hold by their own account; a node that needs more runs alone.
    #[must_use]
    pub fn memory_bytes(mut self, bytes: u64) -> Self {
        self.memory_bytes = bytes;
        self
    }

    /// Stops the run once `flag` is true; finished nodes stay in the store.
    #[must_use]
    pub fn cancel(mut self, flag: Arc<AtomicBool>) -> Self {
        self.cancel = flag;
        self
    }

    /// Begins no node after `end`; what runs then is finished.
    #[must_use]
    pub fn until(mut self, end: Option<Instant>) -> Self {
        self.until = end;
        self
    }

    /// Names the log of this process in what it records of failures.
    #[must_use]
    pub fn log(mut self, path: Option<String>) -> Self {
        self.log = path;
        self
    }

    /// Calls `listener` for every event; it should be quick.
    #[must_use]
    pub fn on_event(mut self, listener: impl Fn(&Event) + Send + Sync + 'a) -> Self {
        self.on_event = Box::new(listener);
        self
    }

    /// Brings `targets` up to date. Nodes that do not depend on a failed one are finished all the same; then all
    /// failures are returned at once.
    ///
    /// # Errors
    /// All failures of nodes, or the interruption.
    pub fn run(&self, graph: &Graph, targets: &[NodeId]) -> Result<Report> {
        let (report, failures) = self.attempt(graph, targets)?;
        Error::many(failures.into_iter().map(|(_, error)| error).collect())?;
        Ok(report)
    }

    /// As [`Engine::run`], but nodes that failed are handed back beside the report of what could be done.
    ///
    /// # Errors
    /// The interruption.
    pub fn attempt(&self, graph: &Graph, targets: &[NodeId]) -> Result<(Report, Vec<(NodeId, Error)>)> {
        let in_use = self.store.use_it();
        let mut schedule = Schedule::new(graph, self.store, &*self.on_event);
        schedule.log.clone_from(&self.log);
        let reachable = graph.upstream(targets);
        (self.on_event)(&Event::Planned { total: reachable.iter().filter(|&&is| is).count() });
        for (n, found) in read_files(graph, self.store, &reachable) {
            schedule.file_known(n, found);
        }
        schedule.ask_store(&reachable);
        for target in targets {
            schedule.raise(target.0, Want::Values);
        }
        let shared =
            Shared { state: Mutex::new(State { schedule, running: BTreeMap::new(), bytes: 0 }), turn: Condvar::new() };
        if !shared.lock().schedule.ready.is_empty() {
            std::thread::scope(|scope| {
                let fetchers = if self.store.is_over_far() { FETCHERS } else { 0 };
                for n in 0..self.threads + fetchers {
                    let (shared, only_far) = (&shared, n >= self.threads);
                    scope.spawn(move || self.work(graph, shared, only_far));
                }
                self.report_progress(&shared);
            });
        }
        self.store.remember_files();
        let state = shared.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut schedule = state.schedule;
        let complete = targets.iter().all(|target| schedule.slots[target.0].artefact.is_some());
        if !complete && (self.is_over() || schedule.errors.is_empty()) {
            return Err(Error::interrupted());
        }
        let failures = std::mem::take(&mut schedule.errors);
        let entries = schedule.slots.into_iter().map(|slot| Entry {
            key: slot.key,
            digest: slot.digest,
            artefact: slot.artefact,
            manifest: slot.manifest,
            ran: slot.ran,
        });
        let labels = graph.nodes.iter().map(|node| node.label.clone()).collect();
        Ok((Report { labels, entries: entries.collect(), _in_use: in_use }, failures))
    }

    /// What [`Engine::run`] would do, and why, without doing it.
    ///
    /// # Errors
    /// Where the store cannot be read or a parameter cannot be written.
    pub fn status(&self, graph: &Graph, targets: &[NodeId]) -> Result<Plan> {
        plan::plan(graph, self.store, targets)
    }

    /// What changed at `node` against the nearest earlier run, and upstream of it: root causes first, `node` last.
    ///
    /// # Errors
    /// Where `node` is a file, and as for [`Engine::status`].
    pub fn why(&self, graph: &Graph, node: NodeId) -> Result<Vec<Step>> {
        plan::why(graph, self.store, node)
    }

    /// One worker: takes ready nodes, or `only_far` ones, until none is left and none is running.
    fn work(&self, graph: &Graph, shared: &Shared<'_>, only_far: bool) {
        let mut patience = PATIENCE.0;
        loop {
            let mut state = shared.lock();
            let (job, bytes, held) = loop {
                if self.is_over() {
                    state.schedule.ready.clear();
                }
                let idle = state.running.is_empty();
                let free = self.memory_bytes.saturating_sub(state.bytes);
                match state.schedule.take(free, idle, only_far) {
                    Taken::Node { n, bytes, held } => break (self.job(graph, &state, n), bytes, held),
                    Taken::AllBusy => {
                        state = shared.turn.wait_timeout(state, patience).unwrap_or_else(PoisonError::into_inner).0;
                        patience = (patience * 2).min(PATIENCE.1);
                    }
                    Taken::Nothing if idle && state.schedule.ready.is_empty() => {
                        shared.turn.notify_all();
                        return;
                    }
                    Taken::Nothing => state = shared.turn.wait(state).unwrap_or_else(PoisonError::into_inner),
                }
            };
            patience = PATIENCE.0;
            let n = job.node;
            state.bytes += bytes;
            state.running.insert(n, (job.progress.clone(), 0));
            shared.turn.notify_all();
            drop(state);

            let started = |why: Vec<Change>| {
                let _state = shared.lock();
                (self.on_event)(&Event::Started { node: NodeId(n), why });
            };
            let outcome = run::run(graph, self.store, &job, &started);
            drop(held);

            let mut state = shared.lock();
            state.bytes -= bytes;
            state.running.remove(&n);
            self.settle(&mut state, n, outcome);
            shared.turn.notify_all();
        }
    }

    /// Whether no further node may begin.
    fn is_over(&self) -> bool {
        self.cancel.load(Ordering::Relaxed) || self.until.is_some_and(|end| Instant::now() >= end)
    }

    fn job(&self, graph: &Graph, state: &State<'_>, n: usize) -> Job {
        let schedule = &state.schedule;
        let mut upstream = BTreeMap::new();
        let mut open: Vec<usize> = graph.nodes[n].inputs().collect();
        while let Some(input) = open.pop() {
            let slot = &schedule.slots[input];
            if slot.artefact.is_none() {
                open.extend(graph.nodes[input].inputs());
            }
            upstream.insert(input, (slot.artefact.clone(), slot.digest));
        }
        // Twice as many threads as its share, so that a thread that waits leaves no core idle.
        let at_once = (state.running.len() + 1 + schedule.ready.len()).min(self.threads);
        let threads = (2 * self.threads).div_ceil(at_once).min(self.threads);
        let (key, is_far) = (schedule.slots[n].key, schedule.slots[n].is_far);
        Job { node: n, key, upstream, is_far, threads, progress: Progress::new(self.cancel.clone()) }
    }

    fn settle(&self, state: &mut State<'_>, n: usize, outcome: Result<Outcome>) {
        let schedule = &mut state.schedule;
        let settled = outcome.and_then(|outcome| match outcome {
            Outcome::Found(manifest) => {
                let artefact = self.store.artefact(&manifest)?;
                if !std::mem::replace(&mut schedule.slots[n].hit, true) {
                    let (key, warnings) = (manifest.key, manifest.warnings.clone());
                    (self.on_event)(&Event::Hit { node: NodeId(n), key, warnings });
                }
                schedule.finish(n, manifest, Some(artefact));
                Ok(())
            }
            Outcome::Lost => {
                schedule.lost(n);
                Ok(())
            }
            Outcome::Ran { manifest, same_output, in_vain, learned } => {
                let artefact = self.store.artefact(&manifest)?;
                for (v, manifest) in learned {
                    let artefact = if manifest.is_virtual { None } else { Some(self.store.artefact(&manifest)?) };
                    schedule.know(v, manifest, artefact);
                }
                (self.on_event)(&Event::Finished {
                    node: NodeId(n),
                    seconds: manifest.seconds,
                    digest: manifest.digest,
                    same_output,
                    in_vain,
                    warnings: manifest.warnings.clone(),
                });
                schedule.slots[n].ran = true;
                schedule.finish(n, manifest, Some(artefact));
                Ok(())
            }
        });
        if let Err(error) = settled {
            schedule.fail(n, error);
        }
    }

    /// Reports how far the running nodes are until all are done.
    fn report_progress(&self, shared: &Shared<'_>) {
        let mut state = shared.lock();
        while !(state.running.is_empty() && state.schedule.ready.is_empty()) {
            let (next, _) = shared.turn.wait_timeout(state, TICK).unwrap_or_else(PoisonError::into_inner);
            state = next;
            if self.is_over() {
                state.schedule.ready.clear();
                shared.turn.notify_all();
            }
            for (&n, (progress, shown)) in &mut state.running {
                let (done, total) = progress.state();
                if done != *shown {
                    *shown = done;
                    (self.on_event)(&Event::Progress { node: NodeId(n), done, total });
                }
            }
        }
    }
}

struct State<'a> {
    schedule: Schedule<'a>,
    /// With each running node its progress and the steps last reported.
    running: BTreeMap<usize, (Progress, u64)>,
    /// Bytes that the running nodes may hold.
    bytes: u64,
}

struct Shared<'a> {
    state: Mutex<State<'a>>,
    turn: Condvar,
}

impl<'a> Shared<'a> {
    fn lock(&self) -> MutexGuard<'_, State<'a>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Entry {
    key: Option<Key>,
    digest: Option<Digest>,
    artefact: Option<Artefact>,
    manifest: Option<Manifest>,
    ran: bool,
}

/// What a run found and made.
pub struct Report {
    labels: Vec<String>,
    entries: Vec<Entry>,
    /// Cleaning waits until what was found and made is copied out.
    _in_use: InUse,
}

impl Report {
    /// The artefact of a target, or of any node whose values the run needed.
    pub fn artefact(&self, node: NodeId) -> Result<Artefact> {
        self.entries[node.0].artefact.clone().ok_or_else(|| {
            Error::failed(format!("the values of `{}` were not asked for in this run", self.labels[node.0]))
        })
    }

    /// The digest of a node's artefact; `None` if the run had no need of it.
    pub fn digest(&self, node: NodeId) -> Option<Digest> {
        self.entries[node.0].digest
    }

    /// The key of a node; `None` for files and for nodes that the run had no need of.
    pub fn key(&self, node: NodeId) -> Option<Key> {
        self.entries[node.0].key
    }

    /// The manifest of a node; `None` as for [`Report::key`].
    pub fn manifest(&self, node: NodeId) -> Option<&Manifest> {
        self.entries[node.0].manifest.as_ref()
    }

    /// Whether the node was computed in this run.
    pub fn ran(&self, node: NodeId) -> bool {
        self.entries[node.0].ran
    }
}
