//! A study that travels: what it reads, what it gave and what it takes to repeat it, in one zip file.
//!
//! ```text
//! plant-7.rootvox.zip
//! ├── ro-crate-metadata.json      what this is (RO-Crate 1.1)
//! ├── study/plant-7.toml          the study file, for people
//! ├── input/…                     photographs, cameras, tank: what the study reads; without the photographs on demand
//! ├── results/plant-7/…           the results; their study.lock says what everything was, digests of photographs too
//! └── nodes/packed-v1/…           the nodes of the store, on demand
//! ```

use super::batch::{Batch, Study};
use super::crate_metadata::{self, Made};
use super::folder::LOCK;
use super::lock::Lock;
use super::settings::{Settings, Source};
use crate::error::{Error, Result};
use crate::store::{shared_files, tree};
use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// What goes into the file.
pub struct Parcel<'a> {
    /// The study file.
    pub study: &'a Path,
    /// What it asks for.
    pub batch: &'a Batch,
    /// Folder of the results.
    pub results: &'a Path,
    /// Whether the photographs go with it; their digests do in any case.
    pub photographs: bool,
    /// A folder of packed nodes to go with it.
    pub nodes: Option<&'a Path>,
}

/// Folder of what the studies read.
pub const INPUT: &str = "input";
/// Folder of the results.
pub const RESULTS: &str = "results";
/// Folder of the nodes.
pub const NODES: &str = "nodes";

impl Parcel<'_> {
    /// Writes the file at `to`, all of it or none; the files in it and their bytes.
    ///
    /// # Errors
    /// Where results are missing, something cannot be read, or the file cannot be written.
    pub fn write(&self, to: &Path) -> Result<(usize, u64)> {
        let cannot = |e: &dyn std::fmt::Display| Error::io("write", to, e);
        let beside = to.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let file = shared_files().tempfile_in(beside).map_err(|e| cannot(&e))?;
        let mut zip = Zip { to: ZipWriter::new(BufWriter::new(file)), files: 0, bytes: 0, inputs: BTreeSet::new() };
        let name = self.study.file_name().unwrap_or_default().to_string_lossy();
        zip.file(&format!("study/{name}"), self.study)?;
        let mut first = None;
        for study in &self.batch.studies {
            let lock = self.add(study, &mut zip)?;
            first.get_or_insert(lock);
        }
        if let Some(nodes) = self.nodes {
            zip.folder(NODES, nodes)?;
        }
        let Some(lock) = first else { return Err(Error::usage("the study file asks for nothing")) };
        let mut entries = vec![("study".to_owned(), true), (RESULTS.to_owned(), true)];
        entries.extend((!zip.inputs.is_empty()).then(|| (INPUT.to_owned(), true)));
        entries.extend(self.nodes.map(|_| (NODES.to_owned(), true)));
        zip.bytes(crate_metadata::NAME, crate_metadata::text(&lock, &entries, &self.made(&lock))?.as_bytes())?;
        let (files, bytes) = (zip.files, zip.bytes);
        let file = zip.to.finish().map_err(|e| cannot(&e))?.into_inner().map_err(|e| cannot(&e))?;
        file.as_file().sync_all().map_err(|e| cannot(&e))?;
        file.persist(to).map_err(|e| cannot(&e))?;
        Ok((files, bytes))
    }

    /// Adds a study's results and inputs.
    fn add(&self, study: &Study, zip: &mut Zip) -> Result<Lock> {
        let folder = self.results.join(&study.name);
        let mut lock = Lock::read(&folder.join(LOCK)).map_err(|e| e.help("`rootvox run` writes the results first"))?;
        let own = format!("{RESULTS}/{}", study.name);
        let settings = study.points.iter().filter_map(|point| Some(&point.planned.as_ref().ok()?.0));
        for settings in settings {
            self.add_inputs(study, settings, &mut lock, zip)?;
        }
        for (name, path) in plain_files(&folder)? {
            if name != LOCK {
                zip.file(&format!("{own}/{name}"), &path)?;
            }
        }
        zip.bytes(&format!("{own}/{LOCK}"), lock.text()?.as_bytes())?;
        Ok(lock)
    }

    /// Adds what the study reads, and lets the lock find it there.
    fn add_inputs(&self, study: &Study, settings: &Settings, lock: &mut Lock, zip: &mut Zip) -> Result<()> {
        let place = format!("{INPUT}/{}", study.name);
        let from_lock = |name: &str| toml::Value::from(format!("../../{name}")).to_string();
        if let Some(file) = &settings.corrections_file {
            let name = format!("{place}/{}", file.file_name().unwrap_or_default().to_string_lossy());
            zip.input(&name, file)?;
            lock.settings.insert("corrections.file".into(), from_lock(&name));
        }
        let Source::Files(photographs) = &settings.source else { return Ok(()) };
        lock.settings.insert("photos.dir".into(), from_lock(&place));
        if let Some(point) = lock.points.iter().find(|point| point.settings.contains_key("photos.dir")) {
            return Err(Error::usage(format!("point {} of the sweep has photographs of its own", point.point))
                .help("pack studies of one capture each"));
        }
        let reached = self.batch.graph.upstream(&study.targets());
        let paths = self.batch.graph.nodes().filter(|n| reached[n.index()]).filter_map(|n| self.batch.graph.path(n));
        // The lock holds the tank; its file is for people.
        let tank = Some(settings.input_dir.join("tank.json")).filter(|path| path.is_file());
        for path in paths.map(Path::to_owned).chain(tank) {
            let is_photograph = photographs.contains(&path);
            if settings.corrections_file.as_ref() == Some(&path) || (is_photograph && !self.photographs) {
                continue;
            }
            let whole = |path: &Path| std::path::absolute(path).map_err(|e| Error::io("find", path, e));
            let (file, capture) = (whole(&path)?, whole(&settings.input_dir)?);
            let inside = file.strip_prefix(&capture).map_err(|_| {
                Error::usage(format!("`{}` lies outside of the capture's folder", path.display()))
                    .help("put what the study reads into the folder that photos.dir names")
            })?;
            let inside: Vec<_> = inside.components().map(|part| part.as_os_str().to_string_lossy()).collect();
            zip.input(&format!("{place}/{}", inside.join("/")), &path)?;
        }
        Ok(())
    }

    /// Time and machine of the results, from their own metadata.
    fn made(&self, lock: &Lock) -> Made {
        let page = fs::read(self.results.join(&lock.study).join(crate_metadata::NAME)).unwrap_or_default();
        crate_metadata::made(&page)
    }
}

