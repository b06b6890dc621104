//! Settings and corrections written into the study's files, and taken back.

use super::correct;
use super::fields::{Changes, Field};
use crate::error::{Error, Result};
use crate::roots::correction::Correction;
use crate::study::edit::edited;
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// A file that was written.
struct Written {
    path: PathBuf,
    /// None where it was not there.
    before: Option<String>,
    after: String,
}

/// What was written at once, and the changes of settings among it.
struct Step {
    files: Vec<Written>,
    changes: Option<Changes>,
}

/// Writes the files of one study.
pub struct Keeper {
    study: PathBuf,
    steps: Vec<Step>,
}

impl Keeper {
    /// Of the study file at `study`.
    pub fn new(study: &Path) -> Self {
        Self { study: study.to_owned(), steps: Vec::new() }
    }

    /// Writes changes of settings into the study file.
    ///
    /// # Errors
    /// Where the file cannot be read, changed or written.
    pub fn keep(&mut self, fields: &[Field], changes: &Changes) -> Result<()> {
        let values: Vec<(&str, String)> =
            changes.iter().map(|(name, value)| (name.as_str(), toml_text(fields, name, value))).collect();
        let study = self.study_with(values.iter().map(|(name, value)| (*name, value.as_str())))?;
        self.write(vec![study], Some(changes.clone()))
    }

    /// Adds a correction to `file`; `name` is what the study file is to call it by, where it does not name it yet.
    ///
    /// # Errors
    /// Where `file` holds a fault, or is there without being named, and as [`Self::keep`].
    pub fn correct(&mut self, file: &Path, correction: &Correction, name: Option<&str>) -> Result<()> {
        let before = text_of(file)?;
        let mut files = Vec::new();
        if let Some(name) = name {
            if before.is_some() {
                let message = format!("`{}` is there, but the study does not name it", file.display());
                return Err(Error::usage(message).help(format!(
                    "write [corrections] file = \"{name}\" into the study file, or take that file away"
                )));
            }
            files.push(self.study_with([("corrections.file", toml::Value::from(name).to_string().as_str())])?);
        }
        let text = correct::added(&file.display().to_string(), &before.unwrap_or_default(), correction)?;
        // The study names it once it is there.
        files.insert(0, (file.to_owned(), text));
        self.write(files, None)
    }

    /// Puts the texts back that were there before the last step, and hands back the changes of settings in it.
    ///
    /// # Errors
    /// Where nothing was written, a file has another text by now, or cannot be written.
    pub fn undo(&mut self) -> Result<Option<Changes>> {
        let Some(last) = self.steps.last() else {
            return Err(Error::usage("nothing was written that could be taken back"));
        };
        for Written { path, after, .. } in &last.files {
            if text_of(path)?.as_ref() != Some(after) {
                let message = format!("`{}` was changed by another program since", path.display());
                return Err(Error::usage(message).help("it is left as it is: change it by hand"));
            }
        }
        put_back(&last.files)?;
        Ok(self.steps.pop().and_then(|step| step.changes))
    }

    /// How often undo can be asked for.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The study file with settings as TOML.
    fn study_with<'a>(&self, settings: impl IntoIterator<Item = (&'a str, &'a str)>) -> Result<(PathBuf, String)> {
        let text = fs::read_to_string(&self.study).map_err(|e| Error::io("read", &self.study, e))?;
        Ok((self.study.clone(), edited(&self.study.display().to_string(), &text, settings)?))
    }

    fn write(&mut self, files: Vec<(PathBuf, String)>, changes: Option<Changes>) -> Result<()> {
        let mut step = Step { files: Vec::new(), changes };
        for (path, after) in files {
            let wrote = text_of(&path).and_then(|before| replace(&path, &after).map(|()| before));
            match wrote {
                Ok(before) => step.files.push(Written { path, before, after }),
                // All of them or none.
                Err(e) => return put_back(&step.files).and(Err(e)),
            }
        }
        self.steps.push(step);
        Ok(())
    }
}

/// Gives files the texts that they had, the last that was written first.
fn put_back(files: &[Written]) -> Result<()> {
    files.iter().rev().try_for_each(|Written { path, before, .. }| match before {
        Some(before) => replace(path, before),
        None => fs::remove_file(path).map_err(|e| Error::io("remove", path, e)),
    })
}

/// The text of a file; none where there is no file.
fn text_of(path: &Path) -> Result<Option<String>> {
    match fs::read_to_string(path) {
        Ok(text) => Ok(Some(text)),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) => Err(Error::io("read", path, e)),
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

/// Puts another text in a file's place at once, with the rights that it has; a new file is made where there is none.
fn replace(path: &Path, text: &str) -> Result<()> {
    let fault = |e: &dyn std::fmt::Display| Error::io("write", path, e);
    // What is behind a link stays behind it.
    let Ok(target) = fs::canonicalize(path) else {
        let mut fresh = fs::File::create_new(path).map_err(|e| fault(&e))?;
        return fresh.write_all(text.as_bytes()).and_then(|()| fresh.sync_all()).map_err(|e| fault(&e));
    };
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
        assert_eq!(keeper.undo().unwrap().as_ref(), Some(&two));
        assert_eq!(fs::read_to_string(&path).unwrap(), study);
        assert!(keeper.undo().is_err());
        keeper.keep(&fields, &two).unwrap();
        fs::write(&path, "# new\n").unwrap();
        assert!(keeper.undo().unwrap_err().message.contains("another program"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "# new\n");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_correction_is_written_named_by_the_study_and_taken_back() {
        let folder = tempfile::tempdir().unwrap();
        let (study, file) = (folder.path().join("a.toml"), folder.path().join("corrections.toml"));
        fs::write(&study, "# mine\n[grid]\nspacing = 1.0\n").unwrap();
        let mut keeper = Keeper::new(&study);
        let entry = json!({ "kind": "cut", "at": [1.0, 2.0, 3.0] });
        let cut = correct::read(entry.as_object().cloned().unwrap(), "2026-05-01", &[]).unwrap();
        keeper.correct(&file, &cut, Some("corrections.toml")).unwrap();
        assert!(keeper.correct(&file, &cut, Some("corrections.toml")).is_err(), "it is there without being named");
        keeper.correct(&file, &cut, None).unwrap();
        let text = fs::read_to_string(&study).unwrap();
        assert!(text.starts_with("# mine\n[grid]\n") && text.contains("file = \"corrections.toml\""), "{text}");
        assert_eq!(fs::read_to_string(&file).unwrap().matches("[[correction]]").count(), 2);
        assert_eq!(keeper.undo().unwrap(), None);
        assert_eq!(fs::read_to_string(&file).unwrap().matches("[[correction]]").count(), 1);
        keeper.undo().unwrap();
        assert!(!file.exists() && !fs::read_to_string(&study).unwrap().contains("corrections"));
        // Where the study cannot name it, it is not written.
        fs::write(&study, "corrections = 3\n").unwrap();
        assert!(keeper.correct(&file, &cut, Some("corrections.toml")).is_err() && !file.exists());
    }
}
