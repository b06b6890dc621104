//! The report's page with what the live one adds: settings beside the roots, slices, and the scripts that ask for changes.

use crate::error::Result;
use crate::report::page::{Live, Page};
use serde_json::Value;

const STYLE: &str = include_str!("page/live.css");
const PANEL: &str = include_str!("page/panel.html");
const SLICES: &str = include_str!("page/slices.html");

/// In the order in which they need each other.
const SCRIPTS: [&str; 9] = [
    include_str!("page/address.js"),
    include_str!("page/ask.js"),
    include_str!("page/voxels.js"),
    include_str!("page/fields.js"),
    include_str!("page/add.js"),
    include_str!("page/correct.js"),
    include_str!("page/follow.js"),
    include_str!("page/slices.js"),
    include_str!("page/live.js"),
];

/// Stands for a nonce until the page is asked for.
const NONCE: &str = "nonce-of-this-answer-3f6b1c";

/// What a page may do: run its own script, which has the nonce, and ask this server. plotly.js compiles its shaders' wrappers
/// at run time.
pub fn policy(nonce: &str) -> String {
    format!(
        "default-src 'none'; script-src 'nonce-{nonce}' 'unsafe-eval'; style-src 'unsafe-inline'; img-src 'self' data: blob:; \
         connect-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
    )
}

/// A page without its nonce.
pub struct Bare(String);

impl Bare {
    /// The page of a study, with data for the added scripts.
    ///
    /// # Errors
    /// As [`Page::live_html`].
    pub fn new(page: &Page<'_>, values: Value) -> Result<Self> {
        let live = Live { head: "", nonce: NONCE, style: STYLE, panel: PANEL, after_space: SLICES, scripts: &SCRIPTS };
        Ok(Self(page.live_html(&live, values)?))
    }

    /// The page with a nonce.
    pub fn with(&self, nonce: &str) -> String {
        self.0.replace(NONCE, nonce)
    }
}
