//! `rootvox compare`: results of one plant side by side.

use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::report::compare::{MOST, Page};
use crate::study::compare::{check_alike, of_folder};
use clap::Args;
use std::path::PathBuf;

/// Results of one plant on one page: linked 3D views, which roots differ, traits with differences, settings that differ.
///
/// The first result is what the others are held against. All must stand in one frame: made from one capture with other
/// settings, or from captures that a trial brought into one frame. The page is one file that needs no network.
///
/// Example:
///   rootvox compare results/plant-7 results/plant-7-strict -o compare.html
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Compare {
    /// Results folders, two to eight.
    #[arg(required = true, value_name = "RESULTS")]
    results: Vec<PathBuf>,
    /// The page to write.
    #[arg(long, short, value_name = "FILE", default_value = "compare.html")]
    out: PathBuf,
}

impl Compare {
    /// Writes the page.
    ///
    /// # Errors
    /// Where there are too few or too many results, a folder is none, the tanks differ, or the page cannot be written.
    pub fn run(&self) -> Result<()> {
        let count = self.results.len();
        if !(2..=MOST).contains(&count) {
            return Err(Error::usage(format!("{count} results are given, 2 to {MOST} can be compared"))
                .help("rootvox compare results/plant-7 results/plant-7-strict"));
        }
        let mut shown = Vec::new();
        let mut faults = Vec::new();
        for folder in &self.results {
            match of_folder(folder) {
                Ok(result) => shown.push(result),
                Err(fault) => faults.push(fault),
            }
        }
        Error::many(faults)?;
        check_alike(&shown)?;
        let names: Vec<&str> = shown.iter().map(|s| s.name.as_str()).collect();
        let title = if names.iter().all(|name| *name == names[0]) { names[0].to_owned() } else { names.join(", ") };
        let page = Page::new(&title, &shown);
        std::fs::write(&self.out, page.html()?).map_err(|e| Error::io("write", &self.out, e))?;
        page.told().for_each(|told| talkln!("{told}"));
        for letter in page.strangers() {
            talkln!("warning: hardly any root of A is found in {letter}: are they of one plant, in one frame?");
        }
        talkln!("look at: {}", self.out.display());
        Ok(())
    }
}
