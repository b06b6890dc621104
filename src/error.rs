//! The one error type: what went wrong, where, and what to do about it.
//!
//! Every message names the place (file, view, key) and the cause; `help` names the remedy. The kind
//! decides the exit code. Several errors travel together through [`Error::many`].

use std::fmt;

/// Shorthand for results of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Sorts errors by who can mend them; decides the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The command line or the study file is wrong: exit code 2.
    Usage,
    /// Input data is unusable or the machine failed us: exit code 1.
    Failed,
    /// The user stopped the run: exit code 130.
    Interrupted,
}

/// A place in a text file, for errors that show the line they speak of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt {
    /// File name as the user gave it.
    pub file: String,
    /// Whole text of the file.
    pub text: String,
    /// Byte offset of the marked part.
    pub start: usize,
    /// Length in bytes of the marked part.
    pub len: usize,
}

/// An error with its place, cause and remedy.
#[derive(Debug, Clone)]
pub struct Error {
    /// Who can mend it.
    pub kind: Kind,
    /// What went wrong and where, one sentence without a final period.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
    /// The part of a text file that is wrong.
    pub excerpt: Option<Box<Excerpt>>,
    /// Further errors found in the same pass.
    pub others: Vec<Error>,
}

impl Error {
    /// An error of the command line or the study file (exit code 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Self::new(Kind::Usage, message)
    }

    /// An error of input data or of the machine (exit code 1).
    pub fn failed(message: impl Into<String>) -> Self {
        Self::new(Kind::Failed, message)
    }

    /// The run was stopped by the user (exit code 130).
    pub fn interrupted() -> Self {
        Self::new(Kind::Interrupted, "interrupted")
    }

    /// An error of reading or writing the file at `path`.
    pub fn io(what: &str, path: &std::path::Path, cause: impl fmt::Display) -> Self {
        let error = Self::failed(format!("cannot {what} `{}`: {cause}", path.display()));
        // Causes come through libraries as text.
        let is_full =
            ["No space left on device", "Disk quota exceeded"].iter().any(|full| error.message.contains(full));
        let make_room =
            "make room, for example with `rootvox cache gc --keep 20GiB`, and run again: finished nodes are kept";
        if is_full { error.help(make_room) } else { error }
    }

    fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into(), help: None, excerpt: None, others: Vec::new() }
    }

    /// Adds the remedy.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Marks the part of a text file that is wrong.
    #[must_use]
    pub fn excerpt(mut self, excerpt: Excerpt) -> Self {
        self.excerpt = Some(Box::new(excerpt));
        self
    }

    /// Puts the place before the message: `place: message`.
    #[must_use]
    pub fn at(mut self, place: impl fmt::Display) -> Self {
        self.message = format!("{place}: {}", self.message);
        self
    }

    /// All of `errors` as one; `Ok(())` where there are none.
    pub fn many(errors: Vec<Error>) -> Result<()> {
        let mut errors = errors.into_iter();
        match errors.next() {
            None => Ok(()),
            Some(mut first) => {
                first.others.extend(errors);
                Err(first)
            }
        }
    }

    /// The error and those that travel with it, one by one.
    pub fn apart(mut self) -> Vec<Self> {
        let others = std::mem::take(&mut self.others);
        std::iter::once(self).chain(others).collect()
    }

    /// 2 for usage, 1 for failure, 130 for an interruption.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Kind::Usage => 2,
            Kind::Failed => 1,
            Kind::Interrupted => 130,
        }
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)?;
        if let Some(help) = &self.help {
            write!(f, " ({help})")?;
        }
        for other in &self.others {
            write!(f, "; {other}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
