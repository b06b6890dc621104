//! A TOML study file, read section by section so that every fault is found and shown at its place.
//!
//! `--set a.b=value` lines are laid over the file before it is read; a value that is not TOML is taken
//! as a string, so that `--set photos.dir=../plant-7` needs no quotes.

use super::kept;
use super::plants::{List, value_of};
use crate::error::{Error, Excerpt, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// The texts a study is read from: the file and the overrides.
pub struct Sources {
    name: String,
    /// The file's text, then one line per override.
    text: String,
    file_len: usize,
    /// Each override as a TOML line, padded so that its spans are those of the line in `text`.
    lines: Vec<String>,
}

impl Sources {
    /// The file `name` with its text, and overrides of the form `a.b=value`.
    ///
    /// # Errors
    /// Where an override is not of that form.
    pub fn new(name: &str, text: &str, overrides: &[String]) -> Result<Self> {
        let mut sources =
            Self { name: name.to_owned(), text: text.to_owned(), file_len: text.len(), lines: Vec::new() };
        for setting in overrides {
            sources.add(setting)?;
        }
        Ok(sources)
    }

    /// The file at `path`, and overrides.
    ///
    /// # Errors
    /// Where the file cannot be read, and as [`Sources::new`].
    pub fn open(path: &std::path::Path, overrides: &[String]) -> Result<Self> {
        let text = std::fs::read_to_string(path).map_err(|e| {
            Error::usage(format!("cannot read the study file `{}`: {e}", path.display()))
                .help("a study is a TOML file; see pipelines/ for examples")
        })?;
        Self::new(&path.display().to_string(), &text, overrides)
    }

    fn add(&mut self, setting: &str) -> Result<()> {
        let bad = |why: &str| {
            Error::usage(format!("--set {setting}: {why}"))
                .help("write --set SECTION.KEY=VALUE, for example --set extract.high=0.03")
        };
        let (path, value) = setting.split_once('=').ok_or_else(|| bad("has no `=`"))?;
        let (path, value) = (path.trim(), value.trim());
        if path.split('.').count() < 2 || path.split('.').any(str::is_empty) {
            return Err(bad("the key names no section"));
        }
        self.text.push('\n');
        let pad = " ".repeat(self.text.len());
        let mut line = format!("{pad}{path} = {value}");
        if value.is_empty() || DeTable::parse(&line).is_err() {
            // TOML wants figures on both sides of the point, people do not.
            let bare = value.trim_start_matches(['+', '-']);
            let number = value.parse::<f64>().ok().filter(|_| bare.starts_with('.') || bare.ends_with('.'));
            line = number.map_or_else(
                || format!("{pad}{path} = {}", toml::Value::String(value.to_owned())),
                |number| format!("{pad}{path} = {number:?}"),
            );
            DeTable::parse(&line).map_err(|e| bad(e.message()))?;
        }
        self.text.push_str(line.trim_start());
        self.lines.push(line);
        Ok(())
    }
}

/// The parsed study; sections are taken out of it one by one.
#[derive(Clone)]
pub struct Document<'t> {
    sources: &'t Sources,
    /// The list of captures, whose cells stand behind the sources' text.
    list: Option<&'t List>,
    table: DeTable<'t>,
    faults: Vec<Error>,
    resolved: Resolved,
}

/// Every parameter, also those that the file leaves to their defaults: `section.key` with its value as TOML.
pub type Resolved = BTreeMap<String, String>;

impl<'t> Document<'t> {
    /// Parses the file and lays the overrides over it.
    ///
    /// # Errors
    /// Every place where the text is not TOML.
    pub fn parse(sources: &'t Sources) -> Result<Self> {
        let (table, errors) = DeTable::parse_recoverable(&sources.text[..sources.file_len]);
        let mut document =
            Self { sources, list: None, table: table.into_inner(), faults: Vec::new(), resolved: Resolved::new() };
        Error::many(errors.iter().map(|e| document.fault(e.message(), e.span())).collect())?;
        for line in &sources.lines {
            let (laid, _) = DeTable::parse_recoverable(line);
            merge(&mut document.table, laid.into_inner());
        }
        Ok(document)
    }

