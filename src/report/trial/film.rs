//! Plants that grow: the roots of each day in turn, from the side, in the frame of the first day. A root keeps its colour as it keeps its
//! number. Styles alone move it: the page runs no script. Who wants no motion, and paper, have the last day.

use super::Page;
use super::sheet::{Scale, line};
use crate::optics::Tank;
use crate::report::page::html::{escape, rounded};
use crate::roots::{Root, ink};
use std::collections::BTreeSet;
use std::fmt::Write;

/// How long each day is shown, seconds.
const SHOWN_S: f64 = 1.4;

/// A plant over days.
pub struct Film<'a> {
    /// The plant.
    pub plant: &'a str,
    /// The tank it stands in.
    pub tank: &'a Tank,
    /// Of each day the days since the first, and the roots in one frame under common numbers.
    pub days: Vec<(f64, Vec<Root>)>,
}

/// The films; nothing where no plant was followed.
pub(super) fn all(page: &Page<'_>, t: &mut String) {
    if page.films.is_empty() {
        return;
    }
    let counts: BTreeSet<usize> = page.films.iter().map(|film| film.days.len()).collect();
    t.push_str("<style>\n");
    for n in counts {
        let (share, whole) = (100.0 / n as f64, SHOWN_S * n as f64);
        let _ = writeln!(
            t,
            "@keyframes film-{n} {{ 0% {{ visibility: visible }} {share:.3}% {{ visibility: hidden }} 100% {{ visibility: hidden }} }}\n\
             @media screen and (prefers-reduced-motion: no-preference) {{ .film-{n} g {{ animation: film-{n} {whole:.1}s step-end infinite }} }}"
        );
    }
    t.push_str(
        "</style>\n<p>Day by day, all in the frame of the first, in one scale; a root keeps its colour. <code>days/</code> has the same in 3D \
         (glTF, with this animation).</p>\n<div class=\"sheet films\">\n",
    );
    let scale = Scale::of(page.films.iter().map(|film| film.tank));
    for film in &page.films {
        let count = film.days.len();
        let label = format!("Plant {} over {count} days", escape(film.plant));
        t.push_str("<figure>");
        scale.open(film.tank, &format!("class=\"film-{count}\" aria-label=\"{label}\""), t);
        for (n, (day, roots)) in film.days.iter().enumerate() {
            // A day whose turn has come before the first moment: it waits for the rest of the round.
            let delay = SHOWN_S * (n as f64 - if n == 0 { 0.0 } else { count as f64 });
            let _ = write!(
                t,
                "<g style=\"animation-delay:{delay:.1}s\"><text x=\"{:.1}\" y=\"{:.1}\">day {}</text>",
                2.0 - film.tank.inner_radius_mm(),
                0.06 * scale.deep_mm,
                rounded(*day, 3)
            );
            for root in roots.iter().filter(|root| root.points_mm.len() > 1) {
                line(root, ink::by_root(root), t);
            }
            t.push_str("</g>");
        }
        let _ = writeln!(t, "</svg><figcaption>plant {}</figcaption></figure>", escape(film.plant));
    }
    t.push_str("</div>\n");
}
