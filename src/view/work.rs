//! What one turn computes, in the order in which it is looked at.

use super::message::{About, Teller};
use crate::error::{Error, Result};
use crate::flow::{Engine, Event, Graph, NodeId, Report};
use crate::report::page::{Page, changing_views};
use crate::stages::extract;
use crate::store::{Digest, Store};
use crate::study::batch::{Batch, Point};
use crate::study::command;
use crate::study::lock::Lock;
use crate::study::nodes::StudyNodes;
use crate::study::page::{self, Commands};
use crate::study::settings::Settings;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// What a session begins with.
pub struct Opening {
    /// The study file.
    pub study: PathBuf,
    /// `--set` of the command line.
    pub overrides: Vec<String>,
    /// Threads that nodes may take.
    pub threads: usize,
    /// Bytes that running nodes may take together.
    pub memory_bytes: u64,
    /// Nothing but the store may be written.
    pub read_only: bool,
}

/// The one study of a file, with some settings laid over it.
pub struct Study {
    batch: Batch,
    set: Vec<String>,
}

impl Study {
    /// Reads it as it is now.
    ///
    /// # Errors
    /// Its faults, and where the file holds several studies.
    pub fn load(opening: &Opening, set: &[String]) -> Result<Self> {
        let set = [&opening.overrides[..], set].concat();
        let batch = Batch::load(&opening.study, &set)?;
        let is_one = matches!(&batch.studies[..], [study] if !study.is_sweep()) && batch.trial.is_none();
        if is_one {
            return Ok(Self { batch, set });
        }
        Err(Error::usage(format!("`{}` holds several studies, a page shows one", opening.study.display()))
            .help("name the file of one study, without [sweep], [studies] or [plants]"))
    }

    /// Its graph.
    pub fn graph(&self) -> &Graph {
        &self.batch.graph
    }

    fn point(&self) -> &Point {
        &self.batch.studies[0].points[0]
    }

    /// Its settings and nodes.
    ///
    /// # Errors
    /// Where they are at fault.
    pub fn planned(&self) -> Result<(&Settings, &StudyNodes)> {
        self.point().planned.as_ref().map(|(settings, nodes)| (settings, nodes)).map_err(Clone::clone)
    }

    /// What `make` makes of its page; `report` has the nodes of [`Self::roots_nodes`].
    pub fn page<T>(
        &self,
        opening: &Opening,
        report: &Report,
        with_photographs: bool,
        make: impl FnOnce(&Page<'_>) -> Result<T>,
    ) -> Result<T> {
        let study = &self.batch.studies[0];
        let photographs = if with_photographs { page::photographs(self.point(), report)? } else { Vec::new() };
        let lock = Lock::of_nodes(&self.batch, study, &self.roots_nodes()?, report, Path::new("."))?;
        let made_by = format!("rootvox view {}", command::quoted(&opening.study.display().to_string()));
        let again = command::run(&opening.study, &self.set);
        let commands = Commands { made_by: &made_by, again: &again };
        page::with(self.point(), self.graph(), report, &lock, &commands, &photographs, make)
    }

    /// The nodes that the page tells of, but for those of the photographs.
    pub fn roots_nodes(&self) -> Result<Vec<NodeId>> {
        self.planned()?.1.told()
    }

    /// The nodes of the roots on the photographs.
    pub fn views_nodes(&self) -> Result<Vec<NodeId>> {
        let nodes = self.planned()?.1;
        let shown = nodes.shown()?;
        Ok([nodes.cameras].into_iter().chain(shown.previews.iter().chain(&shown.root_lines).copied()).collect())
    }
}

/// What runs nodes.
pub struct Machine {
    /// The store.
    pub store: Store,
    /// Threads.
    pub threads: usize,
    /// Bytes that running nodes may take together.
    pub memory_bytes: u64,
}

impl Machine {
    /// Brings nodes up to date.
    ///
    /// # Errors
    /// As [`Engine::run`].
    pub fn run(
        &self,
        graph: &Graph,
        targets: &[NodeId],
        cancel: &Arc<AtomicBool>,
        on_event: impl Fn(&Event) + Send + Sync,
    ) -> Result<Report> {
        Engine::new(&self.store)
            .threads(self.threads)
            .memory_bytes(self.memory_bytes)
            .cancel(cancel.clone())
            .on_event(on_event)
            .run(graph, targets)
    }
}

/// One turn: the study with these changes, told as it comes to be.
pub struct Turn<'a> {
    /// Its number.
    pub number: u64,
    /// What the study is opened with.
    pub opening: &'a Opening,
    /// What runs it.
    pub machine: &'a Machine,
    /// Who is told.
    pub teller: &'a Teller,
    /// Raised by the next turn.
    pub cancel: &'a Arc<AtomicBool>,
}

