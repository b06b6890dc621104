//! How the result was made: the commands, every setting, the program's stages, the inputs.

use super::html::escape;
use crate::volume::Grid;
use std::collections::BTreeMap;
use std::fmt::Write;

/// How a result was made.
pub struct Provenance<'a> {
    /// The command that made it.
    pub made_by: &'a str,
    /// The command that makes it again.
    pub again: &'a str,
    /// The voxels.
    pub grid: &'a Grid,
    /// Every parameter (`section.key`) with its value as TOML.
    pub settings: &'a BTreeMap<String, String>,
    /// Each stage with its version.
    pub stages: &'a [(String, u32)],
    /// Each input file with its digest.
    pub inputs: &'a [(String, String)],
}

/// The section, its long lists folded.
pub fn section(p: &Provenance<'_>, t: &mut String) {
    let [depth, rows, columns] = p.grid.shape;
    let _ = write!(
        t,
        "<section id=\"provenance\" aria-labelledby=\"provenance-title\">\n<h2 id=\"provenance-title\">Provenance</h2>\n\
         <p>This page was made by</p>\n<pre tabindex=\"0\"><code>{}</code></pre>\n<p>The same again, compared node by node:</p>\n\
         <pre tabindex=\"0\"><code>{}</code></pre>\n<p>rootvox {}; grid of {columns} × {rows} × {depth} voxels of {} mm. \
         <code>study.lock</code> beside this page holds all of this with every digest.</p>\n",
        escape(p.made_by),
        escape(p.again),
        env!("CARGO_PKG_VERSION"),
        p.grid.spacing_mm
    );
    let _ = writeln!(t, "<details><summary>Settings ({} values, defaults written out)</summary>", p.settings.len());
    let mut sections: BTreeMap<&str, Vec<(&str, &str)>> = BTreeMap::new();
    for (name, value) in p.settings {
        let (section, key) = name.split_once('.').unwrap_or(("", name));
        sections.entry(section).or_default().push((key, value));
    }
    t.push_str("<div class=\"settings\">\n");
    for (section, values) in sections {
        let _ = writeln!(t, "<table><caption>[{}]</caption><tbody>", escape(section));
        for (key, value) in values {
            let _ = writeln!(t, "<tr><th scope=\"row\">{}</th><td>{}</td></tr>", escape(key), escape(value));
        }
        t.push_str("</tbody></table>\n");
    }
    t.push_str("</div></details>\n");
    list(t, "Stages and their versions", "stage", "version", p.stages.iter().map(|(s, v)| (s.clone(), v.to_string())));
    list(t, "Inputs and their digests", "input", "BLAKE3", p.inputs.iter().cloned());
    t.push_str(
        "<details><summary>Software in this page</summary><p>plotly.js, © 2012–2025 Plotly, Inc., MIT licence; its notices \
         stand in the page's source.</p></details>\n</section>\n",
    );
}

fn list(t: &mut String, title: &str, what: &str, value: &str, rows: impl ExactSizeIterator<Item = (String, String)>) {
    if rows.len() == 0 {
        return;
    }
    let _ = writeln!(
        t,
        "<details><summary>{title} ({})</summary><div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"{title}\">\
         <table><thead><tr><th scope=\"col\">{what}</th><th scope=\"col\">{value}</th></tr></thead><tbody>",
        rows.len()
    );
    for (name, value) in rows {
        let _ =
            writeln!(t, "<tr><th scope=\"row\">{}</th><td><code>{}</code></td></tr>", escape(&name), escape(&value));
    }
    t.push_str("</tbody></table></div></details>\n");
}
