//! `rootvox check`: whether a capture will do, told while it can be taken again.

use super::terminal::{dataln, talkln};
use crate::calibration::check::{Checked, Finding, Glance, Level, check};
use crate::error::{Error, Result};
use crate::formats::picture::jpeg;
use crate::photo::sequence::{Told, doubts};
use crate::photo::{self, shrink::shrink};
use crate::report::capture_page::{Thumbnail, page};
use crate::study::inputs::{CameraSource, Frame};
use crate::study::photographs;
use crate::study::settings::{Settings, Source};
use clap::Args;
use ndarray::s;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Longer side of a photograph on the page, px.
const THUMBNAIL_PX: usize = 320;
/// How often a watched folder is looked at.
const EVERY: Duration = Duration::from_millis(700);

/// Tell in seconds whether a capture will do: order and gaps of the ring, blur, light, a moved camera, belts, duplicates.
///
/// Findings go to stdout, the photographs with what each shows to a page. Exit code 0: it will do, perhaps with notes; 1: there is
/// a fault, take photographs again. With a study, its pattern and its source of cameras count: photographs whose cameras come
/// from a file in the tank's frame need no belts.
///
/// Examples:
///   rootvox check captures/plant-7
///   rootvox check captures/plant-7 plant-7.toml --page /tmp/check.html
///   rootvox check captures/plant-7 --watch      (while you photograph)
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Check {
    /// Folder of the photographs, or with a folder `images` that holds them.
    photos: PathBuf,
    /// The study file (TOML).
    study: Option<PathBuf>,
    /// The page to write.
    #[arg(long, value_name = "FILE", default_value = "check.html")]
    page: PathBuf,
    /// Check anew whenever a photograph is added, until Ctrl-C; the page loads itself anew.
    #[arg(long)]
    watch: bool,
}

/// What is kept of a photograph that was read.
struct Seen {
    stamp: Stamp,
    read: Result<Read>,
}

/// Size and time of a file: where they change it is read anew.
type Stamp = (u64, Option<SystemTime>);

/// What is to be checked.
#[derive(Default)]
struct Capture {
    paths: Vec<PathBuf>,
    /// Whether cameras are to be found in the photographs.
    needs_belts: bool,
    /// What was left out.
    note: Option<String>,
}

struct Read {
    glance: Glance,
    thumbnail: Vec<u8>,
    told: Told,
}

impl Check {
    /// Checks the photographs.
    ///
    /// # Errors
    /// Where the capture will not do, or there is no photograph.
    pub fn run(&self) -> Result<()> {
        let mut seen = BTreeMap::new();
        self.need_folder()?;
        if self.watch {
            self.keep_watch(&mut seen);
        }
        let Capture { paths, needs_belts, note } = self.photographs()?;
        let checked = self.look(&paths, needs_belts, &mut seen)?;
        checked.findings.iter().for_each(say);
        note.iter().for_each(|note| talkln!("note: {note}"));
        talkln!("page written: {}", self.page.display());
        if checked.will_do() {
            talkln!("{} photographs: the capture will do", paths.len());
            return Ok(());
        }
        let faults = checked.findings.iter().filter(|f| f.level == Level::Fault).count();
        let what = if faults == 1 { "1 fault".into() } else { format!("{faults} faults") };
        Err(Error::failed(format!("the capture will not do: {what} in {} photographs", paths.len()))
            .help("take photographs again as the findings say"))
    }

    fn need_folder(&self) -> Result<()> {
        if self.photos.is_dir() {
            return Ok(());
        }
        let there = if self.photos.exists() { "is no folder" } else { "is not there" };
        Err(Error::usage(format!("`{}` {there}", self.photos.display()))
            .help("name the folder of the photographs: rootvox check FOLDER"))
    }

    fn photographs(&self) -> Result<Capture> {
        let Some(study) = &self.study else {
            let found = photographs::in_folder(&self.photos)?;
            return Ok(Capture { note: found.note(), paths: found.paths, needs_belts: true });
        };
        let settings = Settings::load(study, &[format!("photos.dir={}", self.photos.display())])?;
        let needs_belts = settings.cameras.source == CameraSource::Sfm || settings.cameras.frame == Frame::Free;
        let note = settings.notes.into_iter().find(|note| note.starts_with("photos.images"));
        match settings.source {
            Source::Files(paths) => Ok(Capture { paths, needs_belts, note }),
            Source::Simulated(_) => Err(Error::usage(format!("`{}` simulates its photographs", study.display()))
                .help("check the photographs without it")),
        }
    }

