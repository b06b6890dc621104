//! RSML, the Root System Markup Language (Lobet et al. 2015), version 1.
//!
//! **Written profile**: unit mm and resolution 1, so that every reader agrees on lengths and on diameters;
//! points with the attributes x, y, z in this order (readers take them by position) in the tank frame, z down;
//! `diameter` (mm), `diameter-sd` (mm) and `confidence` (0..1) as functions over the polyline, one `sample value` per
//! point; a lateral stands within its parent and carries `parent-node`, the index of the parent's point nearest to its
//! first one; a root without a parent carries -1, since readers take the values as a list that runs like the roots (CPlantBox).
//! In a series of days `node_creation_time` (day) tells of each point when it was there first. Numbers are plain decimals, as the schema
//! asks.
//!
//! **Read**: that and what is met in practice, see [`read`].

mod read;
#[cfg(test)]
mod schema;
#[cfg(test)]
mod tests;

pub use read::{Reading, read};

use crate::error::{Error, Result};
use crate::roots::TracedRoot;
use quick_xml::escape::escape;
use std::fmt::Write;

/// Results hold no clock, so that equal inputs give equal files: their date is that of the profile.
pub const PROFILE_DATE: &str = "2026-01-01T00:00:00Z";

/// What the file says about itself.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// Time of writing as xs:dateTime, such as 2026-05-01T12:00:00Z.
    pub last_modified: String,
    /// The program and its version.
    pub software: String,
    /// Who made it.
    pub user: String,
    /// Key of the file in the study.
    pub file_key: String,
    /// Name and SHA-256 (hexadecimal) of the photograph the file points to.
    pub image: Option<(String, String)>,
    /// Its place in a series of days.
    pub sequence: Option<Sequence>,
}

/// A file's place in a series over time, in which a root has one id (the schema's `time-sequence`, `unified`).
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Name of the series.
    pub label: String,
    /// Place in it, from 0.
    pub index: usize,
    /// Of each root, in the order of the roots, when each of its points was there first, days since the first of the series.
    pub created_days: Vec<Vec<f64>>,
}

/// The content of an RSML file.
///
/// # Errors
/// Where there is no root, a root has fewer than two points, its lists differ in length, a number is not finite,
/// or a parent is missing or its own descendant.
pub fn write(roots: &[TracedRoot], about: &About) -> Result<String> {
    if roots.is_empty() {
        return Err(Error::failed("RSML needs one root at least").help("lower the thresholds of the extraction"));
    }
    let created = about.sequence.as_ref().map(|sequence| &sequence.created_days);
    for (n, root) in roots.iter().enumerate() {
        check(root, roots)?;
        let points = root.root.points_mm.len();
        if created.is_some_and(|of| of.get(n).is_none_or(|times| times.len() != points)) {
            return Err(Error::failed(format!("RSML: root {} has not a time for each point", root.root.id)));
        }
    }
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<rsml>\n  <metadata>\n");
    for (tag, value) in [
        ("version", "1"),
        ("unit", "mm"),
        ("resolution", "1"),
        ("last-modified", &about.last_modified),
        ("software", &about.software),
        ("user", &about.user),
        ("file-key", &about.file_key),
    ] {
        put(&mut out, format_args!("    <{tag}>{}</{tag}>\n", escape(value)));
    }
    out.push_str("    <property-definitions>\n");
    for (label, unit) in [("diameter", "mm"), ("diameter-sd", "mm"), ("confidence", "1")] {
        put(
            &mut out,
            format_args!(
                "      <property-definition><label>{label}</label><type>real</type><unit>{unit}</unit></property-definition>\n"
            ),
        );
    }
    if created.is_some() {
        out.push_str(
            "      <property-definition><label>node_creation_time</label><type>real</type><unit>day</unit></property-definition>\n",
        );
    }
    out.push_str("      <property-definition><label>parent-node</label><type>integer</type></property-definition>\n");
    out.push_str("      <property-definition><label>order</label><type>integer</type></property-definition>\n");
    out.push_str("    </property-definitions>\n");
    if let Some((name, sha256)) = &about.image {
        put(
            &mut out,
            format_args!(
                "    <image><name>{}</name><sha256>{}</sha256></image>\n",
                escape(name.as_str()),
                escape(sha256.as_str())
            ),
        );
    }
    if let Some(sequence) = &about.sequence {
        let label = escape(sequence.label.as_str());
        put(
            &mut out,
            format_args!(
                "    <time-sequence><label>{label}</label><index>{}</index><unified>true</unified></time-sequence>\n",
                sequence.index
            ),
        );
    }
    out.push_str("  </metadata>\n  <scene>\n    <plant id=\"plant-1\" label=\"plant-1\">\n");
    for root in roots.iter().filter(|r| r.root.parent < 0) {
        write_root(&mut out, root, None, roots, created, 3);
    }
    out.push_str("    </plant>\n  </scene>\n</rsml>\n");
    Ok(out)
}

