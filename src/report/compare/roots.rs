//! Which roots differ: per result but the first a table, whose rows show their roots in the views.

use super::{LEAST_COMMON, Page, Shown, letter};
use crate::growth::same_roots::{Comparison, Entry, Fate, LENGTH_MM, WITHIN_MM, length_mm};
use crate::report::page::html::{escape, number, percent};
use crate::roots::Root;
use std::fmt::Write;

/// What came of the roots of a result, one sentence.
pub fn told(other: &Comparison, letter: char) -> String {
    let n = |fate: Fate, is_of_first: Option<bool>| {
        let is = |e: &&Entry| e.fate == fate && is_of_first.is_none_or(|of| e.is_of_first == of);
        other.entries.iter().filter(is).count()
    };
    format!(
        "{letter} against A: {} roots the same in both, {} with another length, {} with another order, parent or direction; {} of A and {} of \
         {letter} are parts of another; {} in A only, {} in {letter} only; {} of A's length is in {letter}",
        n(Fate::Same, None),
        n(Fate::Length, None),
        n(Fate::Place, None),
        n(Fate::Part, Some(true)),
        n(Fate::Part, Some(false)),
        n(Fate::Only, Some(true)),
        n(Fate::Only, Some(false)),
        percent(other.common, 1.0)
    )
}

/// The section.
pub fn section(page: &Page<'_>, t: &mut String) {
    let _ = writeln!(
        t,
        "<section id=\"differ\" aria-labelledby=\"differ-title\">\n<h2 id=\"differ-title\">Which roots differ</h2>\n\
         <p>Two roots are one where most of the length of either runs along the other within {WITHIN_MM} mm; lengths that differ by \
         {LENGTH_MM} mm or less are taken as equal. A root’s number shows it in all views.</p>"
    );
    for (n, other) in page.others.iter().enumerate() {
        against(&page.shown[0], &page.shown[n + 1], n, other, t);
    }
    t.push_str("</section>\n");
}

fn against(first: &Shown, shown: &Shown, n: usize, other: &Comparison, t: &mut String) {
    let letter = letter(n + 1);
    let _ = writeln!(
        t,
        "<h3>{letter} ({}) against A ({})</h3>\n<p>{}.</p>",
        escape(&shown.name),
        escape(&first.name),
        escape(&told(other, letter))
    );
    if other.common < LEAST_COMMON {
        let _ = writeln!(
            t,
            "<ul class=\"findings\"><li class=\"warning\"><span class=\"level\">Warning</span><span>Hardly any root of A is found in {letter}. \
             <span class=\"remedy\">Are they of one plant, in one frame? Cameras that were found in other photographs, or anew, fix the frame but \
             for a turn about the tank’s axis.</span></span></li></ul>"
        );
    }
    let rows: Vec<(usize, &Entry)> = other.entries.iter().enumerate().filter(|(_, e)| e.fate != Fate::Same).collect();
    if rows.is_empty() {
        let _ = writeln!(t, "<p>No root differs.</p>");
        return;
    }
    let _ = writeln!(
        t,
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Roots that differ between A and {letter}\">\
         <table class=\"differing\" data-other=\"{n}\"><thead><tr><th scope=\"col\">Root</th><th scope=\"col\">What differs</th>\
         <th scope=\"col\" class=\"n\">Length in A, mm</th><th scope=\"col\" class=\"n\">in {letter}</th>\
         <th scope=\"col\" class=\"n\">Order in A</th><th scope=\"col\" class=\"n\">in {letter}</th>\
         <th scope=\"col\" class=\"n\">Parent in A</th><th scope=\"col\" class=\"n\">in {letter}</th></tr></thead><tbody>"
    );
    for (k, entry) in rows {
        row(k, entry, &first.roots, &shown.roots, letter, t);
    }
    t.push_str("</tbody></table></div>\n");
}

fn row(k: usize, entry: &Entry, first: &[Root], other: &[Root], letter: char, t: &mut String) {
    let (a, b) = (entry.first.map(|n| &first[n]), entry.other.map(|n| &other[n]));
    let id = |root: Option<&Root>| root.map_or(String::new(), |r| r.id.to_string());
    let (own, whole) = if entry.is_of_first { ('A', letter) } else { (letter, 'A') };
    let whole_id = id(if entry.is_of_first { b } else { a });
    let (what, class) = match entry.fate {
        Fate::Only => (format!("in {own} only"), "only"),
        Fate::Part => (format!("part of root {whole_id} in {whole}"), "part"),
        Fate::Place => (entry.differs.join(", "), "place"),
        Fate::Length | Fate::Same => (entry.differs.join(", "), "length"),
    };
    // Of a part, the whole it is of has numbers of its own elsewhere.
    let is_pair = entry.fate < Fate::Part;
    let (a, b) = (a.filter(|_| is_pair || entry.is_of_first), b.filter(|_| is_pair || !entry.is_of_first));
    let name = match (a, b) {
        (Some(a), Some(b)) => format!("A {}, {letter} {}", a.id, b.id),
        (Some(a), None) => format!("A {}", a.id),
        (None, b) => format!("{letter} {}", id(b)),
    };
    let _ = write!(
        t,
        "<tr data-entry=\"{k}\" data-fate=\"{class}\"><th scope=\"row\"><button type=\"button\" aria-pressed=\"false\" aria-label=\"Root {name}: show it in \
         all views\">{name}</button></th><td><span class=\"swatch\"></span>{what}</td>"
    );
    let parent = |root: &Root| if root.parent < 0 { "none".to_owned() } else { root.parent.to_string() };
    let cells: [&dyn Fn(&Root) -> String; 3] = [&|r| number(length_mm(r)), &|r| r.order.to_string(), &parent];
    for cell in cells {
        for root in [a, b] {
            let _ = write!(t, "<td class=\"n\">{}</td>", root.map_or("–".to_owned(), cell));
        }
    }
    t.push_str("</tr>\n");
}