    /// Checks anew at every change, until the process is ended.
    fn keep_watch(&self, seen: &mut BTreeMap<PathBuf, Seen>) -> ! {
        let mut said: Vec<Finding> = Vec::new();
        let mut before: Vec<(PathBuf, Stamp)> = Vec::new();
        let mut checked: Vec<(PathBuf, Stamp)> = Vec::new();
        let mut refused = String::new();
        talkln!("watching {} (Ctrl-C ends)", self.photos.display());
        loop {
            let Capture { paths, needs_belts, .. } = self.photographs().unwrap_or_else(|e| {
                // A folder is empty at first; a study at fault stays so.
                if refused != e.message {
                    talkln!("{e}");
                    refused = e.message;
                }
                Capture::default()
            });
            let now: Vec<(PathBuf, Stamp)> = paths.into_iter().map(|path| (path.clone(), stamp(&path))).collect();
            // A file that is still being written changes from one look to the next.
            if now == before && now != checked && !now.is_empty() {
                let paths: Vec<PathBuf> = now.iter().map(|(path, _)| path.clone()).collect();
                match self.look(&paths, needs_belts, seen) {
                    Ok(found) => {
                        talkln!("{} photographs: {} findings", paths.len(), found.findings.len());
                        found.findings.iter().filter(|f| !said.contains(f)).for_each(say);
                        said = found.findings;
                    }
                    Err(e) => talkln!("{e}"),
                }
                checked.clone_from(&now);
            }
            before = now;
            std::thread::sleep(EVERY);
        }
    }

    /// Reads what is new, checks all and writes the page.
    fn look(&self, paths: &[PathBuf], needs_belts: bool, seen: &mut BTreeMap<PathBuf, Seen>) -> Result<Checked> {
        seen.retain(|path, kept| paths.contains(path) && stamp(path) == kept.stamp);
        let fresh: Vec<&PathBuf> = paths.iter().filter(|path| !seen.contains_key(*path)).collect();
        let read: Vec<Seen> = fresh.par_iter().map(|path| Seen { stamp: stamp(path), read: read(path) }).collect();
        seen.extend(fresh.into_iter().cloned().zip(read));
        let (mut glances, mut names, mut told, mut thumbnails) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut unread = Vec::new();
        for path in paths {
            match seen.get(path).map(|kept| &kept.read) {
                Some(Ok(read)) => {
                    glances.push(read.glance.clone());
                    names.push(read.told.name.clone());
                    told.push(read.told.clone());
                    thumbnails.push(Thumbnail { name: read.told.name.clone(), jpeg: read.thumbnail.clone() });
                }
                Some(Err(e)) => unread.push(Finding {
                    level: Level::Fault,
                    text: e.message.clone(),
                    remedy: e.help.clone().unwrap_or_else(|| "copy it again".into()),
                    photos: Vec::new(),
                }),
                None => {}
            }
        }
        let mut checked = check(&glances, &names, needs_belts)?;
        unread.append(&mut checked.findings);
        checked.findings = unread;
        checked.findings.extend(doubts(&told, false).into_iter().map(|text| Finding {
            level: Level::Note,
            text,
            remedy: "look at the photographs named".into(),
            photos: Vec::new(),
        }));
        let html = page(&self.photos.display().to_string(), &thumbnails, &checked, self.watch.then_some(2));
        std::fs::write(&self.page, html).map_err(|e| Error::io("write", &self.page, e))?;
        Ok(checked)
    }
}

fn stamp(path: &Path) -> Stamp {
    std::fs::metadata(path).map_or((0, None), |file| (file.len(), file.modified().ok()))
}

fn read(path: &Path) -> Result<Read> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let told = Told::of(&bytes, path)?;
    let picture = photo::decode(&bytes, &path.display().to_string())?.into_picture();
    let glance = Glance::at(&picture);
    // Every so many pixels, and their means: a large photograph is not averaged whole.
    let step = (picture.dim().1.max(picture.dim().0) / (3 * THUMBNAIL_PX)).max(1);
    let picture = picture.slice(s![..;step, ..;step, ..]).to_owned();
    let thumbnail = jpeg(shrink(picture, THUMBNAIL_PX)?.view(), 80)?;
    Ok(Read { glance, thumbnail, told })
}

fn say(finding: &Finding) {
    let word = if finding.level == Level::Fault { "FAULT" } else { "note " };
    dataln!("{word}  {}\n       {}", finding.text, finding.remedy);
}
