//! A trial on one page: what is odd, groups side by side, depth profiles, growth, and all plants in one scale. Figures are SVG and need
//! no script; each plant links to its own page. Equal values give equal bytes.

mod axes;
mod boxes;
mod film;
mod growth;
mod profiles;
mod sheet;

use crate::growth::compare::Effect;
use crate::optics::Tank;
use crate::report::page::html::{count, escape, number, rounded};
use crate::roots::RootSystem;
use crate::roots::traits::{Trait, glossary};
use std::fmt::Write;

pub use film::Film;
pub use growth::Curve;

/// A capture on the page.
pub struct Shown<'a> {
    /// The plant.
    pub plant: &'a str,
    /// The date as it is written; empty where there is none.
    pub date: &'a str,
    /// Its value of each group column.
    pub groups: &'a [String],
    /// Address of its own page, seen from this one.
    pub link: String,
    /// What is known of it, or why it failed.
    pub known: Result<Known<'a>, String>,
}

/// What is known of a capture.
pub struct Known<'a> {
    /// Its traits.
    pub traits: &'a [Trait],
    /// Depth profile: upper and lower border, mm under water, and root length within, mm.
    pub profile: Vec<[f64; 3]>,
    /// The roots.
    pub system: &'a RootSystem,
    /// The tank they stand in.
    pub tank: &'a Tank,
    /// What is unusual about it, each a sentence.
    pub odd: Vec<String>,
}

/// Two groups against each other.
pub struct Difference<'a> {
    /// The group column.
    pub column: &'a str,
    /// The date.
    pub date: &'a str,
    /// The trait.
    pub trait_name: &'a str,
    /// Names of the two.
    pub groups: [&'a str; 2],
    /// How much they differ.
    pub effect: Effect,
}

/// What the page shows.
pub struct Page<'a> {
    /// Name of the trial.
    pub name: &'a str,
    /// Group columns that compare plants: place among a capture's groups, name, values.
    pub columns: Vec<(usize, &'a str, Vec<&'a str>)>,
    /// The captures in the order of the list.
    pub captures: Vec<Shown<'a>>,
    /// All comparisons.
    pub differences: Vec<Difference<'a>>,
    /// Growth of each plant that was followed.
    pub curves: Vec<Curve<'a>>,
    /// The same plants, drawn day by day.
    pub films: Vec<Film<'a>>,
    /// What the days of plants say of themselves, each a sentence.
    pub notes: Vec<String>,
}

/// Traits that the figures show, where they are.
const SHOWN: [&str; 8] = [
    "total_root_length_mm",
    "elongation_mm_per_day",
    "elongation_order_1_mm_per_day",
    "root_count",
    "mean_diameter_mm",
    "depth_max_mm",
    "depth_d50_mm",
    "convex_hull_volume_mm3",
];

/// Colours of groups, told apart by most eyes.
const COLOURS: [&str; 8] = ["#0a6788", "#c4620f", "#3d7f4f", "#7a3e9d", "#8a7a00", "#a61e4d", "#3b5bdb", "#6b7278"];

const STYLE: &str = include_str!("../page/style.css");
const OWN_STYLE: &str = include_str!("style.css");

/// The page asks for nothing from elsewhere and runs nothing.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; form-action 'none'; base-uri 'none'";

