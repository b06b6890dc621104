//! The sections that say what goes in: ``````[study]``````, ``````[photos]``````, ``````[cameras]``````, ``````[tank]``````, ``````[grid]``````, ``````[truth]``````.

use crate::error::{Error, Result};
use crate::formats::camera_file::COLMAP_FILES;
use crate::formats::tank_json;
use crate::optics::{Index, Tank};
use crate::roots::correction::CorrectionParams;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// `[study]`: what the study is called.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct StudySection {
    /// Name of the results folder; the file's name without its ending when absent.
    pub name: Option<String>,
    /// Free text for people; no result depends on it.
    pub description: Option<String>,
    /// Licence of the results, an SPDX name such as `CC-BY-4.0` or an address; stands in `ro-crate-metadata.json`.
    pub license: Option<String>,
}

/// `[photos]`: which photographs, in capture order.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Photos {
    /// Folder that the other input paths of the study start from; relative to the study file (or to
    /// the working folder when given by `--set`).
    pub dir: String,
    /// Pattern of the photographs (`*` and `?`; the ending in either case), sorted by name with numbers in numeric order.
    /// What operating systems leave in folders is left out: hidden files, `Thumbs.db`, `desktop.ini`.
    pub images: String,
    /// With cameras from the photographs: a picture of their size, white where features may be taken, relative to `dir`;
    /// the printed belts are looked for when absent.
    pub mask: Option<String>,
}

impl Default for Photos {
    fn default() -> Self {
        Self { dir: ".".into(), images: "images/*.jpg".into(), mask: None }
    }
}

/// Where the cameras come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum CameraSource {
    /// A file with lens and poses.
    #[default]
    File,
    /// Structure from motion on the photographs, then registration of the tank.  Paper 2.2.
    Sfm,
}

/// The frame of a camera file's poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Frame {
    /// The tank's, in mm.
    #[default]
    Tank,
    /// Any, in any unit: the tank is then registered in it.
    Free,
}

/// `[cameras]`: lens and poses.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cameras {
    /// `file` or `sfm`.
    pub source: CameraSource,
    /// With `file`: a `cameras.json`, a `transforms.json`, a cameras XML of Metashape or the folder of a COLMAP model,
    /// relative to `photos.dir`.
    pub path: String,
    /// With `sfm`: the lens where it is known, a calibration by OpenCV or ROS (YAML or JSON), relative to `photos.dir`; it then
    /// stays as it is. Found with the poses when absent.
    pub lens: Option<String>,
    /// With `file`: whether its poses are in the `tank` frame already, or in a `free` one.
    pub frame: Frame,
}

impl Cameras {
    /// The files that `path` means: itself, or the three of a COLMAP model where it is a folder.
    ///
    /// # Errors
    /// A folder without a COLMAP model.
    pub fn files(&self, input_dir: &Path) -> Result<Vec<PathBuf>> {
        let path = input_dir.join(&self.path);
        if !path.is_dir() {
            return Ok(vec![path]);
        }
        let whole = |names: &&[&str; 3]| names.iter().all(|name| path.join(name).is_file());
        let names = COLMAP_FILES.iter().find(whole).ok_or_else(|| {
            Error::usage(format!("cameras.path: the folder `{}` holds no COLMAP model", path.display()))
                .help("a model is cameras, images and points3D, all as .bin or all as .txt (often in sparse/0)")
        })?;
        Ok(names.iter().map(|name| path.join(name)).collect())
    }
}

impl Default for Cameras {
    fn default() -> Self {
        Self { source: CameraSource::File, path: "cameras.json".into(), lens: None, frame: Frame::Tank }
    }
}

/// `[tank]`: geometry and material; numbers given here win over those of `file`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TankSection {
    /// A `tank.json`, relative to `photos.dir`.
    pub file: Option<String>,
    /// Outer radius r, mm.
    pub radius: Option<f64>,
    /// Outer height h, mm.
    pub height: Option<f64>,
    /// Thickness τ of wall and floor, mm.
    pub wall: Option<f64>,
    /// Depth of the water surface below the rim, mm.
    pub water_level: Option<f64>,
    /// Refractive indices.
    pub index: IndexSection,
    /// Opaque bands around the outer wall, [z from, z to], mm.
    pub belts: Option<Vec<[f64; 2]>>,
}

