//! The settings, and whatever else the results were made with, that differ between them.

use super::{Shown, letter};
use crate::report::page::html::escape;
use std::collections::BTreeSet;
use std::fmt::Write;

/// The section.
pub fn section(shown: &[Shown], t: &mut String) {
    t.push_str(
        "<section id=\"settings\" aria-labelledby=\"settings-title\">\n<h2 id=\"settings-title\">Settings that differ</h2>\n",
    );
    let names: BTreeSet<&String> = shown.iter().flat_map(|s| s.settings.keys()).collect();
    let differs = |name: &&&String| shown.iter().any(|s| s.settings.get(**name) != shown[0].settings.get(**name));
    let differing: Vec<&&String> = names.iter().filter(differs).collect();
    if differing.is_empty() {
        t.push_str(
            "<p>None: the results were made with equal settings, by equal stages, from equal files.</p>\n</section>\n",
        );
        return;
    }
    t.push_str(
        "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Settings that differ\"><table class=\"settings-table\"><thead><tr>\
         <th scope=\"col\">Setting</th>",
    );
    for n in 0..shown.len() {
        let _ = write!(t, "<th scope=\"col\">{}</th>", letter(n));
    }
    t.push_str("</tr></thead><tbody>\n");
    for name in differing {
        let _ = write!(t, "<tr><th scope=\"row\">{}</th>", escape(name));
        for s in shown {
            match s.settings.get(*name) {
                Some(value) => {
                    let _ = write!(t, "<td><code>{}</code></td>", escape(value));
                }
                None => t.push_str("<td>–</td>"),
            }
        }
        t.push_str("</tr>\n");
    }
    t.push_str("</tbody></table></div>\n</section>\n");
}