    /// Takes a section out and reads it as `T`; a missing section is an empty one. Faults are kept for
    /// [`Self::finish`]: keys at fault are left out and the rest is read, the defaults standing in.
    pub fn section<T: DeserializeOwned + Serialize + Default>(&mut self, key: &str) -> T {
        let given = self.take_table(key);
        let section = given.as_ref().map_or_else(T::default, |(span, table)| self.read(key, span, table.clone()));
        match note(&mut self.resolved, key, &section) {
            Ok(written) => {
                self.slipped(key, given.map(|(_, table)| kept::dropped(&table, &written)).unwrap_or_default())
            }
            Err(e) => self.faults.push(e),
        }
        section
    }

    fn read<T: DeserializeOwned + Default>(&mut self, key: &str, span: &Range<usize>, mut table: DeTable<'t>) -> T {
        // A value at fault is left out, for the next fault to be found and the rest to be read.
        let slips: Vec<_> = table.iter().map(|(name, value)| (name.clone(), kept::not_finite(value))).collect();
        for (name, slips) in slips.into_iter().filter(|(_, slips)| !slips.is_empty()) {
            table.remove(&name);
            self.slipped(key, slips);
        }
        loop {
            let value = Spanned::new(span.clone(), DeValue::Table(table.clone()));
            let e = match T::deserialize(ValueDeserializer::from(value)) {
                Ok(section) => return section,
                Err(e) => e,
            };
            self.faults.push(self.fault(&format!("[{key}] {}", e.message()), e.span()));
            let guilty = e.span().and_then(|at| {
                let holds = |s: Range<usize>| s.start <= at.start && at.end <= s.end;
                table.iter().find(|(k, v)| holds(k.span()) || holds(v.span())).map(|(k, _)| k.clone())
            });
            match guilty {
                Some(k) => drop(table.remove(&k)),
                None => return T::default(),
            }
        }
    }

    fn slipped(&mut self, key: &str, slips: Vec<kept::Slip>) {
        let faults: Vec<Error> =
            slips.into_iter().map(|(what, at)| self.fault(&format!("[{key}] {what}"), Some(at))).collect();
        self.faults.extend(faults);
    }

    /// Lays a table over the document.
    pub(super) fn lay(&mut self, table: DeTable<'t>) {
        merge(&mut self.table, table);
    }

    /// Gives the parameter `SECTION.KEY` a value; faults of it are shown at the value's own place.
    pub(super) fn set(&mut self, parameter: &'t str, value: Spanned<DeValue<'t>>) {
        let span = value.span();
        self.set_named(parameter, &span, value);
    }

    /// Lets faults be shown at the cells of the list.
    pub(super) fn know(&mut self, list: &'t List) {
        self.list = Some(list);
    }

    /// As [`Self::set`], with the value in one cell of the list and its name in another.
    pub(super) fn set_cell(&mut self, parameter: &'t str, name: usize, value: usize) {
        let Some(cell) = self.list.and_then(|list| list.cells.get(value)) else { return };
        let span = |cell: usize| {
            let at = self.sources.text.len() + 1 + cell;
            at..at + 1
        };
        let (name, value) = (span(name), value_of(cell, &span(value)));
        self.set_named(parameter, &name, value);
    }

    fn set_named(&mut self, parameter: &'t str, span: &Range<usize>, value: Spanned<DeValue<'t>>) {
        let nested = parameter.rsplit('.').fold(value, |inner, name| {
            let key = Spanned::new(span.clone(), name.into());
            Spanned::new(span.clone(), DeValue::Table([(key, inner)].into_iter().collect()))
        });
        if let DeValue::Table(table) = nested.into_inner() {
            self.lay(table);
        }
    }

    /// Leaves what a section said out of the values that counted.
    pub(super) fn forget(&mut self, section: &str) {
        self.resolved.retain(|name, _| name.split_once('.').is_none_or(|(of, _)| of != section));
    }

