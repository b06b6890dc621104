//! One study open for changes: a thread computes the newest settings, and stops for newer ones.

use super::correct;
use super::fields::{self, Changes, Field};
use super::keeper::Keeper;
use super::message::{About, Message, Teller};
use super::page;
use super::work::{self, Machine, Opening, Study, Turn};
use crate::error::{Error, Kind, Result};
use crate::flow::Event;
use crate::store::Store;
use serde_json::{Map, Value, json};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use tokio::sync::broadcast::Receiver;

/// The file of corrections of a study that names none, beside it.
const CORRECTIONS: &str = "corrections.toml";

/// What is to be computed.
struct Wanted {
    turn: u64,
    changes: Changes,
    cancel: Arc<AtomicBool>,
    is_over: bool,
}

struct Inner {
    opening: Opening,
    machine: Machine,
    fields: Vec<Field>,
    teller: Teller,
    wanted: Mutex<Wanted>,
    newer: Condvar,
    keeper: Mutex<Keeper>,
}

/// A study open for changes.
pub struct Session {
    inner: Arc<Inner>,
    worker: Mutex<Option<JoinHandle<()>>>,
    page: page::Bare,
}

impl Session {
    /// Brings the study up to date, as far as its page tells of it, and opens it.
    ///
    /// # Errors
    /// Faults of the study and of its nodes, the interruption.
    pub fn open(
        opening: Opening,
        store: Store,
        cancel: &Arc<AtomicBool>,
        names: impl FnOnce(Vec<String>),
        on_event: impl Fn(&Event) + Send + Sync,
    ) -> Result<Self> {
        let machine = Machine { store, threads: opening.threads, memory_bytes: opening.memory_bytes };
        let fields = fields::fields()?;
        let study = Study::load(&opening, &[])?;
        names(study.graph().labels());
        let (settings, nodes) = study.planned()?;
        let mut targets = study.roots_nodes()?;
        targets.extend(study.views_nodes()?);
        targets.push(nodes.extract);
        let report = machine.run(study.graph(), &targets, cancel, on_event)?;
        let teller = Teller::default();
        teller.tell_text(About::Voxels, work::voxels(0, &report, nodes.extract)?);
        let (roots, views) = (work::roots(0, &opening, &study, &report)?, work::views(0, &study, &report)?);
        let have =
            json!({ About::Roots.name(): roots.digest.to_string(), About::Views.name(): views.digest.to_string() });
        teller.tell_text(About::Roots, roots.text);
        teller.tell_text(About::Views, views.text);
        teller.tell(About::File, &file(&fields::values(&fields, &settings.resolved), 0));
        teller.tell(About::Begun, &begun(0, &Changes::new()));
        teller.tell(About::Ended, &json!({ "turn": 0 }));
        let live = json!({ "fields": fields, "readOnly": opening.read_only, "have": have });
        let page = study.page(&opening, &report, true, |page| page::Bare::new(page, live))?;
        let wanted = Wanted { turn: 0, changes: Changes::new(), cancel: Arc::default(), is_over: false };
        let keeper = Mutex::new(Keeper::new(&opening.study));
        let inner =
            Inner { opening, machine, fields, teller, wanted: Mutex::new(wanted), newer: Condvar::new(), keeper };
        let inner = Arc::new(inner);
        let worker = std::thread::Builder::new().name("turns".into()).spawn({
            let inner = inner.clone();
            move || inner.turns()
        });
        let worker = worker.map_err(|e| Error::failed(format!("cannot start a thread: {e}")))?;
        Ok(Self { inner, worker: Mutex::new(Some(worker)), page })
    }

    /// The page, with a fresh nonce for its script.
    pub(super) fn page(&self, nonce: &str) -> String {
        self.page.with(nonce)
    }

    /// Asks for the study with these changes, instead of what was asked for before, and tells the number of the turn.
    ///
    /// # Errors
    /// Changes that are no settings.
    pub(super) fn ask(&self, changes: Changes) -> Result<u64> {
        fields::overrides(&self.inner.fields, &changes)?;
        let mut wanted = self.inner.wanted();
        wanted.turn += 1;
        wanted.changes = changes;
        wanted.cancel.store(true, Ordering::SeqCst);
        wanted.cancel = Arc::default();
        self.inner.newer.notify_all();
        Ok(wanted.turn)
    }

    /// What was told last, and what is told from now on.
    pub(super) fn listen(&self) -> (Vec<Message>, Receiver<Message>) {
        self.inner.teller.listen()
    }

    /// Writes changes into the study file.
    ///
    /// # Errors
    /// Where nothing may be written, or the study would be at fault.
    pub(super) fn keep(&self, changes: Changes) -> Result<u64> {
        let inner = &self.inner;
        inner.check_writable()?;
        let given = |name: &str| {
            inner.opening.overrides.iter().any(|set| set.split('=').next().is_some_and(|n| n.trim() == name))
        };
        if let Some(name) = changes.keys().find(|name| given(name)) {
            return Err(Error::usage(format!("{name} is given by --set, which counts more than the study file"))
                .help("start `rootvox view` without it"));
        }
        let set = fields::overrides(&inner.fields, &changes)?;
        Study::load(&inner.opening, &set)?;
        inner.keeper().keep(&inner.fields, &changes)?;
        inner.tell_file()?;
        self.ask(Changes::new())
    }

