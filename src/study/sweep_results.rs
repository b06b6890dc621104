//! The results folder of a sweep: `sweep.csv`, `contact.svg`, where scores stand against a number `curves.svg` and
//! `curves.csv`, and per point `points/<number>/` with its numbers. A sweep with traits whose points can be compared has `compare.html`.
//!
//! Written beside itself and swapped in by rename, as the results of a single study. Points that failed are in the
//! table with their error and on the sheet with an empty panel.

use super::batch::{Batch, Point, Study};
use super::compare::{self, Done};
use super::crate_metadata::Made;
use super::folder::Fresh;
use super::lock::Lock;
use super::nodes::StudyNodes;
use super::results::{put_numbers, put_roots};
use super::settings::Settings;
use super::sweep_curves::Curves;
use super::table::Table;
use crate::error::{Error, Result};
use crate::evaluation::{CameraErrors, Score};
use crate::flow::{NodeId, Report};
use crate::report::compare::Page;
use crate::report::contact::{Panel, Slice, sheet};
use crate::stages::evaluate_roots::Judgement;
use crate::stages::extract::{self, RootPoint};
use std::collections::BTreeMap;
use std::path::Path;

/// Name of the page on which the points are compared.
pub const COMPARE: &str = "compare.html";

/// Columns of a contact sheet at most, where the fastest axis has more values.
const MOST_COLUMNS: usize = 8;

/// A sweep that was run.
pub struct Swept<'a> {
    batch: &'a Batch,
    study: &'a Study,
    report: &'a Report,
    /// With each point, why it failed.
    failed: Vec<Option<Error>>,
}

impl<'a> Swept<'a> {
    /// What a run made of the study; `failures` are those of all nodes.
    pub fn new(batch: &'a Batch, study: &'a Study, report: &'a Report, failures: &[(NodeId, Error)]) -> Self {
        let faults: BTreeMap<NodeId, &Error> = failures.iter().rev().map(|(node, error)| (*node, error)).collect();
        let mut walk = batch.graph.walk();
        let fault = |point: &Point| match &point.planned {
            Err(error) => Some(error.clone()),
            Ok(_) if faults.is_empty() => None,
            Ok(_) => {
                let reached = walk.upstream(&study.targets_of(point));
                let first = reached.iter().filter_map(|node| faults.get_key_value(node)).min_by_key(|(node, _)| **node);
                first.map(|(_, error)| (*error).clone())
            }
        };
        let failed = study.points.iter().map(fault).collect();
        Self { batch, study, report, failed }
    }

    /// The failures, each naming its point.
    pub fn failures(&self) -> Vec<Error> {
        let points = self.study.points.iter().zip(&self.failed);
        points.filter_map(|(point, fault)| Some(fault.clone()?.at(self.study.title(point)))).collect()
    }

    fn done(&self) -> impl Iterator<Item = Done<'a>> + '_ {
        self.study.points.iter().zip(&self.failed).filter_map(|(point, fault)| match (&point.planned, fault) {
            (Ok((settings, nodes)), None) => Some((point, settings, nodes)),
            _ => None,
        })
    }

    /// Whether the results have a page on which the points are compared.
    pub fn is_compared(&self) -> bool {
        compare::are_comparable(self.study, &self.done().collect::<Vec<_>>())
    }

    fn score(&self, nodes: &StudyNodes) -> Result<Option<Score>> {
        nodes.score.map(|n| self.report.artefact(n)?.json("score")).transpose()
    }

    /// One row per point: number, swept values, scores, traits where the sweep asks for them, counts, digest of the roots, error.
    ///
    /// # Errors
    /// Where a result cannot be read.
    pub fn table(&self) -> Result<Table> {
        let mut table = Table::default();
        for (point, fault) in self.study.points.iter().zip(&self.failed) {
            table.rows.push(Vec::new());
            table.put("point", point.number.to_string());
            for (parameter, value) in self.study.parameters.iter().zip(&point.values) {
                table.put(parameter, value.clone());
            }
            match (&point.planned, fault) {
                (Ok((_, nodes)), None) => self.put_results(nodes, &mut table)?,
                (_, fault) => table.put("error", fault.as_ref().map(|e| e.message.clone()).unwrap_or_default()),
            }
        }
        Ok(table)
    }

