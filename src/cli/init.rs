//! `rootvox init`: the first study file of a capture.

use super::terminal::{talk, talkln};
use crate::error::{Error, Result};
use crate::formats::camera_file::COLMAP_FILES;
use crate::photo::Metadata;
use crate::photo::sequence::{Told, doubts};
use crate::study::draft::{CameraFile, Draft, DraftTank};
use crate::study::inputs::Frame;
use crate::study::photographs::{self, Found};
use crate::study::settings::Settings;
use clap::Args;
use rayon::prelude::*;
use std::fs::OpenOptions;
use std::io::{IsTerminal, Write};
use std::path::{Path, PathBuf};

/// Write a study file for a folder of photographs.
///
/// Looks at the photographs, takes what lies beside them (cameras, tank.json, roots.json), and asks for what must be measured
/// unless it is given. The file is commented and runs; nothing that exists is overwritten.
///
/// Examples:
///   rootvox init captures/plant-7
///   rootvox init captures/plant-7 --radius 90 --height 246.6 --wall 5 --water-level 12 --belt 0,28 --belt 214.6,246.6
#[derive(Args)]
#[command(verbatim_doc_comment, allow_negative_numbers = true)]
pub struct Init {
    /// Folder of the photographs, or with a folder `images` that holds them.
    folder: PathBuf,
    /// The study file to write; the folder's name with `.toml`, here, when absent.
    #[arg(long, short, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Outer radius of the tank, mm: its circumference over 6.2832.
    #[arg(long, value_name = "MM")]
    radius: Option<f64>,
    /// Outer height of the tank, mm.
    #[arg(long, value_name = "MM")]
    height: Option<f64>,
    /// Thickness of wall and floor, mm.
    #[arg(long, value_name = "MM")]
    wall: Option<f64>,
    /// Depth of the water surface below the rim, mm.
    #[arg(long, value_name = "MM")]
    water_level: Option<f64>,
    /// Refractive index of the wall: 1.49 for PMMA, 1.52 for common glass.
    #[arg(long, value_name = "N", default_value_t = 1.49)]
    wall_index: f64,
    /// An opaque band around the tank: where it begins and ends below the rim, mm. Once for each.
    #[arg(long, value_name = "FROM,TO", value_parser = belt)]
    belt: Vec<[f64; 2]>,
}

impl Init {
    /// Writes the study file.
    ///
    /// # Errors
    /// No photograph, a file that is there already, measures that are missing or make no tank.
    pub fn run(&self) -> Result<()> {
        let found = photographs::in_folder(&self.folder)?;
        let (told, focal_px): (Vec<Told>, Vec<Option<f64>>) =
            found.paths.par_iter().map(|path| tell(path)).collect::<Result<Vec<_>>>()?.into_iter().unzip();
        let cameras = cameras_in(&self.folder);
        let seen = describe(&told, focal_px[0]);
        talkln!("{}: {seen}", self.folder.display());
        found.note().into_iter().chain(doubts(&told, cameras.is_some())).for_each(|note| talkln!("note: {note}"));
        let out = self.out();
        let draft = Draft {
            name: stem(&out),
            dir: reached_from(&out, &self.folder)?,
            images: pattern(&self.folder, &found)?,
            seen,
            cameras,
            tank: self.tank()?,
            wall_index: self.wall_index,
            belts_mm: self.belt.clone(),
            truth: self.folder.join("roots.json").is_file().then(|| "roots.json".into()),
        };
        write_new(&out, &draft.text())?;
        if let Err(e) = Settings::load(&out, &[]) {
            let _ = std::fs::remove_file(&out);
            return Err(e);
        }
        talkln!("study file written: {}", out.display());
        talkln!("next: rootvox check {}, then rootvox run {}", self.folder.display(), out.display());
        Ok(())
    }

    fn out(&self) -> PathBuf {
        self.out.clone().unwrap_or_else(|| {
            let whole = self.folder.canonicalize().unwrap_or_else(|_| self.folder.clone());
            PathBuf::from(format!("{}.toml", stem(&whole)))
        })
    }

    /// The tank: as measured where anything is given, else the `tank.json` that is there, else asked for.
    fn tank(&self) -> Result<DraftTank> {
        let given = [self.radius, self.height, self.wall, self.water_level];
        if given.iter().all(Option::is_none) && self.folder.join("tank.json").is_file() {
            return Ok(DraftTank::File("tank.json".into()));
        }
        let asked = [
            ("--radius", "Outer radius of the tank, mm (its circumference over 6.2832)"),
            ("--height", "Outer height of the tank, mm"),
            ("--wall", "Thickness of the wall, mm"),
            ("--water-level", "Depth of the water surface below the rim, mm"),
        ];
        let missing: Vec<&str> =
            given.iter().zip(asked).filter(|(v, _)| v.is_none()).map(|(_, (flag, _))| flag).collect();
        if !missing.is_empty() && !std::io::stdin().is_terminal() {
            return Err(Error::usage(format!("the tank is not known: {} not given", missing.join(", ")))
                .help("measure the tank and give them in mm, or put a tank.json beside the photographs"));
        }
        let mut measured = [0.0; 4];
        for ((value, given), (_, question)) in measured.iter_mut().zip(given).zip(asked) {
            *value = given.map_or_else(|| ask(question), Ok)?;
        }
        Ok(DraftTank::Measured(measured))
    }
}

