//! plotly.js as the `plotly` crate carries it.

use crate::error::{Error, Result};

/// How the crate writes it: a script of its own after MathJax, which the page does not need.
const BEGIN: &str = "/**\n* plotly.js v";

/// The text of plotly.js (MIT), with its notice of copyright.
///
/// # Errors
/// Where the crate carries it in another form.
pub fn plotly() -> Result<String> {
    let scripts = plotly::Plot::offline_js_sources();
    let from = scripts.find(BEGIN);
    let text = from.and_then(|from| Some(&scripts[from..from + scripts[from..].find("</script>")?]));
    text.map(|text| text.trim_end().to_owned())
        .ok_or_else(|| Error::failed("the plotly crate does not carry plotly.js as expected"))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_library_is_whole() {
        let text = super::plotly().unwrap();
        assert!(text.contains("Licensed under the MIT license") && text.len() > 4_000_000 && text.len() < 5_000_000);
        assert!(text.ends_with("return Plotly;\n}));"), "{}", &text[text.len() - 60..]);
        assert!(!text.contains("<script") || !text.contains("</script"));
    }
}