/// A zip file being written.
struct Zip {
    to: ZipWriter<BufWriter<tempfile::NamedTempFile>>,
    files: usize,
    bytes: u64,
    /// Names of what the studies read.
    inputs: BTreeSet<String>,
}

impl Zip {
    fn begin(&mut self, name: &str) -> Result<()> {
        let ending = Path::new(name).extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        let is_packed = ["jpg", "jpeg", "png", "webp", "tar", "glb"].contains(&&*ending) || name.contains(".zarr/");
        let method = if is_packed { CompressionMethod::Stored } else { CompressionMethod::Deflated };
        let options = SimpleFileOptions::default().compression_method(method).large_file(true).unix_permissions(0o644);
        self.files += 1;
        self.to.start_file(name, options).map_err(|e| Error::failed(format!("cannot pack `{name}`: {e}")))
    }

    fn file(&mut self, name: &str, path: &Path) -> Result<()> {
        self.begin(name)?;
        let mut file = File::open(path).map_err(|e| Error::io("read", path, e))?;
        self.bytes += std::io::copy(&mut file, &mut self.to).map_err(|e| Error::io("pack", path, e))?;
        Ok(())
    }

    /// A file that a study reads, where it is not there yet.
    fn input(&mut self, name: &str, path: &Path) -> Result<()> {
        if self.inputs.insert(name.to_owned()) { self.file(name, path) } else { Ok(()) }
    }

    fn bytes(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        self.begin(name)?;
        self.bytes += bytes.len() as u64;
        self.to.write_all(bytes).map_err(|e| Error::failed(format!("cannot pack `{name}`: {e}")))
    }

    fn folder(&mut self, name: &str, folder: &Path) -> Result<()> {
        plain_files(folder)?.into_iter().try_for_each(|(inside, path)| self.file(&format!("{name}/{inside}"), &path))
    }
}

/// The files of a folder by name; links are not followed out of it.
fn plain_files(folder: &Path) -> Result<Vec<(String, PathBuf)>> {
    let mut files = tree(folder)?;
    files.retain(|(_, path)| !path.is_symlink());
    Ok(files)
}
