//! The quality of a result in words: what the program warned of first, then cameras, coverage, unseen water, roots,
//! diameters, repairs and, where it is known, the truth; each with what to do about it.
//!
//! The bounds of cameras and photographs are where docs/robustness.md begins to lose accuracy; docs/report.md lists them all.

mod roots;
mod sight;
mod truth;

pub use sight::directions;

use super::html::escape;
use crate::calibration::quality::Quality;
use crate::evaluation::{Band, CameraErrors, Score, Sight};
use crate::optics::View;
use crate::roots::RootSystem;
use crate::roots::traits::Trait;
use std::fmt::Write;

/// Where the cameras came from.
pub enum CameraOrigin<'a> {
    /// A file; nothing here checks them.
    File,
    /// The simulation, which knows them; perhaps misjudged on purpose.
    Simulated,
    /// The photographs.
    Found(&'a Quality),
}

/// What a stage warned of.
pub struct Warning {
    /// The stage.
    pub stage: String,
    /// Its node, or how many of them warned.
    pub place: String,
    /// What it said.
    pub text: String,
}

/// What the quality is told by.
pub struct Evidence<'a> {
    /// What stages warned of.
    pub warnings: &'a [Warning],
    /// Where the cameras came from.
    pub cameras: CameraOrigin<'a>,
    /// Errors of the cameras, where the capture was simulated.
    pub camera_errors: Option<&'a CameraErrors>,
    /// The cameras.
    pub views: &'a [View],
    /// What the views see of the water.
    pub sight: &'a [Sight],
    /// How right the result is by place, where the truth is known.
    pub bands: &'a [Band],
    /// The score of the root voxels, where the truth is known.
    pub score: Option<&'a Score>,
    /// The score of the traced roots, where the truth is known.
    pub roots_score: Option<&'a Score>,
}

/// How a finding weighs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// To be looked at before the numbers are used.
    Warning,
    /// Worth knowing.
    Note,
    /// As it should be.
    Good,
}

/// One thing that is said.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// How it weighs.
    pub level: Level,
    /// What it is about.
    pub topic: String,
    /// What is the case.
    pub text: String,
    /// What to do about it; empty for nothing.
    pub remedy: String,
}

impl Finding {
    /// A finding.
    pub fn new(level: Level, topic: &str, text: String, remedy: &str) -> Self {
        let remedy = if level == Level::Good { String::new() } else { remedy.to_owned() };
        Self { level, topic: topic.to_owned(), text, remedy }
    }
}

/// The level of a number that is good up to `good`, and worth a note up to `fair`.
fn level(value: f64, good: f64, fair: f64) -> Level {
    match value {
        v if v <= good => Level::Good,
        v if v <= fair => Level::Note,
        _ => Level::Warning,
    }
}

/// All findings, those that ask for something first.
pub fn findings(e: &Evidence<'_>, system: &RootSystem, traits: &[Trait]) -> Vec<Finding> {
    let warned = e.warnings.iter().map(|w| {
        let topic = if w.place.is_empty() { w.stage.clone() } else { w.place.clone() };
        Finding::new(Level::Warning, &topic, w.text.clone(), remedy(&w.stage))
    });
    let mut all: Vec<Finding> = warned.collect();
    all.push(sight::cameras(e));
    all.extend(sight::coverage(e.views));
    all.extend(sight::water(e.sight));
    all.extend(roots::all(system, traits));
    all.extend(truth::all(e));
    all.sort_by_key(|f| f.level);
    all
}

/// What to do about a stage's warning that does not say it itself.
fn remedy(stage: &str) -> &'static str {
    match stage {
        "background" => "Light the plant against a darker or paler room, so that roots stand out.",
        "pose" => "Look at calibration/ beside this page: the drawn outlines should lie on the tank's.",
        "sfm" | "sfm-known" | "sfm-mask" => {
            "Look at calibration/mask.png: it should show the printed belts and nothing that stands still. Take sharper or more photographs."
        }
        "corrections" => {
            "Look at the place in the 3D view, and name it anew in the file of corrections or take the entry out."
        }
        "traits" => "See the thresholds trace.low and trace.high.",
        _ => "",
    }
}

/// The section.
pub fn section(e: &Evidence<'_>, system: &RootSystem, traits: &[Trait], t: &mut String) {
    let findings = findings(e, system, traits);
    let of = |level| findings.iter().filter(|f| f.level == level).count();
    let verdict = match (of(Level::Warning), of(Level::Note)) {
        (0, 0) => "Nothing here asks for a second look.".to_owned(),
        (0, notes) => format!("No warnings; {} worth knowing.", super::html::count(notes, "thing", "things")),
        (n, _) => format!("{} to look at before these numbers are used.", super::html::count(n, "warning", "warnings")),
    };
    let _ = writeln!(
        t,
        "<section id=\"glance\" aria-labelledby=\"glance-title\">\n<h2 id=\"glance-title\">Quality at a glance</h2>\n<p>{verdict}</p>\n<ul class=\"findings\">"
    );
    for f in &findings {
        let (class, word) = match f.level {
            Level::Warning => ("warning", "Warning"),
            Level::Note => ("note", "Note"),
            Level::Good => ("good", "Good"),
        };
        let _ = write!(
            t,
            "<li class=\"{class}\"><span class=\"level\">{word}</span><div><strong>{}</strong> <span>{}</span>",
            escape(&f.topic),
            escape(&f.text)
        );
        if !f.remedy.is_empty() {
            let _ = write!(t, "<span class=\"remedy\">{}</span>", escape(&f.remedy));
        }
        t.push_str("</div></li>\n");
    }
    t.push_str("</ul>\n");
    sight::table(e, t);
    truth::table(e, t);
    t.push_str("</section>\n");
}

#[cfg(test)]
mod tests;