/// `[tank.index]`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IndexSection {
    /// n₁, 1.0 for air.
    pub air: Option<f64>,
    /// n₂, 1.49 for PMMA, 1.52 for common glass.
    pub wall: Option<f64>,
    /// n₃, 1.333 for water.
    pub water: Option<f64>,
}

impl From<&Tank> for TankSection {
    fn from(tank: &Tank) -> Self {
        let Index { air, wall, water } = tank.index;
        Self {
            file: None,
            radius: Some(tank.radius_mm),
            height: Some(tank.height_mm),
            wall: Some(tank.wall_mm),
            water_level: Some(tank.water_level_mm),
            index: IndexSection { air: Some(air), wall: Some(wall), water: Some(water) },
            belts: Some(tank.belts_mm.clone()),
        }
    }
}

impl TankSection {
    /// The tank, from the file and the numbers given beside it.
    ///
    /// # Errors
    /// All at once: what is missing, and what makes no tank ([`Tank::check`]).
    pub fn resolve(&self, input_dir: &Path) -> Result<Tank> {
        let from_file = match &self.file {
            None => None,
            Some(file) => {
                let path = input_dir.join(file);
                let text = std::fs::read_to_string(&path).map_err(|e| {
                    Error::io("read the tank from", &path, e).help("check tank.file; it is relative to photos.dir")
                })?;
                Some(tank_json::parse(&path.display().to_string(), &text)?)
            }
        };
        let mut missing = Vec::new();
        let mut take = |given: Option<f64>, file: fn(&Tank) -> f64, key: &str| {
            given.or_else(|| from_file.as_ref().map(file)).unwrap_or_else(|| {
                missing.push(Error::usage(format!("tank.{key} is not given")).help(format!(
                    "measure the tank and write `{key}` (mm) under [tank], or name a tank.json with `file`"
                )));
                f64::NAN
            })
        };
        let paper = from_file.as_ref().map_or_else(Index::default, |t| t.index);
        let tank = Tank {
            radius_mm: take(self.radius, |t| t.radius_mm, "radius"),
            height_mm: take(self.height, |t| t.height_mm, "height"),
            wall_mm: take(self.wall, |t| t.wall_mm, "wall"),
            water_level_mm: take(self.water_level, |t| t.water_level_mm, "water_level"),
            index: Index {
                air: self.index.air.unwrap_or(paper.air),
                wall: self.index.wall.unwrap_or(paper.wall),
                water: self.index.water.unwrap_or(paper.water),
            },
            belts_mm: self.belts.clone().or_else(|| from_file.as_ref().map(|t| t.belts_mm.clone())).unwrap_or_default(),
        };
        Error::many(missing)?;
        tank.check()?;
        Ok(tank)
    }
}

/// `[simulate.tank]`: the tank that is photographed, where it is to be another than that of `[tank]`, by which the
/// reconstruction goes: what a wrong assumption does. What is not given is as in `[tank]`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrueTank {
    /// Outer radius r, mm.
    pub radius: Option<f64>,
    /// Outer height h, mm.
    pub height: Option<f64>,
    /// Thickness τ of wall and floor, mm.
    pub wall: Option<f64>,
    /// Depth of the water surface below the rim, mm.
    pub water_level: Option<f64>,
    /// Refractive indices.
    pub index: IndexSection,
    /// Opaque bands around the outer wall, [z from, z to], mm.
    pub belts: Option<Vec<[f64; 2]>>,
}

