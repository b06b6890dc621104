//! What a person corrected, with whom and when, and what that did to the traits.

use super::html::{count, escape, number};
use crate::roots::correction::Outcome;
use crate::roots::traits::{Trait, glossary};
use std::fmt::Write;

/// The corrections of a result.
pub struct Corrected<'a> {
    /// What became of each.
    pub outcomes: &'a [Outcome],
    /// The traits of the roots as they were traced.
    pub traced: &'a [Trait],
}

/// The section; `traits` are those of the corrected roots.
pub fn section(corrected: &Corrected<'_>, traits: &[Trait], t: &mut String) {
    let applied = corrected.outcomes.iter().filter(|o| o.applied).count();
    let _ = writeln!(
        t,
        "<section id=\"corrections\" aria-labelledby=\"corrections-title\">\n<h2 id=\"corrections-title\">Corrections</h2>\n\
         <p>{} by a person, {applied} applied. What did not find its place changed nothing.</p>\n\
         <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Table of corrections\"><table><thead><tr>\
         <th scope=\"col\">Number</th><th scope=\"col\">Kind</th><th scope=\"col\">Applied</th><th scope=\"col\">Place, mm</th>\
         <th scope=\"col\">What was found there</th><th scope=\"col\">By</th><th scope=\"col\">When</th><th scope=\"col\">Note</th></tr></thead><tbody>",
        count(corrected.outcomes.len(), "correction", "corrections")
    );
    for (n, o) in corrected.outcomes.iter().enumerate() {
        let place = o.place_mm.map_or_else(|| "–".to_owned(), |p| p.map(|x| format!("{x:.1}")).join(", "));
        let _ = writeln!(
            t,
            "<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td><td>{place}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            n + 1,
            escape(&o.kind),
            if o.applied { "yes" } else { "<strong>no</strong>" },
            escape(&o.found),
            escape(&o.by),
            escape(&o.when),
            escape(&o.note)
        );
    }
    t.push_str("</tbody></table></div>\n");
    let changed: Vec<_> = traits
        .iter()
        .filter_map(|x| {
            let before = corrected.traced.iter().find(|b| b.name == x.name)?.value;
            let same = before == x.value || (before.is_nan() && x.value.is_nan());
            let meaning = glossary::of_trait(&x.name)?;
            (!same).then_some((meaning.label, meaning.unit, before, x.value))
        })
        .collect();
    if changed.is_empty() {
        t.push_str("<p>They change no trait.</p>\n</section>\n");
        return;
    }
    t.push_str(
        "<table><caption>Traits with and without them</caption><thead><tr><th scope=\"col\">Trait</th><th scope=\"col\" class=\"n\">As traced</th>\
         <th scope=\"col\" class=\"n\">Corrected</th><th scope=\"col\">Unit</th></tr></thead><tbody>\n",
    );
    for (label, unit, before, after) in changed {
        let _ = writeln!(
            t,
            "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"n\">{}</td><td>{unit}</td></tr>",
            escape(&label),
            number(before),
            number(after)
        );
    }
    t.push_str("</tbody></table>\n</section>\n");
}
