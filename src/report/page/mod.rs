//! The report: a result on one self-contained HTML page that opens by double click, without a server or a network.
//!
//! What can be said in words and tables is HTML as it stands: it is read, searched and printed without any script. The roots as data
//! stand in it as JSON; plotly.js, embedded whole, draws the view in space and the plots from it, and `script/` ties them to
//! the tables and photographs. Nothing is loaded: the page's own policy forbids it. Equal values give equal bytes.

mod corrections;
mod data;
mod findings;
pub(in crate::report) mod html;
mod library;
mod photographs;
pub(in crate::report) mod projection;
mod provenance;
mod repaired;
pub(in crate::report) mod shell;
mod tables;

pub use corrections::Corrected;
pub use findings::{CameraOrigin, Evidence, Warning, directions};
pub use photographs::Photograph;
pub use provenance::Provenance;

use crate::error::Result;
use crate::formats::tables::Table;
use crate::optics::Tank;
use crate::roots::RootSystem;
use crate::roots::traits::Trait;
use html::escape;
use serde_json::Value;
use shell::{Shell, json_text};
use std::fmt::Write;

/// What the page shows.
pub struct Page<'a> {
    /// Name of the study.
    pub name: &'a str,
    /// The tank.
    pub tank: &'a Tank,
    /// The traced roots.
    pub system: &'a RootSystem,
    /// `traits.csv`.
    pub traits: &'a [Trait],
    /// `trait_spread.csv`, where the study has it.
    pub spread: Option<&'a Table>,
    /// `per_root.csv`.
    pub per_root: &'a Table,
    /// `depth_profile.csv`.
    pub profile: &'a Table,
    /// What the quality is told by.
    pub evidence: Evidence<'a>,
    /// The photographs in capture order.
    pub photographs: &'a [Photograph],
    /// What a person corrected.
    pub corrections: Option<Corrected<'a>>,
    /// How the result was made.
    pub provenance: Provenance<'a>,
}

/// Photographs that fit into the page at their best size.
const FULL_SIZE_PHOTOS: usize = 40;
/// Longer side of a photograph at most and at least, px.
const PHOTO_PX: [usize; 2] = [1280, 480];

/// Longer side of a photograph on a page with so many, px: of many each is smaller, so that the page stays light.
pub fn preview_px(photographs: usize) -> usize {
    let share = (FULL_SIZE_PHOTOS as f64 / photographs.max(FULL_SIZE_PHOTOS) as f64).sqrt();
    ((PHOTO_PX[0] as f64 * share) as usize).max(PHOTO_PX[1])
}

/// In the order in which they need each other, after those of every page.
const SCRIPTS: [&str; 7] = [
    include_str!("script/state.js"),
    include_str!("script/colour.js"),
    include_str!("script/space.js"),
    include_str!("script/plots.js"),
    include_str!("script/lines.js"),
    include_str!("script/root.js"),
    include_str!("script/viewer.js"),
];

/// Ties them together, last.
const MAIN: &str = include_str!("script/main.js");

/// What a program adds to the page that serves it: nothing of it is there in a report.
#[derive(Default)]
pub struct Live<'a> {
    /// At the end of the head.
    pub head: &'a str,
    /// Allows the page's own script under the policy it is served with.
    pub nonce: &'a str,
    /// After the page's own style sheet.
    pub style: &'a str,
    /// Beside the view in space.
    pub panel: &'a str,
    /// A section after it.
    pub after_space: &'a str,
    /// Before the last of the page's scripts, which calls `tieLive` where there is one.
    pub scripts: &'a [&'a str],
}

/// What changes of photographs with the roots, as JSON.
///
/// # Errors
/// Where a value cannot be written as JSON.
pub fn changing_views(photographs: &[Photograph]) -> Result<String> {
    json_text(&Value::from(data::views(photographs)))
}

