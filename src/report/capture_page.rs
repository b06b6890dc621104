//! The check of a capture as a page: what was found, and each photograph small with what it shows.

use super::page::html::{escape, rounded};
use crate::calibration::check::{Checked, Level};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::fmt::Write;

/// A photograph on the page.
#[derive(Debug, Clone)]
pub struct Thumbnail {
    /// Its file's name.
    pub name: String,
    /// JPEG of it, small.
    pub jpeg: Vec<u8>,
}

const STYLE: &str = "body{font:15px/1.45 system-ui,sans-serif;margin:2em auto;max-width:76em;padding:0 1em;color:#222}\
    h1{font-size:1.4em}li{margin:.4em 0}.fault b{color:#b00020}.note b{color:#8a5a00}.good{color:#1b6e2c}\
    .all{display:grid;grid-template-columns:repeat(auto-fill,minmax(13em,1fr));gap:1em}figure{margin:0}\
    figure img{width:100%;border:3px solid #ccc}figure.fault img{border-color:#b00020}figure.note img{border-color:#d9a300}\
    figcaption{font-size:.85em}@media(prefers-color-scheme:dark){body{background:#181818;color:#ddd}}";

/// The page as HTML; with `refresh_s`, a browser loads it anew so often.
pub fn page(folder: &str, photographs: &[Thumbnail], checked: &Checked, refresh_s: Option<u32>) -> String {
    let mut out = String::from("<!doctype html><html lang=\"en\"><meta charset=\"utf-8\">");
    out.push_str("<meta name=\"viewport\" content=\"width=device-width\">");
    // The page asks for nothing from elsewhere.
    out.push_str("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'\">");
    if let Some(seconds) = refresh_s {
        let _ = write!(out, "<meta http-equiv=\"refresh\" content=\"{seconds}\">");
    }
    let _ = write!(
        out,
        "<title>{0}</title><style>{STYLE}</style><h1>{0}: {1} photographs</h1>",
        escape(folder),
        photographs.len()
    );
    let faults = checked.findings.iter().filter(|finding| finding.level == Level::Fault).count();
    match faults {
        0 => out.push_str("<p class=\"good\">The capture will do.</p>"),
        n => {
            let _ = write!(
                out,
                "<p class=\"fault\"><b>The capture will not do: {n} fault{}.</b></p>",
                if n == 1 { "" } else { "s" }
            );
        }
    }
    out.push_str("<ul>");
    for finding in &checked.findings {
        let (class, word) = match finding.level {
            Level::Fault => ("fault", "Fault"),
            Level::Note => ("note", "Note"),
        };
        let (text, remedy) = (escape(&finding.text), escape(&finding.remedy));
        let _ = write!(out, "<li class=\"{class}\"><b>{word}:</b> {text}<br>{remedy}");
    }
    out.push_str("</ul><div class=\"all\">");
    for (k, (photograph, look)) in photographs.iter().zip(&checked.looks).enumerate() {
        let worst = checked.findings.iter().filter(|f| f.photos.contains(&k)).map(|f| f.level).min();
        let class = match worst {
            Some(Level::Fault) => " class=\"fault\"",
            Some(Level::Note) => " class=\"note\"",
            None => "",
        };
        let (name, jpeg) = (escape(&photograph.name), STANDARD.encode(&photograph.jpeg));
        let turn = look.turn_deg.map_or("–".into(), |deg| format!("{deg:.0}°"));
        let moved = look.shift_px.map_or("–".into(), |[x, y]| format!("{} px", rounded(x.hypot(y), 2)));
        let _ = write!(
            out,
            "<figure{class}><img alt=\"{name}\" src=\"data:image/jpeg;base64,{jpeg}\"><figcaption>{name}<br>turned {turn}, blur {} px, \
             light {:.0} %, moved {moved}</figcaption></figure>",
            rounded(look.blur_px, 2),
            100.0 * look.gain
        );
    }
    out.push_str("</div><p>Turned: since the photograph before it, by the belts. Blur: standard deviation, px of a picture of 968 px width. \
        Light: of the room, against the other photographs. Moved: the room's picture, px of the photograph.</p></html>\n");
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::check::{Finding, Look};

    #[test]
    fn findings_and_photographs_are_shown() {
        let look = Look { blur_px: 0.25, gain: 1.02, shift_px: Some([3.0, 4.0]), turn_deg: None };
        let finding =
            Finding { level: Level::Fault, text: "`a<b>.jpg` is odd".into(), remedy: "again".into(), photos: vec![0] };
        let mut checked = Checked { findings: vec![finding], looks: vec![look] };
        let photographs = [Thumbnail { name: "a<b>.jpg".into(), jpeg: vec![1, 2, 3] }];
        let bad = page("here", &photographs, &checked, None);
        for part in
            ["1 fault.", "a&lt;b&gt;.jpg", "AQID", "moved 5 px", "light 102 %", "turned –", "<figure class=\"fault\">"]
        {
            assert!(bad.contains(part), "{part}: {bad}");
        }
        assert!(!bad.contains("refresh"));
        checked.findings.clear();
        assert!(page("here", &photographs, &checked, Some(2)).contains("will do."));
    }
}