    /// Fails where a fault was found so far.
    ///
    /// # Errors
    /// All of them.
    pub(super) fn failed(&self) -> Result<()> {
        Error::many(self.faults.clone())
    }

    /// Whether the file has that section.
    pub fn has(&self, key: &str) -> bool {
        self.table.iter().any(|(k, _)| k.get_ref().as_ref() == key)
    }

    /// Notes a fault of a value that parsed but makes no sense.
    pub fn refuse(&mut self, error: Error) {
        self.faults.push(error);
    }

    /// Refuses the sections that nobody took; of those that were read, hands back every value.
    ///
    /// # Errors
    /// All faults found in the file, at once.
    pub fn finish(mut self, known: &[&str]) -> Result<Resolved> {
        let left: Vec<_> = self.table.iter().map(|(k, _)| (k.get_ref().to_string(), k.span())).collect();
        for (key, span) in left {
            let fault =
                self.fault(&format!("unknown section `{key}`, expected one of {}", known.join(", ")), Some(span));
            self.faults.push(fault);
        }
        Error::many(self.faults)?;
        Ok(self.resolved)
    }

    /// Takes a section out; a value that is no section is noted as a fault.
    pub(super) fn take_table(&mut self, key: &str) -> Option<(Range<usize>, DeTable<'t>)> {
        let found = self.table.iter().find(|(k, _)| k.get_ref().as_ref() == key).map(|(k, _)| k.clone())?;
        let value = self.table.remove(&found)?;
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(table) => Some((span, table)),
            other => {
                let fault = self
                    .fault(&format!("`{key}` is a section: expected a table, found {}", other.type_str()), Some(span));
                self.faults.push(fault);
                None
            }
        }
    }

    /// Whether what stands there comes from the command line, not from the file.
    pub(super) fn is_override(&self, span: &Range<usize>) -> bool {
        span.start >= self.sources.file_len && self.sources.text.len() > self.sources.file_len
    }

    /// The error `message` at a place of the file, or of the override that the place lies in.
    pub(super) fn fault(&self, message: &str, span: Option<Range<usize>>) -> Error {
        let Sources { name, text, file_len, .. } = self.sources;
        let Some(span) = span else { return Error::usage(format!("`{name}`: {message}")) };
        if let (Some(list), Some(cell)) = (self.list, span.start.checked_sub(text.len() + 1)) {
            return list.fault(cell, message);
        }
        let before = &text[..span.start.min(text.len())];
        if span.start >= *file_len && text.len() > *file_len {
            let line = before.rfind('\n').map_or(0, |i| i + 1);
            return Error::usage(format!("--set {}: {message}", text[line..].lines().next().unwrap_or_default()));
        }
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
        Error::usage(format!("`{name}` line {line}, column {column}: {message}")).excerpt(Excerpt {
            file: name.clone(),
            text: text[..*file_len].to_owned(),
            start: span.start,
            len: span.len().max(1),
        })
    }
}

/// Notes the values of a section as those that count, and hands them back as TOML.
///
/// # Errors
/// Where they have no form in TOML.
pub(super) fn note<T: Serialize>(resolved: &mut Resolved, key: &str, section: &T) -> Result<toml::Table> {
    let cannot = |e: &dyn std::fmt::Display| Error::failed(format!("[{key}] cannot be written as TOML: {e}"));
    // By way of text, where a number of single precision has its shortest form.
    let text = toml::to_string(section).map_err(|e| cannot(&e))?;
    let table = text.parse::<toml::Table>().map_err(|e| cannot(&e))?;
    let prefix = format!("{key}.");
    resolved.retain(|name, _| !name.starts_with(&prefix));
    flatten(key, table.clone(), resolved);
    Ok(table)
}

/// The values that counted, but those of some sections.
pub(super) fn written_but(resolved: &Resolved, sections: &[&str]) -> String {
    let counts = |name: &str| name.split_once('.').is_none_or(|(section, _)| !sections.contains(&section));
    let mut text = String::new();
    for (name, value) in resolved.iter().filter(|(name, _)| counts(name)) {
        text.extend([name.as_str(), " = ", value, "\n"]);
    }
    text
}

