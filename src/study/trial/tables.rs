//! The tables of a trial: tidy, one observation per row, plant, date and groups in front.

use super::gather::Gathered;
use super::tried::Tried;
use crate::error::Result;
use crate::formats::growth_csv;
use crate::formats::recalled_csv;
use crate::formats::tables::{self, Table};
use crate::growth::compare::{Effect, effect};
use std::collections::BTreeMap;

/// A group column compares groups where it has so many values at most.
const MOST_GROUPS: usize = 8;

/// All tables with their names.
///
/// # Errors
/// Where a row cannot be written.
pub(super) fn of(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Result<Vec<(&'static str, Vec<u8>)>> {
    let mut all_tables = vec![
        ("quality.csv", quality(tried, all)?),
        ("traits.csv", traits(tried, all)?),
        ("roots.csv", joined(tried, all, |g| &g.roots)?),
        ("depth_profile.csv", joined(tried, all, |g| &g.profile)?),
        ("effects.csv", effects_table(&effects(tried, all))?),
        ("growth.csv", of_plants(tried, "growth.csv", &growth_csv::COLUMNS)?),
    ];
    let helped = tried.followed().map(|days| Ok(tried.report.artefact(days.follow)?.has("recalled.csv")));
    if helped.collect::<Result<Vec<bool>>>()?.contains(&true) {
        all_tables.push(("recalled.csv", of_plants(tried, "recalled.csv", &recalled_csv::COLUMNS)?));
    }
    Ok(all_tables)
}

/// The columns that tell captures apart, and others.
fn columns<'a>(tried: &Tried<'a>, others: &[&'a str]) -> Vec<&'a str> {
    tried.trial.columns().chain(others.iter().copied()).collect()
}

fn done<'a>(tried: &'a Tried<'_>, all: &'a [Option<Gathered>]) -> impl Iterator<Item = (Vec<String>, &'a Gathered)> {
    tried.trial.captures.iter().zip(all).filter_map(|(capture, known)| Some((capture.values(), known.as_ref()?)))
}

fn quality(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Result<Vec<u8>> {
    let text = |x: Option<f64>| x.filter(|x| x.is_finite()).map(|x| format!("{x:.4}")).unwrap_or_default();
    let rows = tried.trial.captures.iter().zip(&tried.failed).zip(all).map(|((capture, fault), known)| {
        let mut row = capture.values();
        row.push(if known.is_some() { "done" } else { "failed" }.to_owned());
        row.push(fault.as_ref().map(|e| e.message.clone()).unwrap_or_default());
        match known {
            Some(Gathered { quality: q, system, .. }) => row.extend([
                q.photographs.to_string(),
                text(q.belt_sigma_px),
                q.warnings.to_string(),
                system.roots.len().to_string(),
                text(Some(q.confidence)),
                text(q.f1_1mm),
            ]),
            None => row.extend(vec![String::new(); 6]),
        }
        row
    });
    let others =
        ["state", "reason", "photographs", "belt_sigma_px", "warnings", "roots", "median_confidence", "f1_1mm"];
    tables::csv(&columns(tried, &others), rows)
}

fn traits(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Result<Vec<u8>> {
    let text = |x: f64| if x.is_finite() { x.to_string() } else { String::new() };
    let rows = done(tried, all).flat_map(|(values, known)| {
        known.traits.iter().map(move |one| {
            let spread = known.spread.get(&one.name).copied().unwrap_or(f64::NAN);
            values.iter().cloned().chain([one.name.clone(), text(one.value), text(spread)]).collect::<Vec<_>>()
        })
    });
    tables::csv(&columns(tried, &["trait", "value", "spread"]), rows)
}

/// A table of all captures, one below the other.
fn joined(tried: &Tried<'_>, all: &[Option<Gathered>], of: impl Fn(&Gathered) -> &Table) -> Result<Vec<u8>> {
    let others = all.iter().flatten().map(&of).next().map(|t| t.columns.clone()).unwrap_or_default();
    let others: Vec<&str> = others.iter().map(String::as_str).collect();
    let mut names: Vec<&str> = tried.trial.columns().collect();
    names.extend(&others);
    let rows = done(tried, all).flat_map(|(values, known)| {
        of(known).rows.iter().map(move |row| values.iter().chain(row).cloned().collect::<Vec<_>>()).collect::<Vec<_>>()
    });
    tables::csv(&names, rows)
}

/// A table of all plants that were followed, one below the other; those that have none are left out.
fn of_plants(tried: &Tried<'_>, name: &str, columns: &[&str]) -> Result<Vec<u8>> {
    let front = ["plant"].into_iter().chain(tried.trial.groups.iter().map(String::as_str));
    let columns: Vec<&str> = front.chain(columns.iter().copied()).collect();
    let mut rows = Vec::new();
    for days in tried.followed() {
        let followed = tried.report.artefact(days.follow)?;
        if !followed.has(name) {
            continue;
        }
        let table = tables::read(name, &followed.bytes(name)?)?;
        // Groups of a plant are those of its first day.
        let capture = &tried.trial.captures[days.captures[0]];
        let front: Vec<&String> = std::iter::once(&capture.plant).chain(&capture.groups).collect();
        rows.extend(table.rows.iter().map(|row| front.iter().copied().chain(row).cloned().collect::<Vec<_>>()));
    }
    tables::csv(&columns, rows)
}

/// A group against the first of its column, in one trait on one date.
pub(super) struct Compared {
    pub column: String,
    pub date: String,
    pub trait_name: String,
    pub reference: String,
    pub group: String,
    pub effect: Effect,
}

/// The group columns that compare plants, with their values in order.
pub(super) fn compared_columns(tried: &Tried<'_>) -> Vec<(usize, Vec<String>)> {
    let plants = tried.trial.captures.iter().map(|c| &c.plant).collect::<std::collections::BTreeSet<_>>().len();
    let values = |n: usize| {
        let mut all: Vec<String> = tried.trial.captures.iter().map(|c| c.groups[n].clone()).collect();
        all.sort_unstable();
        all.dedup();
        all.retain(|value| !value.is_empty());
        (n, all)
    };
    let tells = |(_, all): &(usize, Vec<String>)| (2..=MOST_GROUPS).contains(&all.len()) && all.len() < plants;
    (0..tried.trial.groups.len()).map(values).filter(tells).collect()
}

/// All comparisons.
pub(super) fn effects(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Vec<Compared> {
    let mut effects = Vec::new();
    for (n, groups) in compared_columns(tried) {
        // By date and trait, the values of each group.
        let mut values: BTreeMap<(String, String), BTreeMap<&str, Vec<f64>>> = BTreeMap::new();
        for (capture, known) in tried.trial.captures.iter().zip(all) {
            let Some(known) = known else { continue };
            let date = capture.date.as_ref().map(|d| d.text.clone()).unwrap_or_default();
            for one in &known.traits {
                let of = values.entry((date.clone(), one.name.clone())).or_default();
                of.entry(&capture.groups[n]).or_default().push(one.value);
            }
        }
        let none = Vec::new();
        for ((date, trait_name), by_group) in &values {
            for group in &groups[1..] {
                let [a, b] = [&groups[0], group].map(|g| by_group.get(g.as_str()).unwrap_or(&none));
                if let Some(effect) = effect(a, b) {
                    effects.push(Compared {
                        column: tried.trial.groups[n].clone(),
                        date: date.clone(),
                        trait_name: trait_name.clone(),
                        reference: groups[0].clone(),
                        group: group.clone(),
                        effect,
                    });
                }
            }
        }
    }
    effects
}

fn effects_table(effects: &[Compared]) -> Result<Vec<u8>> {
    let number = |x: f64| x.is_finite().then_some(x);
    let rows = effects.iter().map(|c| {
        let e = &c.effect;
        let numbers = [e.mean[0], e.mean[1], e.sd[0], e.sd[1], e.change, e.interval[0], e.interval[1], e.hedges_g];
        ((&c.column, &c.date, &c.trait_name, &c.reference, &c.group), e.count, numbers.map(number))
    });
    let columns = [
        "column",
        "date",
        "trait",
        "reference",
        "group",
        "n_reference",
        "n",
        "mean_reference",
        "mean",
        "sd_reference",
        "sd",
        "change",
        "change_low",
        "change_high",
        "hedges_g",
    ];
    tables::csv(&columns, rows)
}
