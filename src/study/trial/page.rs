//! The page of a trial: what it shows, gathered.

use super::gather::Gathered;
use super::tables::{compared_columns, effects};
use super::tried::Tried;
use crate::error::Result;
use crate::growth::compare::{ODD, oddness};
use crate::report::trial::{Curve, Difference, Film, Known, Page, Shown};
use crate::roots::Root;
use crate::roots::traits::steps;
use std::collections::BTreeMap;

/// Numbers by which a capture can be unlike the others, with the word for them.
const WATCHED: [(&str, &str); 4] = [
    ("root_count", "roots"),
    ("total_root_length_mm", "mm of root"),
    ("mean_diameter_mm", "mm mean diameter"),
    ("depth_max_mm", "mm greatest depth"),
];

/// The page of a trial that was run.
///
/// # Errors
/// Where something of it is missing in the store.
pub(super) fn html(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Result<String> {
    let trial = tried.trial;
    let odd = odd(tried, all);
    let compared = effects(tried, all);
    let columns = compared_columns(tried);
    let mut captures = Vec::new();
    for (n, (capture, known)) in trial.captures.iter().zip(all).enumerate() {
        let planned = tried.batch.studies[n].points.first().and_then(|point| point.planned.as_ref().ok());
        let known = match (known, planned) {
            (Some(known), Some((settings, _))) => Ok(Known {
                traits: &known.traits,
                profile: layers(known),
                system: &known.system,
                tank: &settings.tank,
                odd: odd[n].clone(),
            }),
            _ => Err(tried.failed[n].as_ref().map(ToString::to_string).unwrap_or_default()),
        };
        captures.push(Shown {
            plant: &capture.plant,
            date: capture.date.as_ref().map_or("", |d| &d.text),
            groups: &capture.groups,
            link: format!("../{}/report.html", capture.name()),
            known,
        });
    }
    let (curves, films) = grown(tried)?;
    let page = Page {
        name: &trial.name,
        columns: columns
            .iter()
            .map(|(n, groups)| (*n, trial.groups[*n].as_str(), groups.iter().map(String::as_str).collect()))
            .collect(),
        captures,
        differences: compared
            .iter()
            .map(|c| Difference {
                column: &c.column,
                date: &c.date,
                trait_name: &c.trait_name,
                groups: [&c.reference, &c.group],
                effect: c.effect,
            })
            .collect(),
        curves,
        films,
        notes: tried.unfollowed().iter().map(ToString::to_string).chain(doubts(tried)).collect(),
    };
    Ok(page.html())
}

/// Each plant that was followed: its total length over days, and its roots on each.
fn grown<'a>(tried: &'a Tried<'_>) -> Result<(Vec<Curve<'a>>, Vec<Film<'a>>)> {
    let trial = tried.trial;
    let (mut curves, mut films) = (Vec::new(), Vec::new());
    for days in tried.followed() {
        let roots = tried.roots_over_days(days)?;
        let total = |of: &Vec<Root>| -> f64 { steps(of).iter().map(|s| s.length()).sum() };
        let points = roots.iter().map(|(time, of)| [*time, total(of)]).collect();
        let capture = &trial.captures[days.captures[0]];
        curves.push(Curve { plant: &days.plant, groups: &capture.groups, points });
        let planned = tried.batch.studies[days.captures[0]].points.first().and_then(|p| p.planned.as_ref().ok());
        films.extend(planned.map(|(settings, _)| Film { plant: &days.plant, tank: &settings.tank, days: roots }));
    }
    Ok((curves, films))
}

/// What the days of plants warned of.
fn doubts<'a>(tried: &'a Tried<'_>) -> impl Iterator<Item = String> + 'a {
    tried.trial.days.iter().flat_map(|days| {
        let warnings = tried.report.manifest(days.follow).map(|m| m.warnings.clone()).unwrap_or_default();
        warnings.into_iter().map(|warning| format!("plant {}: {warning}", days.plant)).collect::<Vec<_>>()
    })
}

fn layers(known: &Gathered) -> Vec<[f64; 3]> {
    let number = |row: &[String], n: usize| row.get(n).and_then(|x| x.parse().ok()).unwrap_or(f64::NAN);
    known.profile.rows.iter().map(|row| [number(row, 0), number(row, 1), number(row, 2)]).collect()
}

/// Per capture, what is unlike the others of its groups and date.
fn odd(tried: &Tried<'_>, all: &[Option<Gathered>]) -> Vec<Vec<String>> {
    let mut told = vec![Vec::new(); all.len()];
    let mut alike: BTreeMap<(&[String], &str), Vec<usize>> = BTreeMap::new();
    let columns: Vec<usize> = compared_columns(tried).into_iter().map(|(n, _)| n).collect();
    let groups: Vec<Vec<String>> =
        tried.trial.captures.iter().map(|c| columns.iter().map(|&n| c.groups[n].clone()).collect()).collect();
    for (n, capture) in tried.trial.captures.iter().enumerate().filter(|(n, _)| all[*n].is_some()) {
        let date = capture.date.as_ref().map_or("", |d| &d.text);
        alike.entry((&groups[n], date)).or_default().push(n);
    }
    for members in alike.values() {
        let mut look = |what: &str, of: &dyn Fn(&Gathered) -> f64| {
            let values: Vec<f64> = members.iter().map(|&n| all[n].as_ref().map_or(f64::NAN, of)).collect();
            let mut sorted: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
            sorted.sort_by(f64::total_cmp);
            for ((&n, value), far) in members.iter().zip(&values).zip(oddness(&values)) {
                if far.abs() > ODD {
                    let usual = sorted[sorted.len() / 2];
                    told[n].push(format!("{} {what} where {} is usual in its group", short(*value), short(usual)));
                }
            }
        };
        for (name, what) in WATCHED {
            look(what, &|known| known.traits.iter().find(|x| x.name == name).map_or(f64::NAN, |x| x.value));
        }
        look("median confidence of the roots", &|known| known.quality.confidence);
        look("px spread of the belts' points", &|known| known.quality.belt_sigma_px.unwrap_or(f64::NAN));
    }
    told
}

fn short(value: f64) -> String {
    if value.abs() >= 100.0 || value.fract() == 0.0 { format!("{value:.0}") } else { format!("{value:.2}") }
}