/// The values of nested tables under dotted names.
fn flatten(prefix: &str, table: toml::Table, into: &mut Resolved) {
    for (key, value) in table {
        let name = format!("{prefix}.{key}");
        match value {
            toml::Value::Table(inner) => flatten(&name, inner, into),
            value => drop(into.insert(name, value.to_string())),
        }
    }
}

fn merge<'t>(into: &mut DeTable<'t>, from: DeTable<'t>) {
    for (key, value) in from {
        let existing = into.iter().find(|(k, _)| k.get_ref() == key.get_ref()).map(|(k, _)| k.clone());
        let old = existing.and_then(|k| into.remove(&k));
        let span = value.span();
        let merged = match (old.map(Spanned::into_inner), value.into_inner()) {
            (Some(DeValue::Table(mut old)), DeValue::Table(new)) => {
                merge(&mut old, new);
                DeValue::Table(old)
            }
            (_, new) => new,
        };
        into.insert(key, Spanned::new(span, merged));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize, Serialize, Default, Debug, PartialEq)]
    #[serde(deny_unknown_fields, default)]
    struct Extract {
        low: f64,
        high: f64,
    }

    fn read(text: &str, set: &[&str]) -> (Extract, Result<Resolved>) {
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let sources = match Sources::new("study.toml", text, &set) {
            Ok(sources) => sources,
            Err(e) => return (Extract::default(), Err(e)),
        };
        match Document::parse(&sources) {
            Err(e) => (Extract::default(), Err(e)),
            Ok(mut d) => (d.section("extract"), d.finish(&["extract"])),
        }
    }

    #[test]
    fn overrides_win_over_the_file() {
        let (e, r) = read("[extract]\nlow = 0.1\nhigh = 0.2\n", &["extract.high=0.5"]);
        let resolved = r.unwrap();
        assert_eq!(e, Extract { low: 0.1, high: 0.5 });
        let resolved: Vec<_> = resolved.iter().map(|(k, v)| format!("{k} = {v}")).collect();
        assert_eq!(resolved, ["extract.high = 0.5", "extract.low = 0.1"]);
    }

    #[test]
    fn an_override_may_leave_out_figures_beside_the_point() {
        let (e, r) = read("", &["extract.low=-.25", "extract.high=3."]);
        r.unwrap();
        assert_eq!(e, Extract { low: -0.25, high: 3.0 });
    }

    #[test]
    fn several_faults_are_found_at_once_with_line_and_column() {
        let (_, r) = read("[extract]\nlow = nan\n", &["extract.high=1e400"]);
        let all: Vec<Error> = r.unwrap_err().apart();
        assert_eq!(all.len(), 2, "{all:?}");
        assert!(
            all[0].message.contains("line 2, column 7: [extract] `nan`") || all[1].message.contains("line 2, column 7")
        );
        let (_, r) = read("[extract]\nlow = \"x\"\nhihg = 0.2\n\n[extrakt]\n", &[]);
        let e = r.unwrap_err();
        let all: Vec<&str> = std::iter::once(&e).chain(&e.others).map(|e| e.message.as_str()).collect();
        assert_eq!(all.len(), 3, "{all:?}");
        assert!(all.iter().any(|m| m.contains("line 2") && m.contains("column 7")), "{all:?}");
        assert!(all.iter().any(|m| m.contains("line 3") && m.contains("hihg")), "{all:?}");
        assert!(all.iter().any(|m| m.contains("extrakt")), "{all:?}");
    }

    #[test]
    fn a_fault_in_an_override_names_the_override() {
        let (_, r) = read("[extract]\nlow = 1.0\n", &["extract.high=wide"]);
        let e = r.unwrap_err();
        assert!(e.message.contains("--set extract.high"), "{e}");
        assert!(read("", &["extract"]).1.is_err());
        assert!(read("", &["high=2"]).1.is_err());
    }
}