    /// Adds a correction to the study's file of corrections; where it has none, to a new one beside it that the study file then names.
    ///
    /// # Errors
    /// Where nothing may be written, what is given is no correction, or a file that the study does not name is in the way.
    pub(super) fn correct(&self, entry: Map<String, Value>) -> Result<u64> {
        let inner = &self.inner;
        inner.check_writable()?;
        {
            // One after the other: the first may name the file that the next is written into.
            let mut keeper = inner.keeper();
            let study = Study::load(&inner.opening, &[])?;
            let (settings, nodes) = study.planned()?;
            let when = jiff::Timestamp::now().strftime("%Y-%m-%dT%H:%M:%SZ").to_string();
            let correction = correct::read(entry, &when, &nodes.photos)?;
            match &settings.corrections_file {
                Some(file) => keeper.correct(file, &correction, None)?,
                None => {
                    let file = inner.opening.study.with_file_name(CORRECTIONS);
                    keeper.correct(&file, &correction, Some(CORRECTIONS))?;
                }
            }
        }
        inner.tell_file()?;
        let changes = inner.wanted().changes.clone();
        self.ask(changes)
    }

    /// Puts the files back to what they were before the last [`Self::keep`] or [`Self::correct`]; changes that were kept are shown on.
    ///
    /// # Errors
    /// Where nothing may be written, or somebody else wrote meanwhile.
    pub(super) fn undo(&self) -> Result<u64> {
        self.inner.check_writable()?;
        let kept = self.inner.keeper().undo()?;
        self.inner.tell_file()?;
        let changes = kept.unwrap_or_else(|| self.inner.wanted().changes.clone());
        self.ask(changes)
    }

    /// The study with the changes that are shown, and what runs its nodes.
    ///
    /// # Errors
    /// Faults of the study.
    pub(super) fn shown(&self) -> Result<(Study, &Machine)> {
        let changes = self.inner.wanted().changes.clone();
        let set = fields::overrides(&self.inner.fields, &changes)?;
        Ok((Study::load(&self.inner.opening, &set)?, &self.inner.machine))
    }

    /// Ends the session: what runs is stopped; what finished is in the store.
    pub fn close(&self) {
        {
            let mut wanted = self.inner.wanted();
            wanted.is_over = true;
            wanted.cancel.store(true, Ordering::SeqCst);
            self.inner.newer.notify_all();
        }
        let worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner).take();
        if let Some(worker) = worker {
            let _ = worker.join();
        }
    }
}

impl Inner {
    fn wanted(&self) -> MutexGuard<'_, Wanted> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn keeper(&self) -> MutexGuard<'_, Keeper> {
        self.keeper.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn check_writable(&self) -> Result<()> {
        if self.opening.read_only {
            return Err(Error::usage("nothing is written: the page was started with --read-only"));
        }
        Ok(())
    }

    /// Tells what the study file says now.
    fn tell_file(&self) -> Result<()> {
        let study = Study::load(&self.opening, &[])?;
        let values = fields::values(&self.fields, &study.planned()?.0.resolved);
        self.teller.tell(About::File, &file(&values, self.keeper().steps()));
        Ok(())
    }

    /// Computes the newest turn until the session is over.
    fn turns(&self) {
        let mut done = 0;
        loop {
            let mut wanted = self.wanted();
            while wanted.turn == done && !wanted.is_over {
                wanted = self.newer.wait(wanted).unwrap_or_else(PoisonError::into_inner);
            }
            if wanted.is_over {
                return;
            }
            let (number, changes, cancel) = (wanted.turn, wanted.changes.clone(), wanted.cancel.clone());
            drop(wanted);
            done = number;
            self.teller.tell(About::Begun, &begun(number, &changes));
            let turn =
                Turn { number, opening: &self.opening, machine: &self.machine, teller: &self.teller, cancel: &cancel };
            let ran = fields::overrides(&self.fields, &changes)
                .and_then(|set| Study::load(&self.opening, &set))
                .and_then(|study| turn.run(&study));
            match ran {
                Ok(()) => self.teller.tell(About::Ended, &json!({ "turn": number })),
                // A newer turn tells its own end.
                Err(e) if e.kind == Kind::Interrupted => {}
                Err(e) => {
                    let value = json!({ "turn": number, "error": e.message, "help": e.help });
                    self.teller.tell(About::Ended, &value);
                }
            }
        }
    }
}

/// Which changes are computed now.
fn begun(turn: u64, changes: &Changes) -> Value {
    json!({ "turn": turn, "changes": changes })
}

/// The values of the file, and how many times they can be taken back.
fn file(values: &Changes, kept: usize) -> Value {
    json!({ "values": values, "kept": kept })
}