impl Page<'_> {
    /// The page as HTML.
    ///
    /// # Errors
    /// Where plotly.js is not what is expected, or a value cannot be written as JSON.
    pub fn html(&self) -> Result<String> {
        self.write(&Live { head: &shell::offline(), ..Live::default() }, &data::of(self))
    }

    /// The page as HTML with what a program adds that serves it, and data for its scripts under `live`.
    ///
    /// # Errors
    /// As [`Self::html`].
    pub fn live_html(&self, live: &Live<'_>, values: Value) -> Result<String> {
        let mut data = data::of(self);
        data["live"] = values;
        self.write(live, &data)
    }

    fn write(&self, live: &Live<'_>, data: &Value) -> Result<String> {
        let room: usize = self.photographs.iter().map(|p| p.jpeg.len() / 3 * 4 + 2000).sum();
        let mut t = String::with_capacity(room + (1 << 20));
        self.header(&mut t);
        t.push_str("<main id=\"main\">\n");
        self.glance(&mut t);
        self.space(live.panel, &mut t);
        t.push_str(live.after_space);
        tables::traits(self.traits, self.spread, &mut t);
        self.corrected(&mut t);
        t.push_str(PLOTS);
        photographs::section(self.photographs, &mut t);
        tables::roots(self.per_root, &mut t);
        provenance::section(&self.provenance, &mut t);
        t.push_str("</main>\n");
        t.push_str(photographs::VIEWER);
        let scripts: Vec<&str> = SCRIPTS.iter().chain(live.scripts).chain([&MAIN]).copied().collect();
        let shell = Shell {
            title: &format!("{} – root system", self.name),
            head: live.head,
            nonce: live.nonce,
            style: live.style,
            scripts: &scripts,
        };
        shell.page(&t, data)
    }

    /// What changes of the page with the roots, as JSON: data for its scripts, and sections of HTML by their ids.
    ///
    /// # Errors
    /// Where a value cannot be written as JSON.
    pub fn changing(&self) -> Result<[String; 2]> {
        let part = |write: &dyn Fn(&mut String)| {
            let mut t = String::new();
            write(&mut t);
            t
        };
        let sections = serde_json::json!({
            "figures": part(&|t| self.figures(t)),
            "glance": part(&|t| self.glance(t)),
            "traits": part(&|t| tables::traits(self.traits, self.spread, t)),
            "corrections": part(&|t| self.corrected(t)),
            "roots": part(&|t| tables::roots(self.per_root, t)),
            "provenance": part(&|t| provenance::section(&self.provenance, t)),
            "sides": self.sides(),
            "outcomes": self.corrections.as_ref().map(|c| c.outcomes),
        });
        Ok([json_text(&data::of(self))?, json_text(&sections)?])
    }

    fn glance(&self, t: &mut String) {
        findings::section(&self.evidence, self.system, self.traits, t);
    }

    fn corrected(&self, t: &mut String) {
        if let Some(corrected) = &self.corrections {
            corrections::section(corrected, self.traits, t);
        }
    }

    /// Title, numbers, and the way about the page.
    fn header(&self, t: &mut String) {
        let _ = write!(
            t,
            "<header>\n<h1>{}</h1>\n<p class=\"lead\">Root system from {} photographs, reconstructed by rootvox {}</p>\n",
            escape(self.name),
            self.photographs.len(),
            env!("CARGO_PKG_VERSION")
        );
        self.figures(t);
        self.navigation(t);
    }

    /// The numbers that most ask for.
    fn figures(&self, t: &mut String) {
        let value = |name: &str| self.traits.iter().find(|x| x.name == name).map_or(f64::NAN, |x| x.value);
        t.push_str("<dl class=\"figures\" id=\"figures\">\n");
        let mut figure = |term: &str, value: String, unit: &str| {
            let _ = writeln!(t, "<div><dt>{term}</dt><dd>{value}<span class=\"unit\"> {unit}</span></dd></div>");
        };
        figure("Root length", html::number(value("total_root_length_mm") / 10.0), "cm");
        figure("Roots", html::number(value("root_count")), "");
        figure("Mean diameter", html::number(value("mean_diameter_mm")), "mm");
        figure("Root volume", html::number(value("root_volume_mm3") / 1000.0), "cm³");
        figure("Greatest depth", html::number(value("depth_max_mm")), "mm");
        if let Some(f1) = self.evidence.roots_score.and_then(|s| s.f1(1.0)) {
            figure("F1 within 1 mm", format!("{f1:.3}"), "");
        }
        t.push_str("</dl>\n");
    }

    /// The way about the page.
    fn navigation(&self, t: &mut String) {
        t.push_str("<nav aria-label=\"Sections\"><ul>\n");
        for (id, title) in [
            ("glance", "At a glance"),
            ("space", "Roots in 3D"),
            ("traits", "Traits"),
            ("plots", "Distributions"),
            ("photographs", "Photographs"),
            ("roots", "All roots"),
            ("provenance", "Provenance"),
        ] {
            let _ = writeln!(t, "<li><a href=\"#{id}\">{title}</a></li>");
        }
        t.push_str("</ul></nav>\n</header>\n");
    }

    /// The view in space with its panel, and what stands for it on paper.
    fn space(&self, panel: &str, t: &mut String) {
        let options: String = self
            .system
            .roots
            .iter()
            .map(|r| format!("<option value=\"{0}\">Root {0}, order {1}</option>", r.root.id, r.root.order))
            .collect();
        t.push_str(&SPACE.replace("{options}", &options).replace("{panel}", panel).replace("{sides}", &self.sides()));
    }

    fn sides(&self) -> String {
        projection::sides(self.tank, &self.system.plain())
    }
}

const SPACE: &str = include_str!("space.html");
const PLOTS: &str = include_str!("plots.html");

#[cfg(test)]
mod tests;