/// A number from the terminal; asked again until it is one.
fn ask(question: &str) -> Result<f64> {
    loop {
        talk!("{question}: ");
        let mut line = String::new();
        let read = std::io::stdin()
            .read_line(&mut line)
            .map_err(|e| Error::failed(format!("cannot read the terminal: {e}")))?;
        if read == 0 {
            return Err(Error::usage(format!("{question}: no answer")).help("give it as an option: see --help"));
        }
        match line.trim().replace(',', ".").parse() {
            Ok(value) => return Ok(value),
            Err(_) => talkln!("`{}` is no number", line.trim()),
        }
    }
}

fn belt(text: &str) -> std::result::Result<[f64; 2], String> {
    let numbers = text.split_once(',').map(|(a, b)| (a.trim().parse(), b.trim().parse()));
    match numbers {
        Some((Ok(from), Ok(to))) => Ok([from, to]),
        _ => Err("give two numbers with a comma between, such as 0,28".into()),
    }
}

/// What a photograph says, and its focal length, px, where the camera told it.
fn tell(path: &Path) -> Result<(Told, Option<f64>)> {
    let bytes = std::fs::read(path).map_err(|e| Error::io("read", path, e))?;
    let told = Told::of(&bytes, path)?;
    let (width, height) = told.head.size;
    let focal_px = Metadata::of(&bytes).and_then(|metadata| metadata.focal_px(width, height));
    Ok((told, focal_px))
}

/// What the photographs are, in a few words.
fn describe(told: &[Told], focal_px: Option<f64>) -> String {
    let head = &told[0].head;
    let mut text = format!("{} photographs of {} x {} px, {}", told.len(), head.size.0, head.size.1, head.format);
    text.extend(focal_px.map(|f| format!(", focal length about {f:.0} px")));
    let times = (told.iter().filter_map(|t| t.taken).min(), told.iter().filter_map(|t| t.taken).max());
    if let (Some(first), Some(last)) = times {
        text += &format!(", taken {first} to {last}");
    }
    text
}

/// Cameras beside the photographs, the surest first.
fn cameras_in(folder: &Path) -> Option<CameraFile> {
    let file = |path: &str, frame| folder.join(path).is_file().then(|| CameraFile { path: path.into(), frame });
    let model =
        |path: &&&str| COLMAP_FILES.iter().any(|names| names.iter().all(|n| folder.join(path).join(n).is_file()));
    file("cameras.json", Frame::Tank)
        .or_else(|| file("transforms.json", Frame::Free))
        .or_else(|| file("cameras.xml", Frame::Free))
        .or_else(|| {
            let path = ["sparse/0", "sparse", "colmap/sparse/0", "colmap"].iter().find(model)?;
            Some(CameraFile { path: (*path).into(), frame: Frame::Free })
        })
}

/// The pattern of the photographs that were found.
fn pattern(folder: &Path, found: &Found) -> Result<String> {
    let first = whole(&found.paths[0])?;
    let ending = first.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let below =
        first.parent().and_then(|parent| parent.strip_prefix(whole(folder).ok()?).ok()).unwrap_or(Path::new(""));
    Ok(below.join(format!("*.{ending}")).display().to_string())
}

fn whole(path: &Path) -> Result<PathBuf> {
    path.canonicalize().map_err(|e| Error::io("read", path, e))
}

/// The folder as the study file is to name it: relative where it lies beside or below the file.
fn reached_from(out: &Path, folder: &Path) -> Result<String> {
    let beside = match out.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => whole(parent)?,
        _ => whole(Path::new("."))?,
    };
    let folder = whole(folder)?;
    Ok(match folder.strip_prefix(&beside) {
        Ok(below) if below.as_os_str().is_empty() => ".".into(),
        Ok(below) => below.display().to_string(),
        Err(_) => folder.display().to_string(),
    })
}

fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "study".into(), |stem| stem.to_string_lossy().into_owned())
}

fn write_new(path: &Path, text: &str) -> Result<()> {
    let mut file = OpenOptions::new().write(true).create_new(true).open(path).map_err(|e| {
        let there = e.kind() == std::io::ErrorKind::AlreadyExists;
        let error = Error::io("write", path, e);
        if there { error.help("it exists and is not overwritten: name another with -o") } else { error }
    })?;
    file.write_all(text.as_bytes()).map_err(|e| Error::io("write", path, e))
}