    fn put_results(&self, nodes: &StudyNodes, table: &mut Table) -> Result<()> {
        if let Some(score) = self.score(nodes)? {
            for at in &score.at {
                for (name, value) in [("f1", at.f1), ("precision", at.precision), ("recall", at.recall)] {
                    table.put(&format!("{name}_{}mm", at.tolerance_mm), format!("{value:.6}"));
                }
            }
            table.put("rms_mm", score.rms_mm.map(|v| format!("{v:.6}")).unwrap_or_default());
        }
        if let Some(node) = nodes.camera_errors {
            let errors: CameraErrors = self.report.artefact(node)?.json("errors")?;
            table.put("camera_rms_px", format!("{:.6}", errors.water_rms_px));
        }
        if self.study.traits {
            if let Some(node) = nodes.roots_score {
                put_judgement(&self.report.artefact(node)?.json("judgement")?, table);
            }
            let traits = self.report.artefact(nodes.traits)?.bytes("traits.csv")?;
            let mut rows = csv::Reader::from_reader(traits.as_slice());
            for row in rows.records() {
                let row = row.map_err(|e| Error::failed(format!("traits.csv: {e}")))?;
                table.put(row.get(0).unwrap_or_default(), row.get(1).unwrap_or_default().to_owned());
            }
        }
        let roots = self.report.artefact(nodes.extract)?;
        let voxels = roots.members().iter().find(|m| m.name == "index").and_then(|m| m.shape.first().copied());
        table.put("root_voxels", voxels.unwrap_or(0).to_string());
        table.put("digest", roots.digest().to_string());
        Ok(())
    }

    fn contact(&self) -> Result<String> {
        // The empty panels of points that failed are as large as another's.
        let Some((any, _)) = self.study.points.iter().find_map(|point| point.planned.as_ref().ok()) else {
            return Err(Error::failed(format!("no point of the sweep `{}` is sound", self.study.name)));
        };
        let (mut panels, mut tolerances) = (Vec::new(), Vec::<String>::new());
        for (point, fault) in self.study.points.iter().zip(&self.failed) {
            let mut lines = vec![format!("point {}", point.number)];
            let settings = match (&point.planned, fault) {
                (Ok((settings, nodes)), None) => {
                    if let Some(score) = self.score(nodes)? {
                        let f1: Vec<String> = score.at.iter().map(|a| format!("{:.3}", a.f1)).collect();
                        tolerances = score.at.iter().map(|a| a.tolerance_mm.to_string()).collect();
                        lines.push(format!("F1 {}", f1.join(", ")));
                    }
                    settings
                }
                _ => any,
            };
            let values = self.study.parameters.iter().zip(&point.values);
            lines.extend(values.map(|(parameter, value)| format!("{parameter} = {value}")));
            let (mut slice, grid) = (None, &settings.grid);
            let roots = match (&point.planned, fault) {
                (Ok((settings, nodes)), None) => {
                    let roots = extract::read(&self.report.artefact(nodes.extract)?)?;
                    slice = self.slice(settings, nodes, &roots)?;
                    Ok(roots.iter().map(|r| (r.point_mm, r.rootness)).collect())
                }
                (_, fault) => Err(fault.as_ref().map(|e| e.message.clone()).unwrap_or_default()),
            };
            panels.push(Panel {
                lines,
                roots,
                radius_mm: settings.tank.inner_radius_mm(),
                depth_mm: grid.spacing_mm * grid.shape[0] as f64,
                spacing_mm: grid.spacing_mm,
                slice,
            });
        }
        let scored =
            if tolerances.is_empty() { String::new() } else { format!(": F1 at {} mm", tolerances.join(", ")) };
        sheet(
            &format!("{}{scored}", self.study.name),
            &panels,
            self.study.fastest.min(MOST_COLUMNS),
            self.is_compared().then_some(COMPARE),
        )
    }