impl Page<'_> {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let name = escape(self.name);
        let mut t = format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"rootvox {version}\">\n<title>{name} – trial</title>\n<style>\n{STYLE}{OWN_STYLE}</style>\n\
             </head>\n<body>\n",
            version = env!("CARGO_PKG_VERSION"),
        );
        self.header(&mut t);
        t.push_str("<main id=\"main\">\n");
        self.odd(&mut t);
        for (at, column, groups) in &self.columns {
            let _ = write!(
                t,
                "<section><h2>{0}</h2>\n<p>Each point is a plant; boxes span the middle half, the line is the median.</p>\n<div class=\"panels\">\n",
                escape(column)
            );
            for name in SHOWN {
                boxes::panel(self, *at, groups, name, &mut t);
            }
            t.push_str("</div>\n");
            self.table(column, &mut t);
            profiles::panel(self, *at, groups, &mut t);
            t.push_str("</section>\n");
        }
        growth::section(self, &mut t);
        sheet::section(self, &mut t);
        t.push_str(FILES);
        t.push_str("</main>\n</body>\n</html>\n");
        t
    }

    fn header(&self, t: &mut String) {
        let distinct = |of: &dyn Fn(&Shown<'_>) -> String| {
            self.captures.iter().map(of).collect::<std::collections::BTreeSet<_>>().len()
        };
        let failed = self.captures.iter().filter(|c| c.known.is_err()).count();
        let _ = write!(
            t,
            "<header>\n<h1>{}</h1>\n<p class=\"lead\">A trial, reconstructed by rootvox {}</p>\n<dl class=\"figures\">\n",
            escape(self.name),
            env!("CARGO_PKG_VERSION")
        );
        for (term, value) in [
            ("Plants", distinct(&|c| c.plant.to_owned())),
            ("Dates", distinct(&|c| c.date.to_owned())),
            ("Captures", self.captures.len()),
            ("Failed", failed),
        ] {
            let _ = writeln!(t, "<div><dt>{term}</dt><dd>{value}</dd></div>");
        }
        t.push_str("</dl>\n</header>\n");
    }

    /// Captures that failed or are unlike their group.
    fn odd(&self, t: &mut String) {
        t.push_str("<section><h2>Look at these first</h2>\n");
        let mut lines = Vec::new();
        for c in &self.captures {
            let told = |why: &str, word: &str, class: &str| {
                format!(
                    "<li class=\"{class}\"><span class=\"level\">{word}</span><span>{}: {}</span></li>\n",
                    c.linked(),
                    escape(why)
                )
            };
            match &c.known {
                Err(why) => lines.push((0, told(why, "Failed", "warning"))),
                Ok(known) => lines.extend(known.odd.iter().map(|why| (1, told(why, "Odd", "note")))),
            }
        }
        lines.extend(self.notes.iter().map(|note| {
            (2, format!("<li class=\"note\"><span class=\"level\">Days</span><span>{}</span></li>\n", escape(note)))
        }));
        lines.sort_by_key(|(rank, _)| *rank);
        if lines.is_empty() {
            t.push_str("<p>Every capture went through, and none is unlike the others of its group and date.</p>\n");
        } else {
            t.push_str("<ul class=\"findings\">\n");
            lines.iter().for_each(|(_, line)| t.push_str(line));
            t.push_str("</ul>\n");
        }
        t.push_str("</section>\n");
    }

    /// How much the groups of a column differ.
    fn table(&self, column: &str, t: &mut String) {
        let of_column = || self.differences.iter().filter(|d| d.column == column && SHOWN.contains(&d.trait_name));
        if of_column().next().is_none() {
            t.push_str("<p>Groups are compared where two have at least two plants each on one date.</p>\n");
            return;
        }
        t.push_str(
            "<div class=\"scroll\"><table class=\"effects\"><caption>Differences, with 95 % intervals (Welch, ratio of means); \
             effects.csv has all traits, analysis.R tests them</caption><thead><tr><th scope=\"col\">Trait</th><th scope=\"col\">Date</th>\
             <th scope=\"col\">Groups</th><th scope=\"col\" class=\"n\">Means</th><th scope=\"col\" class=\"n\">n</th>\
             <th scope=\"col\" class=\"n\">Change</th><th scope=\"col\" class=\"n\">95 % interval</th>\
             <th scope=\"col\" class=\"n\">Hedges’ g</th></tr></thead><tbody>\n",
        );
        for d in of_column() {
            let e = &d.effect;
            let percent = |x: f64| {
                let text = rounded(100.0 * x, 3);
                if x > 0.0 { format!("+{text} %") } else { format!("{text} %") }
            };
            let sure = e.interval[0] > 0.0 || e.interval[1] < 0.0;
            let _ = writeln!(
                t,
                "<tr{}><th scope=\"row\">{}</th><td>{}</td><td>{} against {}</td><td class=\"n\">{} / {}</td>\
                 <td class=\"n\">{} / {}</td><td class=\"n\">{}</td><td class=\"n\">{} to {}</td><td class=\"n\">{}</td></tr>",
                if sure { " class=\"sure\"" } else { "" },
                label(d.trait_name),
                escape(d.date),
                escape(d.groups[1]),
                escape(d.groups[0]),
                number(e.mean[1]),
                number(e.mean[0]),
                e.count[1],
                e.count[0],
                percent(e.change),
                percent(e.interval[0]),
                percent(e.interval[1]),
                rounded(e.hedges_g, 2)
            );
        }
        t.push_str("</tbody></table></div>\n");
    }

    /// The dates in the order of the list, each once.
    fn dates(&self) -> Vec<&str> {
        let mut dates: Vec<&str> = Vec::new();
        for c in &self.captures {
            if !dates.contains(&c.date) {
                dates.push(c.date);
            }
        }
        dates.sort_by(|a, b| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => a.total_cmp(&b),
            _ => a.cmp(b),
        });
        dates
    }
}

impl Shown<'_> {
    fn title(&self) -> String {
        let date = if self.date.is_empty() { String::new() } else { format!(", {}", self.date) };
        format!("plant {}{date}", self.plant)
    }

    fn linked(&self) -> String {
        let title = escape(&self.title());
        if self.known.is_ok() { format!("<a href=\"{}\">{title}</a>", escape(&self.link)) } else { title }
    }
}

impl Known<'_> {
    fn value(&self, name: &str) -> Option<f64> {
        self.traits.iter().find(|x| x.name == name).map(|x| x.value).filter(|x| x.is_finite())
    }
}

/// The trait's name for people, with its unit.
fn label(name: &str) -> String {
    match glossary::of_trait(name) {
        Some(meaning) if meaning.unit.is_empty() => escape(&meaning.label),
        Some(meaning) => format!("{}, {}", escape(&meaning.label), meaning.unit),
        None if name == "elongation_mm_per_day" => "Elongation of a root, mm per day".to_owned(),
        None if name == "elongation_order_1_mm_per_day" => "Elongation, order 1, mm per day".to_owned(),
        None => escape(name),
    }
}

const FILES: &str = "<section><h2>Files</h2>\n<p><code>traits.csv</code> (plant, date, groups, trait, value, spread), \
    <code>roots.csv</code>, <code>depth_profile.csv</code>, <code>quality.csv</code>, <code>effects.csv</code>, and \
    <code>growth.csv</code> and <code>days/</code> where plants were photographed on several days; <code>Rscript analysis.R</code> reads them.</p>\n</section>\n";

/// `3 plants`.
fn plants(n: usize) -> String {
    count(n, "plant", "plants")
}
