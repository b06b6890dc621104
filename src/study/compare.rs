//! Results of one plant held against each other: read from results folders, or taken from the points of a sweep.

use super::batch::{Point, Study};
use super::folder::LOCK;
use super::inputs::TankSection;
use super::lock::Lock;
use super::nodes::StudyNodes;
use super::settings::Settings;
use crate::error::{Error, Result};
use crate::flow::Report;
use crate::formats::points_csv::{self, Points};
use crate::formats::tables;
use crate::optics::Tank;
use crate::report::compare::{MOST, Shown};
use crate::roots::RootSystem;
use crate::store::Digest;
use std::collections::BTreeMap;
use std::path::Path;

/// Outer radii, heights and walls that differ by more, mm, are of different tanks: a tape measure is better than that.
const SAME_TANK_MM: f64 = 1.0;

/// The result in a folder.
///
/// # Errors
/// Where the folder holds no result of a single study, or a file of it is missing or malformed.
pub fn of_folder(folder: &Path) -> Result<Shown> {
    let place = folder.display();
    let no_result = |why: &str| Error::usage(format!("`{place}` is no results folder: {why}"));
    if !folder.is_dir() {
        return Err(
            no_result("there is no such folder").help("name folders that `rootvox run` wrote, such as results/plant-7")
        );
    }
    let path = folder.join(LOCK);
    if !path.is_file() {
        return Err(no_result(&format!("it holds no {LOCK}")).help(
            "name folders that `rootvox run` wrote, such as results/plant-7; points of a sweep are compared in the sweep's compare.html",
        ));
    }
    let lock = Lock::read(&path)?;
    if lock.is_trial() {
        return Err(Error::usage(format!("`{place}` is a whole trial"))
            .help("name the folders of its captures, <plant>-<date>, beside it"));
    }
    if !lock.points.is_empty() {
        return Err(Error::usage(format!("`{place}` is a sweep"))
            .help("with `traits = true` under [sweep] it has a compare.html of its own, over its points"));
    }
    let bytes = |name: &str| {
        let path = folder.join(name);
        std::fs::read(&path)
            .map_err(|e| Error::io("read", &path, e).help("run the study again: its results are not whole"))
    };
    let name = folder.join("roots.csv").display().to_string();
    let Points::Roots(roots) = points_csv::parse(&name, &bytes("roots.csv")?)? else {
        return Err(Error::failed(format!("`{name}` tells no parents, orders and diameters"))
            .help("run the study again with this version"));
    };
    let traits = tables::read_traits(&bytes("traits.csv")?).map_err(|e| e.at(place.to_string()))?;
    let tank = tank(&lock.settings).map_err(|e| e.at(path.display()))?;
    Ok(Shown { name: lock.study.clone(), about: place.to_string(), tank, roots, traits, settings: made_with(lock) })
}

/// Fails where the results cannot be of one plant in one tank.
///
/// # Errors
/// Names the two that differ first, and how.
pub fn check_alike(shown: &[Shown]) -> Result<()> {
    let Some((first, others)) = shown.split_first() else { return Ok(()) };
    for other in others {
        if let Some((what, x, y)) = apart(&first.tank, &other.tank) {
            let (a, b) = (first.title(), other.title());
            return Err(Error::usage(format!("`{a}` and `{b}` are of different tanks: {what} {x} and {y} mm"))
                .help("only results of one plant, in one frame, can be compared"));
        }
    }
    Ok(())
}

/// By which measure two tanks are not one, and the two values, mm.
fn apart(a: &Tank, b: &Tank) -> Option<(&'static str, f64, f64)> {
    [("outer radius", a.radius_mm, b.radius_mm), ("height", a.height_mm, b.height_mm), ("wall", a.wall_mm, b.wall_mm)]
        .into_iter()
        .find(|(_, x, y)| (x - y).abs() > SAME_TANK_MM)
}

/// A point of a sweep that went through.
pub(super) type Done<'a> = (&'a Point, &'a Settings, &'a StudyNodes);

/// Whether the points of a sweep can be compared: they were traced, 2 to [`MOST`] went through, and stand in one tank.
pub(super) fn are_comparable(study: &Study, done: &[Done<'_>]) -> bool {
    let in_one_tank = || done.iter().all(|(_, settings, _)| apart(&done[0].1.tank, &settings.tank).is_none());
    study.traits && (2..=MOST).contains(&done.len()) && in_one_tank()
}

/// The points of a sweep.
///
/// # Errors
/// Where a result is missing in the store.
pub(super) fn of_points(study: &Study, done: &[Done<'_>], report: &Report) -> Result<Vec<Shown>> {
    let of = |&(point, settings, nodes): &Done<'_>| -> Result<Shown> {
        let values = study.parameters.iter().zip(&point.values);
        let system: RootSystem = report.artefact(nodes.system)?.json("system.json")?;
        Ok(Shown {
            name: format!("point {}", point.number),
            about: values.map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", "),
            tank: settings.tank.clone(),
            roots: system.plain(),
            traits: tables::read_traits(&report.artefact(nodes.traits)?.bytes("traits.csv")?)?,
            settings: settings.resolved.clone(),
        })
    };
    done.iter().map(of).collect()
}

/// The tank that a lock's settings tell.
fn tank(settings: &BTreeMap<String, String>) -> Result<Tank> {
    let lines: String = settings
        .iter()
        .filter_map(|(name, value)| Some(format!("{} = {value}\n", name.strip_prefix("tank.")?)))
        .collect();
    let section: TankSection = toml::from_str(&lines).map_err(|e| Error::failed(format!("[tank]: {}", e.message())))?;
    section.resolve(Path::new(""))
}

/// Settings, versions and files that a lock names.
fn made_with(lock: Lock) -> BTreeMap<String, String> {
    let mut all = lock.settings;
    all.remove("study.name");
    all.insert("rootvox".into(), lock.rootvox);
    for work in &lock.work {
        all.insert(format!("stage {}", work.stage), format!("version {}", work.version));
    }
    let files: Vec<String> =
        lock.nodes.iter().filter(|n| n.work.is_none()).filter_map(|n| Some(n.digest?.to_string())).collect();
    if !files.is_empty() {
        all.insert(
            "input files".into(),
            format!("{}, digest {}", files.len(), Digest::of(files.concat().as_bytes()).short()),
        );
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(radius: f64, water_level: f64) -> Shown {
        let settings =
            [("tank.radius", radius), ("tank.height", 130.0), ("tank.wall", 3.0), ("tank.water_level", water_level)]
                .map(|(name, value)| (name.to_owned(), value.to_string()));
        let settings = BTreeMap::from(settings);
        let tank = tank(&settings).unwrap();
        Shown {
            name: format!("r{radius}"),
            about: String::new(),
            tank,
            roots: Vec::new(),
            traits: Vec::new(),
            settings,
        }
    }

    #[test]
    fn tanks_are_told_apart_by_what_a_tape_measure_tells() {
        check_alike(&[shown(45.0, 8.0), shown(45.4, 12.0)]).unwrap();
        let error = check_alike(&[shown(45.0, 8.0), shown(45.0, 8.0), shown(60.0, 8.0)]).unwrap_err();
        assert!(
            error.message.contains("`r45` and `r60`") && error.message.contains("outer radius 45 and 60 mm"),
            "{error}"
        );
        assert!(tank(&BTreeMap::new()).is_err());
    }
}