    /// The pictures of the slice that the study asks for, and the roots in it.
    fn slice(&self, settings: &Settings, nodes: &StudyNodes, roots: &[RootPoint]) -> Result<Option<Slice>> {
        let (Some(node), Some(depth_mm)) = (nodes.slices, settings.report.slice) else { return Ok(None) };
        let (artefact, grid) = (self.report.artefact(node)?, &settings.grid);
        let picture = |title: &str, name: &str| -> Result<(String, Vec<u8>)> {
            Ok((format!("{title} at z = {depth_mm} mm"), artefact.bytes(name)?))
        };
        let pictures = vec![
            picture("merged colours, roots red,", "merged.png")?,
            picture("views used (black 0)", "coverage.png")?,
            picture("rootness", "rootness.png")?,
        ];
        let near = |r: &&RootPoint| (f64::from(r.point_mm[2]) - depth_mm).abs() <= grid.spacing_mm / 2.0;
        let roots = roots.iter().filter(near).map(|r| [r.point_mm[0], r.point_mm[1]]).collect();
        Ok(Some(Slice { pictures, roots, half_mm: grid.spacing_mm * grid.shape[2] as f64 / 2.0 }))
    }

    /// Brings `results_dir/<name>` up to date and tells whether it had to be written.
    ///
    /// # Errors
    /// Where the folder cannot be written; the old results then stay as they were.
    pub fn write(&self, results_dir: &Path) -> Result<bool> {
        let folder = results_dir.join(&self.study.name);
        let lock = Lock::of(self.batch, self.study, self.report, &folder)?;
        let Some(fresh) = Fresh::begin(results_dir, &lock)? else { return Ok(false) };
        let digits = self.study.points.len().to_string().len();
        for (point, _, nodes) in self.done() {
            let prefix = format!("points/{:0digits$}/", point.number);
            if self.study.traits {
                put_roots(&fresh, &prefix, nodes, self.report)?;
            }
            put_numbers(&fresh, &prefix, nodes, self.report)?;
        }
        let table = self.table()?;
        fresh.write("sweep.csv", &table.csv()?)?;
        if let Some(curves) = self.study.parameters.first().and_then(|parameter| Curves::of(&table, parameter)) {
            fresh.write("curves.svg", curves.svg(&self.study.name)?.as_bytes())?;
            fresh.write("curves.csv", &curves.csv()?)?;
        }
        if self.is_compared() {
            let shown = compare::of_points(self.study, &self.done().collect::<Vec<_>>(), self.report)?;
            fresh.write(COMPARE, Page::new(&self.study.name, &shown).html()?.as_bytes())?;
        }
        fresh.write("contact.svg", self.contact()?.as_bytes())?;
        fresh.publish(&lock, &Made::of(self.batch, self.study, self.report))?;
        Ok(true)
    }
}

/// What is said of the traced roots against the true ones.
fn put_judgement(judgement: &Judgement, table: &mut Table) {
    for at in &judgement.score.at {
        table.put(&format!("roots_f1_{}mm", at.tolerance_mm), format!("{:.6}", at.f1));
    }
    let bias = judgement.score.length_bias;
    table.put("length_bias", bias.map(|v| format!("{v:.6}")).unwrap_or_default());
    for (name, matched) in [("tips", judgement.detail.tips), ("branch_points", judgement.detail.branch_points)] {
        if let Some(m) = matched {
            table.put(&format!("{name}_precision"), format!("{:.6}", m.precision()));
            table.put(&format!("{name}_recall"), format!("{:.6}", m.recall()));
        }
    }
}
