//! Settings written into the study file, and taken back.

use super::fields::{Changes, Field};
use crate::error::{Error, Result};
use crate::study::edit::edited;
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What was written, for undo.
struct Written {
    before: String,
    after: String,
    changes: Changes,
}

/// Writes into one study file.
pub struct Keeper {
    study: PathBuf,
    written: Vec<Written>,
}

impl Keeper {
    /// Of the study file at `study`.
    pub fn new(study: &Path) -> Self {
        Self { study: study.to_owned(), written: Vec::new() }
    }

    /// Writes the changes.
    ///
    /// # Errors
    /// Where the file cannot be read, changed or written.
    pub fn keep(&mut self, fields: &[Field], changes: &Changes) -> Result<()> {
        let before = self.text()?;
        let values: Vec<(&str, String)> =
            changes.iter().map(|(name, value)| (name.as_str(), toml_text(fields, name, value))).collect();
        let name = self.study.display().to_string();
        let after = edited(&name, &before, values.iter().map(|(name, value)| (*name, value.as_str())))?;
        replace(&self.study, &after)?;
        self.written.push(Written { before, after, changes: changes.clone() });
        Ok(())
    }

    /// Puts the text back that was there before what was kept last, and hands back what was kept.
    ///
    /// # Errors
    /// Where nothing was kept, the file has another text by now, or it cannot be written.
    pub fn undo(&mut self) -> Result<Changes> {
        let Some(last) = self.written.last() else {
            return Err(Error::usage("nothing was kept that could be taken back"));
        };
        if self.text()? != last.after {
            let message = format!("`{}` was changed by another program since", self.study.display());
            return Err(Error::usage(message).help("it is left as it is: change it by hand"));
        }
        replace(&self.study, &last.before)?;
        Ok(self.written.pop().map(|written| written.changes).unwrap_or_default())
    }

    /// How often undo can be asked for.
    pub fn kept(&self) -> usize {
        self.written.len()
    }

    fn text(&self) -> Result<String> {
        fs::read_to_string(&self.study).map_err(|e| Error::io("read", &self.study, e))
    }
}

/// A value as the study file takes it: a number of a setting that has a point keeps one.
fn toml_text(fields: &[Field], name: &str, value: &Value) -> String {
    let is_float = fields.iter().any(|f| f.name == name && f.default.is_f64());
    match (value.as_f64(), value.as_str()) {
        (Some(number), _) if is_float => toml::Value::Float(number).to_string(),
        (_, Some(word)) => toml::Value::from(word).to_string(),
        _ => value.to_string(),
    }
}

/// Puts another text in a file's place at once, with the rights that it has.
fn replace(path: &Path, text: &str) -> Result<()> {
    let fault = |e: &dyn std::fmt::Display| Error::io("write", path, e);
    // What is behind a link stays behind it.
    let target = fs::canonicalize(path).map_err(|e| fault(&e))?;
    let folder = target.parent().unwrap_or(Path::new("."));
    let mut fresh = tempfile::NamedTempFile::new_in(folder).map_err(|e| fault(&e))?;
    fresh.write_all(text.as_bytes()).map_err(|e| fault(&e))?;
    fresh.as_file().sync_all().map_err(|e| fault(&e))?;
    let rights = fs::metadata(&target).map_err(|e| fault(&e))?.permissions();
    fs::set_permissions(fresh.path(), rights).map_err(|e| fault(&e))?;
    fresh.persist(&target).map(drop).map_err(|e| fault(&e.error))
}

#[cfg(test)]
mod tests {
    use super::super::fields::fields;
    use super::*;
    use serde_json::json;

    #[test]
    fn what_is_kept_can_be_taken_back_unless_somebody_wrote_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.toml");
        let study = "[extract] # mine\nhigh = 1.5 # by eye\n";
        fs::write(&path, study).unwrap();
        let (fields, mut keeper) = (fields().unwrap(), Keeper::new(&path));
        let two = Changes::from([("extract.high".into(), json!(2)), ("extract.unit".into(), json!("level"))]);
        keeper.keep(&fields, &two).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text, "[extract] # mine\nhigh = 2.0 # by eye\nunit = \"level\"\n");
        assert_eq!(keeper.undo().unwrap(), two);
        assert_eq!(fs::read_to_string(&path).unwrap(), study);
        assert!(keeper.undo().is_err());
        keeper.keep(&fields, &two).unwrap();
        fs::write(&path, "# new\n").unwrap();
        assert!(keeper.undo().unwrap_err().message.contains("another program"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "# new\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
