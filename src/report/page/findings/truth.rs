//! The result against the truth, where it is known.

use super::{Evidence, Finding, level};
use crate::report::page::html::percent;
use std::fmt::Write;

/// F1 within 1 mm that is missing, at most.
const MISSING: [f64; 2] = [0.03, 0.10];

/// What is said of the score.
pub fn all(e: &Evidence<'_>) -> Option<Finding> {
    let score = e.roots_score.or(e.score)?;
    let at = score.at.iter().find(|a| a.tolerance_mm == 1.0).or(score.at.first())?;
    let mut text = format!(
        "Within {} mm {} of what was found is right, and {} of the true length was found (F1 {:.3}).",
        at.tolerance_mm,
        percent(at.precision, 1.0),
        percent(at.recall, 1.0),
        at.f1
    );
    if let Some(bias) = score.length_bias {
        let _ = write!(text, " Length {:+.1} %.", 100.0 * bias);
    }
    Some(Finding::new(
        level(1.0 - at.f1, MISSING[0], MISSING[1]),
        "Against the truth.",
        text,
        "docs/robustness.md of rootvox tells what costs how much; roots_score.json tells where: by diameter, depth, distance to the wall.",
    ))
}

/// The scores at every tolerance; folded.
pub fn table(e: &Evidence<'_>, t: &mut String) {
    if e.score.is_none() && e.roots_score.is_none() {
        return;
    }
    t.push_str(
        "<details><summary>Scores against the truth</summary>\n<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Scores against the truth\">\
         <table><thead><tr><th scope=\"col\">Of</th><th scope=\"col\" class=\"n\">Within</th><th scope=\"col\" class=\"n\">Precision</th>\
         <th scope=\"col\" class=\"n\">Recall</th><th scope=\"col\" class=\"n\">F1</th></tr></thead><tbody>\n",
    );
    for (what, score) in [("traced roots", e.roots_score), ("root voxels", e.score)] {
        for a in score.into_iter().flat_map(|s| &s.at) {
            let _ = writeln!(
                t,
                "<tr><th scope=\"row\">{what}</th><td class=\"n\">{} mm</td><td class=\"n\">{:.3}</td><td class=\"n\">{:.3}</td><td class=\"n\">{:.3}</td></tr>",
                a.tolerance_mm, a.precision, a.recall, a.f1
            );
        }
    }
    t.push_str("</tbody></table></div></details>\n");
}