impl TrueTank {
    /// The tank that is photographed.
    ///
    /// # Errors
    /// What makes no tank ([`Tank::check`]).
    pub fn resolve(&self, assumed: &Tank) -> Result<Tank> {
        let Index { air, wall, water } = assumed.index;
        let tank = Tank {
            radius_mm: self.radius.unwrap_or(assumed.radius_mm),
            height_mm: self.height.unwrap_or(assumed.height_mm),
            wall_mm: self.wall.unwrap_or(assumed.wall_mm),
            water_level_mm: self.water_level.unwrap_or(assumed.water_level_mm),
            index: Index {
                air: self.index.air.unwrap_or(air),
                wall: self.index.wall.unwrap_or(wall),
                water: self.index.water.unwrap_or(water),
            },
            belts_mm: self.belts.clone().unwrap_or_else(|| assumed.belts_mm.clone()),
        };
        tank.check().map_err(|e| e.at("[simulate.tank]"))?;
        Ok(tank)
    }
}

/// `[grid]`: the voxels.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GridSection {
    /// Edge δ of a voxel, mm; when absent, that of a pixel at the tank's axis.  Paper 3: 1 mm.
    pub spacing: Option<f64>,
    /// How deep below the rim to reconstruct, mm; down to the inner floor when absent.
    pub depth: Option<f64>,
}

/// `[corrections]`: what a person corrected.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CorrectionsSection {
    /// A file of corrections, relative to the study file (or to the working folder when given by `--set`).
    pub file: Option<String>,
    /// As [`CorrectionParams::within_mm`].
    pub within_mm: f64,
    /// As [`CorrectionParams::snap_mm`].
    pub snap_mm: f64,
}

impl Default for CorrectionsSection {
    fn default() -> Self {
        let CorrectionParams { within_mm, snap_mm } = CorrectionParams::default();
        Self { file: None, within_mm, snap_mm }
    }
}

impl CorrectionsSection {
    /// Refuses what finds nothing or anything.
    ///
    /// # Errors
    /// Names the number.
    pub fn check(&self) -> Result<()> {
        for (name, value, least) in [("within_mm", self.within_mm, 0.01), ("snap_mm", self.snap_mm, 0.0)] {
            if !(least..=20.0).contains(&value) {
                return Err(
                    Error::usage(format!("corrections.{name} is {value}")).help(format!("give {least} to 20 mm"))
                );
            }
        }
        Ok(())
    }

    /// How places are found.
    pub fn params(&self) -> CorrectionParams {
        CorrectionParams { within_mm: self.within_mm, snap_mm: self.snap_mm }
    }
}

/// `[truth]`: the true roots, where they are known; the result is then scored against them.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Truth {
    /// A `roots.json`, relative to `photos.dir`.
    pub roots: Option<String>,
    /// Score only below this depth, mm; 16 mm under the water level when absent.
    pub z_min: Option<f64>,
    /// Score only above this depth, mm; 2 mm above the reconstruction's depth when absent.
    pub z_max: Option<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_missing_of_a_tank_is_said_at_once() {
        let e = TankSection::default().resolve(Path::new(".")).unwrap_err();
        assert_eq!(1 + e.others.len(), 4, "{e}");
        let thick = TankSection {
            radius: Some(50.0),
            height: Some(100.0),
            wall: Some(60.0),
            water_level: Some(5.0),
            ..TankSection::default()
        };
        assert!(thick.resolve(Path::new(".")).unwrap_err().message.contains("not thinner"));
    }

    #[test]
    fn the_photographed_tank_is_the_assumed_one_but_for_what_is_said() {
        let assumed = Tank {
            radius_mm: 50.0,
            height_mm: 100.0,
            wall_mm: 3.0,
            water_level_mm: 5.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 10.0]],
        };
        assert_eq!(TrueTank::default().resolve(&assumed).unwrap(), assumed);
        let truth = TrueTank { wall: Some(4.0), ..TrueTank::default() };
        assert_eq!(truth.resolve(&assumed).unwrap(), Tank { wall_mm: 4.0, ..assumed.clone() });
        let none = TrueTank { radius: Some(-1.0), ..TrueTank::default() };
        assert!(none.resolve(&assumed).unwrap_err().to_string().contains("simulate.tank"));
    }
}