impl Turn<'_> {
    /// Computes all that is shown.
    ///
    /// # Errors
    /// Faults of the settings, of stages, and the interruption.
    pub fn run(&self, study: &Study) -> Result<()> {
        let (_, nodes) = study.planned()?;
        let report = self.nodes(study, &[nodes.extract])?;
        self.teller.tell_text(About::Voxels, voxels(self.number, &report, nodes.extract)?);
        let report = self.nodes(study, &study.roots_nodes()?)?;
        self.teller.tell_text(About::Roots, roots(self.number, self.opening, study, &report)?.text);
        let report = self.nodes(study, &study.views_nodes()?)?;
        self.teller.tell_text(About::Views, views(self.number, study, &report)?.text);
        Ok(())
    }

    fn nodes(&self, study: &Study, targets: &[NodeId]) -> Result<Report> {
        let graph = study.graph();
        let told = |node: NodeId, done: u64, total: u64| {
            let value = json!({ "turn": self.number, "node": graph.label(node), "done": done, "total": total });
            self.teller.tell(About::Progress, &value);
        };
        self.machine.run(graph, targets, self.cancel, |event| match event {
            Event::Started { node, .. } => told(*node, 0, 0),
            Event::Progress { node, done, total } => told(*node, *done, *total),
            _ => {}
        })
    }
}

/// The root voxels: `xyz` is base64 of three f32 (little endian, mm, tank frame) a voxel.
pub fn voxels(turn: u64, report: &Report, node: NodeId) -> Result<String> {
    let points = extract::read(&report.artefact(node)?)?;
    let pieces = points.iter().map(|p| p.component + 1).max().unwrap_or(0);
    let bytes: Vec<u8> = points.iter().flat_map(|p| p.point_mm).flat_map(f32::to_le_bytes).collect();
    Ok(json!({ "turn": turn, "count": points.len(), "pieces": pieces, "xyz": STANDARD.encode(bytes) }).to_string())
}

/// A message whose content changes less often than words and commands beside it: a page that has the digest has the content.
pub struct Told {
    /// Of the content.
    pub digest: Digest,
    /// The message, JSON.
    pub text: String,
}

impl Told {
    /// With further members of the message, which begin with a comma.
    fn new(turn: u64, content: &str, more: &str) -> Self {
        let digest = Digest::of(content.as_bytes());
        let text = format!("{{\"turn\":{turn},\"digest\":\"{digest}\",\"content\":{content}{more}}}");
        Self { digest, text }
    }
}

/// Roots and traits.
pub fn roots(turn: u64, opening: &Opening, study: &Study, report: &Report) -> Result<Told> {
    let [data, sections] = study.page(opening, report, false, |page| page.changing())?;
    Ok(Told::new(turn, &data, &format!(",\"sections\":{sections}")))
}

/// The roots on the photographs.
pub fn views(turn: u64, study: &Study, report: &Report) -> Result<Told> {
    Ok(Told::new(turn, &changing_views(&page::photographs(study.point(), report)?)?, ""))
}
