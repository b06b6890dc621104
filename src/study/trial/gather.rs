//! What a trial's tables and page are made of, capture by capture, taken out of the store.

use super::tried::Tried;
use crate::calibration::Registration;
use crate::error::Result;
use crate::evaluation::Score;
use crate::formats::tables::{self, Table};
use crate::growth::follow::Growth;
use crate::roots::RootSystem;
use crate::roots::traits::Trait;
use crate::study::nodes::StudyNodes;
use std::collections::BTreeMap;

/// What is known of one capture.
pub(super) struct Gathered {
    /// `traits.csv`.
    pub traits: Vec<Trait>,
    /// Standard deviation of each trait over halves of the photographs, where the study asks for it.
    pub spread: BTreeMap<String, f64>,
    /// `roots.csv`.
    pub roots: Table,
    /// `depth_profile.csv`.
    pub profile: Table,
    pub system: RootSystem,
    pub quality: Quality,
}

/// How well a capture went.
pub(super) struct Quality {
    pub photographs: usize,
    /// Robust standard deviation of a belt point, px, where the photographs gave the cameras.
    pub belt_sigma_px: Option<f64>,
    pub warnings: usize,
    /// Median confidence over the points of all roots.
    pub confidence: f64,
    /// F1 within 1 mm of the traced roots, where the truth is known.
    pub f1_1mm: Option<f64>,
}

/// Of every capture what is known, `None` where it failed. A capture whose plant was followed has traits of growth since the day
/// before.
///
/// # Errors
/// Where a result cannot be read.
pub(super) fn all(tried: &Tried<'_>) -> Result<Vec<Option<Gathered>>> {
    let mut all = captures(tried)?;
    for days in tried.followed() {
        let growth: Growth = tried.report.artefact(days.follow)?.json("growth.json")?;
        let time = |n: usize| tried.trial.captures[days.captures[n]].date.as_ref().map_or(f64::NAN, |d| d.days);
        for day in 1..days.captures.len() {
            if let Some(known) = &mut all[days.captures[day]] {
                let since = time(day) - time(day - 1);
                known.traits.extend(growth.traits(day, since).into_iter().map(|(name, value)| Trait { name, value }));
            }
        }
    }
    Ok(all)
}

fn captures(tried: &Tried<'_>) -> Result<Vec<Option<Gathered>>> {
    let one = |(study, fault): (&crate::study::batch::Study, &Option<crate::Error>)| {
        let planned = study.points.first().and_then(|point| point.planned.as_ref().ok());
        match (planned, fault) {
            (Some((_, nodes)), None) => gathered(tried, nodes).map(Some),
            _ => Ok(None),
        }
    };
    tried.batch.studies.iter().zip(&tried.failed).map(one).collect()
}

fn gathered(tried: &Tried<'_>, nodes: &StudyNodes) -> Result<Gathered> {
    let report = tried.report;
    let measured = report.artefact(nodes.traits)?;
    let table = |name: &str| -> Result<Table> { tables::read(name, &measured.bytes(name)?) };
    let mut spread = BTreeMap::new();
    if let Some(node) = nodes.shown()?.spread {
        let name = "trait_spread.csv";
        let all = tables::read(name, &report.artefact(node)?.bytes(name)?)?;
        let at = all.columns.iter().position(|c| c == "sd").unwrap_or(usize::MAX);
        let rows = all.rows.iter().filter_map(|row| Some((row.first()?.clone(), row.get(at)?.parse().ok()?)));
        spread.extend(rows);
    }
    let system: RootSystem = report.artefact(nodes.system)?.json("system.json")?;
    let registration: Option<Registration> =
        nodes.calibration.as_ref().map(|c| report.artefact(c.pose)?.json("registration")).transpose()?;
    let score: Option<Score> = nodes
        .roots_score
        .map(|n| report.artefact(n)?.json::<crate::stages::evaluate_roots::Judgement>("judgement"))
        .transpose()?
        .map(|judgement| judgement.score);
    let reached = tried.batch.graph.walk().upstream(&nodes.targets());
    let warnings = reached.iter().filter_map(|node| Some(report.manifest(*node)?.warnings.len())).sum();
    let mut confidence: Vec<f64> = system.roots.iter().flat_map(|root| root.confidence.iter().copied()).collect();
    let quality = Quality {
        photographs: nodes.photos.len(),
        belt_sigma_px: registration.and_then(|r| r.quality.adjustment).map(|a| a.belt_sigma_px),
        warnings,
        confidence: crate::math::robust::median(&mut confidence),
        f1_1mm: score.and_then(|score| score.f1(1.0)),
    };
    Ok(Gathered {
        traits: tables::read_traits(&measured.bytes("traits.csv")?)?,
        spread,
        roots: table("roots.csv")?,
        profile: table("depth_profile.csv")?,
        system,
        quality,
    })
}
