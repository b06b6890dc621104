//! The traits of the plant as a table with definitions and uncertainty, and the place of the table of all roots.

use super::html::{count, escape, number, rounded};
use crate::formats::tables::Table;
use crate::roots::traits::{Trait, glossary};
use std::collections::BTreeMap;
use std::fmt::Write;

/// How a trait varies, from a row of `trait_spread.csv`.
struct Spread {
    sd: f64,
    low: f64,
    high: f64,
    draws: usize,
}

fn spreads(table: &Table) -> BTreeMap<&str, Spread> {
    let column = |name: &str| table.columns.iter().position(|c| c == name);
    let (sd, low, high, draws) = (column("sd"), column("quantile_2.5"), column("quantile_97.5"), column("draws"));
    let of = |row: &[String], at: Option<usize>| at.and_then(|n| row.get(n)?.parse().ok()).unwrap_or(f64::NAN);
    let rows = table.rows.iter().filter_map(|row| {
        let spread = Spread { sd: of(row, sd), low: of(row, low), high: of(row, high), draws: of(row, draws) as usize };
        Some((row.first()?.as_str(), spread))
    });
    rows.collect()
}

/// The section with the traits of the plant.
pub fn traits(traits: &[Trait], spread: Option<&Table>, t: &mut String) {
    let spreads = spread.map(spreads);
    t.push_str(
        "<section id=\"traits\" aria-labelledby=\"traits-title\">\n<h2 id=\"traits-title\">Traits of the plant</h2>\n\
         <p>A dotted name tells its definition when pointed at or reached with the Tab key. ",
    );
    match spreads.as_ref().and_then(|s| s.values().map(|s| s.draws).max()) {
        Some(draws) => {
            let _ = writeln!(
                t,
                "Uncertainty: standard deviation, and 2.5 to 97.5 % quantiles over reconstructions from {}.</p>",
                count(draws, "random half of the photographs", "random halves of the photographs")
            );
        }
        None => t.push_str(
            "How certain they are was not asked: <code>--set traits.resample=20</code> reconstructs from 20 random halves of the \
             photographs and tells it.</p>\n",
        ),
    }
    t.push_str("<div class=\"traits\">\n");
    for group in glossary::GROUPS {
        let of_group = || {
            traits.iter().filter_map(|x| {
                let meaning = glossary::of_trait(&x.name)?;
                (meaning.group == group).then_some((x, meaning))
            })
        };
        if of_group().next().is_none() {
            continue;
        }
        let _ = write!(
            t,
            "<table><caption>{group}</caption><thead><tr><th scope=\"col\">Trait</th><th scope=\"col\" class=\"n\">Value</th>"
        );
        t.push_str(if spreads.is_some() {
            "<th scope=\"col\" class=\"n\">± sd</th><th scope=\"col\" class=\"n\">95 % of the halves</th>"
        } else {
            ""
        });
        t.push_str("<th scope=\"col\">Unit</th></tr></thead><tbody>\n");
        for (x, meaning) in of_group() {
            let id = format!("d-{}", x.name.replace('.', "-"));
            let _ = write!(
                t,
                "<tr><th scope=\"row\"><button type=\"button\" class=\"term\" aria-describedby=\"{id}\">{}</button>\
                 <span role=\"tooltip\" id=\"{id}\">{} <code>{}</code></span></th><td class=\"n\" data-trait=\"{}\">{}</td>",
                escape(&meaning.label),
                escape(&meaning.definition),
                x.name,
                x.name,
                number(x.value)
            );
            if let Some(spreads) = &spreads {
                match spreads.get(x.name.as_str()) {
                    Some(s) if s.sd.is_finite() => {
                        let _ = write!(
                            t,
                            "<td class=\"n\">{}</td><td class=\"n\">{} to {}</td>",
                            rounded(s.sd, 2),
                            number(s.low),
                            number(s.high)
                        );
                    }
                    _ => t.push_str("<td class=\"n\">–</td><td class=\"n\">–</td>"),
                }
            }
            let _ = writeln!(t, "<td>{}</td></tr>", meaning.unit);
        }
        t.push_str("</tbody></table>\n");
    }
    t.push_str("</div>\n</section>\n");
}

/// The section with all roots; a row's button chooses its root.
pub fn roots(table: &Table, t: &mut String) {
    t.push_str(
        "<section id=\"roots\" aria-labelledby=\"roots-title\">\n<h2 id=\"roots-title\">All roots</h2>\n<p><code>per_root.csv</code>; \
         a heading sorts, a root's number shows it in the 3D view and on the photographs.</p>\n\
         <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Table of all roots\"><table id=\"root-table\"><thead><tr>",
    );
    let meanings: Vec<_> = table.columns.iter().map(|name| glossary::of_column(name)).collect();
    for (n, (name, meaning)) in table.columns.iter().zip(&meanings).enumerate() {
        let (label, unit) = meaning.as_ref().map_or((name.as_str(), ""), |m| (m.label.as_str(), m.unit));
        let _ = write!(
            t,
            "<th scope=\"col\"><button type=\"button\" data-column=\"{n}\" title=\"{}\">{}</button><span class=\"unit\">{}</span></th>",
            escape(meaning.as_ref().map_or("", |m| m.definition.as_str())),
            escape(label),
            if unit.is_empty() { String::new() } else { format!(" {unit}") }
        );
    }
    t.push_str("</tr></thead><tbody>\n");
    for row in &table.rows {
        let Some((id, rest)) = row.split_first() else { continue };
        let id = escape(id);
        let _ = write!(
            t,
            "<tr data-root=\"{id}\"><th scope=\"row\"><button type=\"button\" data-choose=\"{id}\" aria-label=\"Root {id}: show it\">{id}</button></th>"
        );
        for cell in rest {
            let text = cell.parse().map_or_else(|_| String::new(), number);
            let _ = write!(t, "<td data-value=\"{}\">{text}</td>", escape(cell));
        }
        t.push_str("</tr>\n");
    }
    t.push_str("</tbody></table></div>\n</section>\n");
}