/// Writing to a `String` cannot fail.
fn put(out: &mut String, arguments: std::fmt::Arguments<'_>) {
    let _ = out.write_fmt(arguments);
}

fn check(traced: &TracedRoot, roots: &[TracedRoot]) -> Result<()> {
    let root = &traced.root;
    let n = root.points_mm.len();
    let fault = if n < 2 {
        "has fewer than two points"
    } else if [root.radii_mm.len(), traced.radius_sd_mm.len(), traced.confidence.len()] != [n; 3] {
        "has lists of different lengths"
    } else if root
        .points_mm
        .iter()
        .flatten()
        .chain(&root.radii_mm)
        .chain(&traced.confidence)
        .chain(&traced.radius_sd_mm)
        .any(|x| !x.is_finite())
    {
        "holds a number that is not finite"
    } else {
        let mut at = root;
        let mut steps = 0;
        loop {
            if at.parent < 0 {
                return Ok(());
            }
            let Some(parent) = roots.iter().find(|r| r.root.id == at.parent) else {
                break "has a parent that is missing";
            };
            at = &parent.root;
            steps += 1;
            if steps > roots.len() {
                break "descends from itself";
            }
        }
    };
    Err(Error::failed(format!("RSML: root {} {fault}", root.id)))
}

fn write_root(
    out: &mut String,
    traced: &TracedRoot,
    parent: Option<&TracedRoot>,
    roots: &[TracedRoot],
    created: Option<&Vec<Vec<f64>>>,
    depth: usize,
) {
    let root = &traced.root;
    let pad = "  ".repeat(depth);
    put(out, format_args!("{pad}<root id=\"root-{0}\" label=\"root-{0}\">\n{pad}  <properties>\n", root.id));
    let node = parent.map_or(-1, |parent| nearest(parent, root.points_mm[0]) as i64);
    put(out, format_args!("{pad}    <parent-node>{node}</parent-node>\n"));
    put(out, format_args!("{pad}    <order>{}</order>\n{pad}  </properties>\n", root.order));
    put(out, format_args!("{pad}  <geometry>\n{pad}    <polyline>\n"));
    for [x, y, z] in root.points_mm.iter().map(|p| p.map(|v| rounded(v, 4))) {
        put(out, format_args!("{pad}      <point x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\n"));
    }
    put(out, format_args!("{pad}    </polyline>\n{pad}  </geometry>\n{pad}  <functions>\n"));
    let diameters: Vec<f64> = root.radii_mm.iter().map(|r| 2.0 * r).collect();
    let spreads: Vec<f64> = traced.radius_sd_mm.iter().map(|r| 2.0 * r).collect();
    let times = created.and_then(|of| of.get(roots.iter().position(|r| r.root.id == root.id)?));
    let functions = [("diameter", &diameters), ("diameter-sd", &spreads), ("confidence", &traced.confidence)];
    for (name, values) in functions.into_iter().chain(times.map(|times| ("node_creation_time", times))) {
        put(out, format_args!("{pad}    <function name=\"{name}\" domain=\"polyline\" origin=\"base\">\n"));
        for value in values {
            put(out, format_args!("{pad}      <sample value=\"{}\"/>\n", rounded(*value, 5)));
        }
        put(out, format_args!("{pad}    </function>\n"));
    }
    put(out, format_args!("{pad}  </functions>\n"));
    for child in roots.iter().filter(|r| r.root.parent == root.id) {
        write_root(out, child, Some(traced), roots, created, depth + 1);
    }
    put(out, format_args!("{pad}</root>\n"));
}

/// Index of the parent's point nearest to `p`.
fn nearest(parent: &TracedRoot, p: [f64; 3]) -> usize {
    let distance = |q: &[f64; 3]| (0..3).map(|d| (q[d] - p[d]).powi(2)).sum::<f64>();
    let points = &parent.root.points_mm;
    (0..points.len()).min_by(|&a, &b| distance(&points[a]).total_cmp(&distance(&points[b]))).unwrap_or(0)
}

/// Rounded to `digits` after the point; a tenth of a micrometre is finer than any photograph. Never -0.
fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale + 0.0
}
