//! Runs the COLMAP program in a folder of its own and reads what it leaves.

use super::colmap_photos::Photographs;
use crate::calibration::SparseModel;
use crate::error::{Error, Result};
use crate::flow::Progress;
use crate::formats::colmap::command::{Features, Places, arguments, pairs, version};
use crate::formats::colmap::{Model, binary, from_sparse, text, to_sparse};
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// What COLMAP is given.
pub(super) struct Job<'a> {
    /// The photographs.
    pub handed: &'a Photographs,
    /// Mask as PNG, white where features may be taken.
    pub mask_png: &'a [u8],
    /// Neighbours around the ring that are matched.
    pub neighbours: usize,
    /// How features are found.
    pub features: Features,
    /// Lens and poses, one per photograph in their order, where they are known: points alone are then looked for.
    pub known: Option<&'a SparseModel>,
}

/// Name and version of the program.
pub(super) fn program() -> Result<String> {
    Ok(version(&help("help")?).unwrap_or_else(|| "COLMAP of unknown version".to_owned()))
}

/// The largest sparse model and the program's version.
pub(super) fn run(job: &Job, progress: &Progress) -> Result<(SparseModel, String)> {
    let program = program()?;
    let folder = tempfile::tempdir().map_err(|e| Error::failed(format!("cannot make a temporary folder: {e}")))?;
    let at = |name: &str| folder.path().join(name);
    let (images, sparse, known) = (at("images"), at("sparse"), at("known"));
    // The mapper numbers the folders of its models itself, the triangulator wants one.
    let found = if job.known.is_some() { sparse.join("0") } else { sparse.clone() };
    for dir in [&images, &sparse, &known] {
        fs::create_dir(dir).map_err(|e| Error::io("make the folder", dir, e))?;
    }
    let write = |path: &Path, bytes: &[u8]| fs::write(path, bytes).map_err(|e| Error::io("write", path, e));
    // Names of our own: COLMAP's lists are split at blanks, and its order is by name.
    let photos = &job.handed.photos;
    let mut names = Vec::with_capacity(photos.len());
    for (k, photo) in photos.iter().enumerate() {
        let own = format!("{k:05}.{}", photo.ending);
        write(&images.join(&own), &photo.bytes)?;
        names.push(own);
    }
    let (database, mask, list) = (at("database.db"), at("mask.png"), at("pairs.txt"));
    write(&mask, job.mask_png)?;
    write(&list, pairs(&names, job.neighbours).as_bytes())?;
    if let Some(model) = job.known {
        fs::create_dir(&found).map_err(|e| Error::io("make the folder", &found, e))?;
        let mut model = SparseModel { points: Vec::new(), ..model.clone() };
        for (view, own) in model.views.iter_mut().zip(&names) {
            view.file.clone_from(own);
        }
        let (cameras, images, points) = text::write(&from_sparse(&model)?);
        for (name, text) in [("cameras.txt", cameras), ("images.txt", images), ("points3D.txt", points)] {
            write(&known.join(name), text.as_bytes())?;
        }
    }
    let places = Places {
        database: &database,
        images: &images,
        mask: &mask,
        pairs: &list,
        sparse: &found,
        known: job.known.map(|_| known.as_path()),
    };
    progress.total(places.steps().len() as u64);
    for step in places.steps() {
        let log = at(&format!("{step}.log"));
        execute(
            Command::new("colmap").args(arguments(step, &places, job.features, &job.handed.lens, &help(step)?)),
            step,
            &log,
            progress,
        )?;
        progress.advance(1);
    }
    let model = largest(&sparse)?;
    let mut model = to_sparse(&model, Some(&names))?.normalised();
    for view in &mut model.views {
        if let Some(k) = names.iter().position(|n| *n == view.file) {
            view.file.clone_from(&photos[k].name);
        }
    }
    Ok((model, program))
}

fn missing(e: &std::io::Error) -> Error {
    Error::failed(format!("cannot run the program `colmap`: {e}")).help(
        "cameras.source = \"sfm\" needs COLMAP: `apt install colmap`, `brew install colmap` or `conda install colmap`; \
         or give a camera file (cameras.source = \"file\")",
    )
}

/// What `colmap STEP -h` (or `colmap help`) prints.
fn help(step: &str) -> Result<String> {
    let mut command = Command::new("colmap");
    command.arg(step);
    if step != "help" {
        command.arg("-h");
    }
    let out = command.env("QT_QPA_PLATFORM", "offscreen").stdin(Stdio::null()).output().map_err(|e| missing(&e))?;
    Ok([out.stdout, out.stderr].iter().map(|b| String::from_utf8_lossy(b)).collect())
}

/// Runs to the end, or kills the program when the user asks to stop.
fn execute(command: &mut Command, step: &str, log: &Path, progress: &Progress) -> Result<()> {
    let out = File::create(log).map_err(|e| Error::io("write", log, e))?;
    let err = out.try_clone().map_err(|e| Error::io("write", log, e))?;
    let mut child = command
        .env("QT_QPA_PLATFORM", "offscreen")
        .stdin(Stdio::null())
        .stdout(out)
        .stderr(err)
        .spawn()
        .map_err(|e| missing(&e))?;
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status,
            Ok(None) => {}
            Err(e) => return Err(Error::failed(format!("cannot wait for `colmap {step}`: {e}"))),
        }
        if let Err(stop) = progress.check() {
            // Already gone is as good as killed.
            let _ = child.kill();
            let _ = child.wait();
            return Err(stop);
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    if status.success() {
        return Ok(());
    }
    let text = fs::read(log).map(|b| String::from_utf8_lossy(&b).into_owned()).unwrap_or_default();
    let last: Vec<&str> = text.lines().rev().filter(|l| !l.trim().is_empty()).take(5).collect();
    let last: Vec<&str> = last.into_iter().rev().collect();
    Err(Error::failed(format!("`colmap {step}` failed ({status}); it said last: {}", last.join(" | "))))
}

/// The model with the most images among the numbered folders that the mapper leaves.
fn largest(sparse: &Path) -> Result<Model> {
    let read = |path: &Path| fs::read(path).map_err(|e| Error::io("read", path, e));
    let mut best: Option<Model> = None;
    for k in 0.. {
        let dir = sparse.join(k.to_string());
        if !dir.is_dir() {
            break;
        }
        let model = binary::parse(
            &read(&dir.join("cameras.bin"))?,
            &read(&dir.join("images.bin"))?,
            &read(&dir.join("points3D.bin"))?,
        )?;
        if best.as_ref().is_none_or(|b| model.images.len() > b.images.len()) {
            best = Some(model);
        }
    }
    best.ok_or_else(|| {
        Error::failed("COLMAP found no common geometry in the photographs").help(
            "the belts need a random print of high contrast, sharp and well lit, and the mask must show them \
             (look at the sfm-mask in the results)",
        )
    })
}
