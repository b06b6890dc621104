//! What every page with views in space is made of: its head and style, its data, plotly.js, and the scripts that tie them together.

use super::html::escape;
use super::library;
use crate::error::{Error, Result};
use serde_json::Value;
use std::fmt::Write;

/// Forbids every request; plotly.js compiles its shaders' wrappers at run time.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; \
                      img-src data: blob:; connect-src 'none'; form-action 'none'; base-uri 'none'";

const STYLE: &str = include_str!("style.css");

/// What plotly.js is told before it starts.
const BEFORE: &str = include_str!("script/before.js");

/// What every page runs first, in the order in which they need each other.
const SCRIPTS: [&str; 4] = [
    include_str!("script/base.js"),
    include_str!("script/library.js"),
    include_str!("script/tube.js"),
    include_str!("script/stage.js"),
];

/// A page but for its body and data.
pub struct Shell<'a> {
    /// Its title, as text.
    pub title: &'a str,
    /// At the beginning of the head.
    pub head: &'a str,
    /// Allows its script under the policy it is served with; empty where it is not served.
    pub nonce: &'a str,
    /// After the style sheet of all pages.
    pub style: &'a str,
    /// Its own scripts in the order in which they need each other.
    pub scripts: &'a [&'a str],
}

/// The head of a page that asks for nothing.
pub fn offline() -> String {
    format!("<meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n")
}

/// A value as JSON.
///
/// # Errors
/// Where it cannot be written.
pub fn json_text(value: &Value) -> Result<String> {
    serde_json::to_string(value).map_err(|e| Error::failed(format!("the page's data cannot be written as JSON: {e}")))
}

/// Rounded to so many decimals; never a negative zero.
pub fn to(value: f64, digits: i32) -> f64 {
    let scale = 10f64.powi(digits);
    (value * scale).round() / scale + 0.0
}

impl Shell<'_> {
    /// The page with what stands in its body, `#main` in it, and the data that its scripts read.
    ///
    /// # Errors
    /// Where plotly.js is not what is expected, or a value cannot be written as JSON.
    pub fn page(&self, body: &str, data: &Value) -> Result<String> {
        let library = library::plotly()?;
        let mut t = String::with_capacity(library.len() + body.len() + (1 << 20));
        let _ = write!(
            t,
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n{head}\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta name=\"generator\" content=\"rootvox {version}\">\n<title>{title}</title>\n\
             <link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n\
             <a class=\"skip\" href=\"#main\">Skip to the result</a>\n{body}",
            version = env!("CARGO_PKG_VERSION"),
            head = self.head,
            title = escape(self.title),
            style = self.style,
        );
        let nonce = if self.nonce.is_empty() { String::new() } else { format!(" nonce=\"{}\"", self.nonce) };
        // Inside a script only this could end it.
        let data = json_text(data)?.replace("</", "<\\/");
        let _ = writeln!(t, "<script type=\"application/json\" id=\"data\">{data}</script>");
        let _ = writeln!(
            t,
            "<script type=\"text/plain\" id=\"plotly\">\n{BEFORE}{library}\n</script>\n<script{nonce}>\n\"use strict\";\n(() => {{"
        );
        SCRIPTS.iter().chain(self.scripts).for_each(|script| t.push_str(script));
        t.push_str("})();\n</script>\n</body>\n</html>\n");
        Ok(t)
    }
}
