//! The first study file of a capture: commented, and with what only a person can measure filled in.

use super::inputs::Frame;
use std::fmt::Write;
use toml::Value;

/// Cameras that a capture brings along.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CameraFile {
    /// Path, relative to the photographs' folder.
    pub path: String,
    /// The frame that such files are in, as a rule.
    pub frame: Frame,
}

/// The tank as it is to stand in the file.
#[derive(Debug, Clone, PartialEq)]
pub enum DraftTank {
    /// A `tank.json`, relative to the photographs' folder; belts beside it.
    File(String),
    /// As measured: outer radius, outer height, wall, depth of the water surface below the rim, mm.
    Measured([f64; 4]),
}

/// What is known of a capture.
#[derive(Debug, Clone, PartialEq)]
pub struct Draft {
    /// Name of the results folder.
    pub name: String,
    /// The photographs' folder, relative to the study file or absolute.
    pub dir: String,
    /// Their pattern, relative to that.
    pub images: String,
    /// What they are, for people.
    pub seen: String,
    /// Cameras that are there already; found in the photographs where not.
    pub cameras: Option<CameraFile>,
    /// The tank.
    pub tank: DraftTank,
    /// Refractive index of the wall.
    pub wall_index: f64,
    /// Opaque bands, z from and to, mm below the rim.
    pub belts_mm: Vec<[f64; 2]>,
    /// A `roots.json` of true roots, relative to the photographs' folder.
    pub truth: Option<String>,
}

impl Draft {
    /// The study file.
    pub fn text(&self) -> String {
        let text = |s: &str| Value::String(s.to_owned()).to_string();
        let mut out = format!(
            "# How this plant is reconstructed: {}\n#   rootvox check {}\n#   rootvox run THIS_FILE\n\
             # Every setting that is not here has a default; `study.lock` in the results lists them all.\n\n\
             [study]\nname = {}\n\n[photos]\ndir = {}   # relative to this file\n\
             images = {}   # in the order in which they were taken\n\n[cameras]\n",
            self.seen,
            self.dir,
            text(&self.name),
            text(&self.dir),
            text(&self.images),
        );
        // Writing into a string cannot fail.
        let _ = match &self.cameras {
            None => writeln!(out, "source = \"sfm\"   # from the photographs and the printed belts; needs COLMAP"),
            Some(file) => {
                let (frame, says) = match file.frame {
                    Frame::Tank => ("tank", "poses are in the tank's frame, mm"),
                    Frame::Free => ("free", "any frame and unit: the tank is then found in the photographs"),
                };
                let path = text(&file.path);
                writeln!(
                    out,
                    "source = \"file\"\npath = {path}   # relative to photos.dir\nframe = \"{frame}\"   # {says}"
                )
            }
        };
        out += "\n[tank]   # measured with a ruler: a millimetre of radius is a percent of every length\n";
        let _ = match &self.tank {
            DraftTank::File(path) => writeln!(out, "file = {}   # relative to photos.dir", text(path)),
            DraftTank::Measured([radius, height, wall, water]) => writeln!(
                out,
                "radius = {radius:?}   # mm, outer: the circumference over 6.2832\nheight = {height:?}   # outer\n\
                 wall = {wall:?}   # thickness of wall and floor\nwater_level = {water:?}   # of the water below the rim\n\
                 index = {{ wall = {:?} }}   # 1.49 PMMA, 1.52 common glass",
                self.wall_index
            ),
        };
        if self.belts_mm.is_empty() {
            out += "# belts = [[0.0, 25.0], [190.0, 220.0]]   # opaque bands, z from and to, mm below the rim\n";
        } else {
            let _ = writeln!(out, "belts = {:?}   # opaque bands, z from and to, mm below the rim", self.belts_mm);
        }
        let _ = write!(
            out,
            "\n# [grid]\n# depth = 180.0    # mm below the rim; down to the inner floor when absent\n\
             # spacing = 0.5    # mm; as wide as a pixel when absent\n"
        );
        if let Some(roots) = &self.truth {
            let _ = write!(out, "\n[truth]   # the result is scored against these\nroots = {}\n", text(roots));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draft() -> Draft {
        Draft {
            name: "plant \"7\"".into(),
            dir: "captures/plant 7".into(),
            images: "*.jpg".into(),
            seen: "36 photographs of 968 x 648 px".into(),
            cameras: None,
            tank: DraftTank::Measured([90.0, 246.6, 5.0, 12.0]),
            wall_index: 1.52,
            belts_mm: vec![[0.0, 28.0], [214.6, 246.6]],
            truth: None,
        }
    }

    #[test]
    fn what_is_known_stands_in_the_file() {
        let read: toml::Table = draft().text().parse().unwrap();
        assert_eq!(read["study"]["name"].as_str(), Some("plant \"7\""));
        assert_eq!(read["photos"]["dir"].as_str(), Some("captures/plant 7"));
        assert_eq!(read["cameras"]["source"].as_str(), Some("sfm"));
        let tank = &read["tank"];
        assert_eq!((tank["radius"].as_float(), tank["water_level"].as_float()), (Some(90.0), Some(12.0)));
        assert_eq!(tank["index"]["wall"].as_float(), Some(1.52));
        assert_eq!(tank["belts"][1][0].as_float(), Some(214.6));
        assert!(!read.contains_key("truth"));
    }

    #[test]
    fn files_that_are_there_are_named() {
        let cameras = Some(CameraFile { path: "sparse/0".into(), frame: Frame::Free });
        let tank = DraftTank::File("tank.json".into());
        let draft = Draft { cameras, tank, belts_mm: Vec::new(), truth: Some("roots.json".into()), ..draft() };
        let read: toml::Table = draft.text().parse().unwrap();
        assert_eq!(read["cameras"]["frame"].as_str(), Some("free"));
        assert_eq!(read["cameras"]["path"].as_str(), Some("sparse/0"));
        assert_eq!(read["tank"]["file"].as_str(), Some("tank.json"));
        assert!(read["tank"].get("belts").is_none());
        assert_eq!(read["truth"]["roots"].as_str(), Some("roots.json"));
    }
}
