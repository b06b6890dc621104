//! Shows errors to a person: message, the lines of the file they speak of, remedy.

use super::terminal::{talk, talkln};
use crate::error::{Error, Kind};
use miette::{Diagnostic, GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, SourceCode};
use std::fmt;
use std::io::IsTerminal;

/// One error as miette wants it.
struct Shown<'e> {
    error: &'e Error,
    source: Option<NamedSource<String>>,
}

impl fmt::Debug for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.error, f)
    }
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.error.message)
    }
}

impl std::error::Error for Shown<'_> {}

impl Diagnostic for Shown<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.error.help.as_ref().map(|h| Box::new(h) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|s| s as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let at = self.error.excerpt.as_ref()?;
        Some(Box::new(std::iter::once(LabeledSpan::new(None, at.start, at.len))))
    }
}

/// Writes the error, and those that were found with it, to stderr.
pub fn show(error: &Error) {
    let terminal = std::io::stderr().is_terminal();
    let theme = if terminal { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme).with_links(false).with_width(110);
    for error in std::iter::once(error).chain(&error.others) {
        if error.kind == Kind::Interrupted {
            talkln!("interrupted: finished nodes are kept, the same command goes on from there");
            continue;
        }
        let source = error.excerpt.as_ref().map(|e| NamedSource::new(&e.file, e.text.clone()));
        let mut text = String::new();
        match handler.render_report(&mut text, &Shown { error, source }) {
            Ok(()) => talk!("error: {}", text.trim_start_matches(['\n', ' ', '×'])),
            Err(fmt::Error) => talkln!("error: {error}"),
        }
    }
}
