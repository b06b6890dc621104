//! How plants grew: total length of the followed roots over days.

use super::axes::{Axis, lines, numbers};
use super::{COLOURS, Page, film};
use crate::report::page::html::escape;
use std::fmt::Write;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 56.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 42.0;

/// A plant over days.
pub struct Curve<'a> {
    /// The plant.
    pub plant: &'a str,
    /// Its value of each group column.
    pub groups: &'a [String],
    /// Days since the first of the plant, and total root length, mm.
    pub points: Vec<[f64; 2]>,
}

/// The section; nothing where no plant was followed.
pub(super) fn section(page: &Page<'_>, t: &mut String) {
    if page.curves.is_empty() {
        return;
    }
    let points = || page.curves.iter().flat_map(|c| &c.points);
    let days = Axis::of(points().map(|p| p[0]).chain([0.0]));
    let lengths = Axis::of(points().map(|p| p[1]).chain([0.0]));
    let x = |day: f64| LEFT + days.share(day) * (WIDTH - LEFT - 16.0);
    let y = |length: f64| HEIGHT - BOTTOM - lengths.share(length) * (HEIGHT - TOP - BOTTOM);
    let _ = write!(
        t,
        "<section><h2>Growth</h2>\n<p>Roots are followed from day to day; <code>growth.csv</code> has every root and interval.</p>\n\
         <svg class=\"chart\" style=\"max-width:40rem\" role=\"img\" aria-label=\"Total root length over days\" viewBox=\"0 0 {WIDTH} {HEIGHT}\">\
         <text class=\"title\" x=\"8\" y=\"17\">Total root length, mm</text><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">days since the plant’s first capture</text>",
        WIDTH - 16.0,
        HEIGHT - 8.0
    );
    lines(&lengths, LEFT, WIDTH, y, t);
    numbers(&days, x, HEIGHT - BOTTOM + 16.0, t);
    for curve in &page.curves {
        let group = page.columns.first().and_then(|(at, _, groups)| {
            let own = curve.groups.get(*at)?;
            groups.iter().position(|g| g == own)
        });
        let colour = COLOURS[group.unwrap_or(0) % COLOURS.len()];
        let line: Vec<String> = curve.points.iter().map(|p| format!("{:.1} {:.1}", x(p[0]), y(p[1]))).collect();
        let _ = write!(
            t,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"><title>plant {}</title></path>",
            line.join("L"),
            escape(curve.plant)
        );
        for p in &curve.points {
            let _ = write!(t, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"2.6\" fill=\"{colour}\"/>", x(p[0]), y(p[1]));
        }
    }
    t.push_str("</svg>\n");
    if let Some((_, _, groups)) = page.columns.first() {
        t.push_str("<ul class=\"keys\">");
        for (g, group) in groups.iter().enumerate() {
            let _ = write!(t, "<li><i style=\"background:{}\"></i>{}</li>", COLOURS[g % COLOURS.len()], escape(group));
        }
        t.push_str("</ul>\n");
    }
    film::all(page, t);
    t.push_str("</section>\n");
}
