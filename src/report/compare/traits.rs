//! The traits of all results, with how much each differs from the first's.

use super::{Shown, letter};
use crate::report::page::html::{escape, number, rounded};
use crate::roots::traits::{Trait, glossary};
use std::fmt::Write;

/// The section.
pub fn section(shown: &[Shown], t: &mut String) {
    t.push_str(
        "<section id=\"traits\" aria-labelledby=\"traits-title\">\n<h2 id=\"traits-title\">Traits of the plant</h2>\n\
         <p>Differences are against A, in the trait’s unit and as a share of A’s value. A dotted name tells its definition when pointed at or \
         reached with the Tab key.</p>\n<div class=\"scroll tall\" tabindex=\"0\" role=\"region\" aria-label=\"Table of traits\">\
         <table class=\"compared\"><thead><tr><th scope=\"col\">Trait</th><th scope=\"col\">Unit</th><th scope=\"col\" class=\"n\">A</th>",
    );
    for n in 1..shown.len() {
        let letter = letter(n);
        let _ = write!(
            t,
            "<th scope=\"col\" class=\"n\">{letter}</th><th scope=\"col\" class=\"n\">{letter} − A</th><th scope=\"col\" class=\"n\">%</th>"
        );
    }
    t.push_str("</tr></thead>\n");
    let columns = 3 * shown.len();
    for group in glossary::GROUPS {
        let mut rows = String::new();
        for name in names(shown) {
            let Some(meaning) = glossary::of_trait(name).filter(|m| m.group == group) else { continue };
            let id = format!("d-{}", name.replace('.', "-"));
            let _ = write!(
                rows,
                "<tr><th scope=\"row\"><button type=\"button\" class=\"term\" aria-describedby=\"{id}\">{}</button>\
                 <span role=\"tooltip\" id=\"{id}\">{} <code>{name}</code></span></th><td>{}</td>",
                escape(&meaning.label),
                escape(&meaning.definition),
                meaning.unit
            );
            let values: Vec<f64> = shown.iter().map(|s| value(&s.traits, name)).collect();
            for (n, x) in values.iter().enumerate() {
                let _ = write!(rows, "<td class=\"n\" data-trait=\"{name}\" data-result=\"{n}\">{}</td>", number(*x));
                if n > 0 {
                    let (apart, share) = difference(values[0], *x);
                    let _ = write!(rows, "<td class=\"n\">{apart}</td><td class=\"n\">{share}</td>");
                }
            }
            rows.push_str("</tr>\n");
        }
        if !rows.is_empty() {
            let _ = write!(
                t,
                "<tbody><tr><th scope=\"rowgroup\" colspan=\"{columns}\" class=\"group\">{group}</th></tr>\n{rows}</tbody>"
            );
        }
    }
    t.push_str("</table></div>\n</section>\n");
}

/// The names of all traits, in the order of the first result that has each.
fn names(shown: &[Shown]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for x in shown.iter().flat_map(|s| &s.traits) {
        if !names.contains(&x.name.as_str()) {
            names.push(&x.name);
        }
    }
    names
}

fn value(traits: &[Trait], name: &str) -> f64 {
    traits.iter().find(|x| x.name == name).map_or(f64::NAN, |x| x.value)
}

/// How much a value differs from the first's, and as a share of that, in percent; a dash where that says nothing.
fn difference(first: f64, value: f64) -> (String, String) {
    let apart = value - first;
    let signed = |x: f64, text: String| if x > 0.0 { format!("+{text}") } else { text };
    let share = if first == 0.0 { f64::NAN } else { 100.0 * apart / first.abs() };
    (signed(apart, rounded(apart, 3)), signed(share, rounded(share, 2)))
}

#[cfg(test)]
mod tests {
    use super::difference;

    #[test]
    fn differences_have_signs_and_shares_of_the_first() {
        let told = |a, b| {
            let (apart, share) = difference(a, b);
            format!("{apart} {share}")
        };
        assert_eq!(told(912.3, 900.0), "−12.3 −1.3");
        assert_eq!(told(-2.0, -1.0), "+1 +50");
        assert_eq!((told(3.0, 3.0), told(0.0, 4.0), told(f64::NAN, 1.0)), ("0 0".into(), "+4 –".into(), "– –".into()));
    }
}
