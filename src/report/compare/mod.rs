//! Results of one plant side by side on one page: linked views in space, which roots differ, traits with differences, and the settings
//! that differ. The first result is what the others are held against.
//!
//! The page is made as the report is ([`super::page`]): one file that asks for nothing, whose words and tables are HTML as they stand.
//! Equal values give equal bytes.

mod data;
mod fates;
mod roots;
mod settings;
#[cfg(test)]
mod tests;
mod traits;

use super::page::html::{count, escape, number};
use super::page::projection::{FRONT, side};
use super::page::shell::{Shell, offline};
use crate::error::Result;
use crate::growth::same_roots::{Comparison, compare};
use crate::optics::Tank;
use crate::roots::Root;
use crate::roots::traits::Trait;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Results on one page at most: browsers bear so many views in space, and people so many columns.
pub const MOST: usize = 8;
/// Results of which so little of the first's length is found are hardly of one plant in one frame.
pub const LEAST_COMMON: f64 = 0.1;

/// A result that is shown.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Its name: of the study, or of the point of a sweep.
    pub name: String,
    /// Where it is from, or what is particular about it; may be empty.
    pub about: String,
    /// The tank.
    pub tank: Tank,
    /// The roots.
    pub roots: Vec<Root>,
    /// `traits.csv`.
    pub traits: Vec<Trait>,
    /// What it was made with: settings by their names with their values as TOML, and whatever else may differ.
    pub settings: BTreeMap<String, String>,
}

impl Shown {
    /// Its name with what it is: `quickstart (results/quickstart)`.
    pub fn title(&self) -> String {
        if self.about.is_empty() { self.name.clone() } else { format!("{} ({})", self.name, self.about) }
    }
}

/// Results, held against the first.
pub struct Page<'a> {
    title: &'a str,
    shown: &'a [Shown],
    /// Of each but the first.
    others: Vec<Comparison>,
}

const STYLE: &str = include_str!("compare.css");
const SPACE: &str = include_str!("space.html");
const SCRIPTS: [&str; 3] =
    [include_str!("script/views.js"), include_str!("script/rows.js"), include_str!("script/main.js")];

impl<'a> Page<'a> {
    /// Holds the results against the first of them; two to [`MOST`], in one frame.
    pub fn new(title: &'a str, shown: &'a [Shown]) -> Self {
        let (first, others) = (&shown[0], &shown[1..]);
        Self { title, shown, others: others.iter().map(|other| compare(&first.roots, &other.roots)).collect() }
    }

    /// What came of each result but the first, each one sentence.
    pub fn told(&self) -> impl Iterator<Item = String> + '_ {
        self.others.iter().enumerate().map(|(n, other)| roots::told(other, letter(n + 1)))
    }

    /// The letters of the results of which hardly anything is found in the first.
    pub fn strangers(&self) -> impl Iterator<Item = char> + '_ {
        self.others.iter().enumerate().filter(|(_, other)| other.common < LEAST_COMMON).map(|(n, _)| letter(n + 1))
    }

    /// The page as HTML.
    ///
    /// # Errors
    /// As `Shell::page`.
    pub fn html(&self) -> Result<String> {
        let mut t = String::new();
        self.header(&mut t);
        t.push_str("<main id=\"main\">\n");
        self.space(&mut t);
        roots::section(self, &mut t);
        traits::section(self.shown, &mut t);
        settings::section(self.shown, &mut t);
        t.push_str("</main>\n");
        let title = format!("{} – compared", self.title);
        let shell = Shell { title: &title, head: &offline(), nonce: "", style: STYLE, scripts: &SCRIPTS };
        shell.page(&t, &data::of(self))
    }

    fn header(&self, t: &mut String) {
        let _ = write!(
            t,
            "<header>\n<h1>{}</h1>\n<p class=\"lead\">{} of one plant, held against the first by rootvox {}</p>\n\
             <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"The results\"><table class=\"results\"><thead><tr>\
             <th scope=\"col\">Result</th><th scope=\"col\">Name</th><th scope=\"col\">What it is</th>\
             <th scope=\"col\" class=\"n\">Roots</th><th scope=\"col\" class=\"n\">Length, cm</th></tr></thead><tbody>\n",
            escape(self.title),
            count(self.shown.len(), "result", "results"),
            env!("CARGO_PKG_VERSION")
        );
        for (n, shown) in self.shown.iter().enumerate() {
            let length = shown.traits.iter().find(|x| x.name == "total_root_length_mm").map_or(f64::NAN, |x| x.value);
            let _ = writeln!(
                t,
                "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td class=\"n\">{}</td><td class=\"n\">{}</td></tr>",
                letter(n),
                escape(&shown.name),
                escape(&shown.about),
                shown.roots.len(),
                number(length / 10.0)
            );
        }
        t.push_str(
            "</tbody></table></div>\n<nav aria-label=\"Sections\"><ul>\n<li><a href=\"#space\">Roots in 3D</a></li>\n\
             <li><a href=\"#differ\">Which roots differ</a></li>\n<li><a href=\"#traits\">Traits</a></li>\n\
             <li><a href=\"#settings\">Settings</a></li>\n</ul></nav>\n</header>\n",
        );
    }

    /// The views in space, and a drawing of each for paper and for browsers without script or WebGL.
    fn space(&self, t: &mut String) {
        let (mut views, mut drawings) = (String::new(), String::new());
        let fates = fates::of_all(self);
        for (n, shown) in self.shown.iter().enumerate() {
            let (letter, name) = (letter(n), escape(&shown.name));
            let _ = writeln!(
                views,
                "<figure><figcaption><strong>{letter}</strong> {name}</figcaption><div class=\"view\" id=\"view-{n}\" tabindex=\"0\" \
                 role=\"application\" aria-roledescription=\"3D view\" aria-label=\"Roots of {letter} in 3D: arrow keys turn all views, plus \
                 and minus zoom, Home resets, comma and full stop choose the difference before and after\" \
                 aria-describedby=\"told\"></div></figure>"
            );
            let label = format!("Roots of {letter}, from the side");
            let colour = |root: usize| fates::colour(fates[n][root]);
            let svg = side(&shown.tank, &shown.roots, FRONT, &label, colour);
            let _ = writeln!(drawings, "<figure>{svg}<figcaption>{letter}: {name}, x and z</figcaption></figure>");
        }
        t.push_str(&SPACE.replace("{views}", &views).replace("{drawings}", &drawings));
    }
}

/// What a result is called on the page: A for the first.
fn letter(n: usize) -> char {
    char::from(b'A' + n as u8)
}
