//! A lens as OpenCV's `FileStorage` (YAML or JSON) and ROS's camera_info write it: what calibrating with a board gives.
//!
//! What is read, under the names in use: the picture's size (`image_width`, `image_height`, or `image_size`), the camera matrix
//! (`camera_matrix`, `cameraMatrix`, `K`), the coefficients (`distortion_coefficients`, `dist_coeffs`, `distCoeffs`, `D`; none,
//! 4, 5, 8 or 12 in OpenCV's order), and whether they are a fisheye's (`fisheye_model: 1`, or `distortion_model` fisheye or
//! equidistant). The centre of the top-left pixel is (0, 0) there as here.
//!
//! Of YAML that is what these programs write: a key a line, matrices one level deeper, numbers in brackets over lines.

use super::json;
use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens, Model};
use serde_json::Value;
use std::collections::BTreeMap;

/// Numbers and words by key; of a matrix its `data`.
#[derive(Default)]
struct Entries(BTreeMap<String, String>);

/// Reads the content of the file `name`.
///
/// # Errors
/// Names file and key: what is missing, no number, or a model that is not read.
pub fn parse(name: &str, text: &str) -> Result<Lens> {
    let entries = if text.trim_start().starts_with('{') { of_json(&json::parse(name, text)?) } else { of_yaml(text) };
    entries.lens().map_err(|e| e.at(format!("`{name}`")))
}

fn of_json(value: &Value) -> Entries {
    let mut entries = Entries::default();
    let flat = |value: &Value| match value {
        Value::String(text) => text.clone(),
        Value::Object(matrix) => matrix.get("data").map(Value::to_string).unwrap_or_default(),
        other => other.to_string(),
    };
    if let Value::Object(all) = value {
        entries.0.extend(all.iter().map(|(key, value)| (key.clone(), flat(value))));
    }
    entries
}

fn of_yaml(text: &str) -> Entries {
    let mut entries = Entries::default();
    let (mut key, mut open) = (String::new(), false);
    for line in text.lines() {
        let line = line.split(" #").next().unwrap_or_default();
        if open {
            // A list that goes on.
            if let Some(value) = entries.0.get_mut(&key) {
                value.push(' ');
                value.push_str(line.trim());
            }
            open = !line.contains(']');
            continue;
        }
        if line.starts_with(['%', '#']) || line.starts_with("---") {
            continue;
        }
        let Some((left, right)) = line.split_once(':') else { continue };
        let (is_inner, left, right) = (left.starts_with(char::is_whitespace), left.trim(), right.trim());
        if !is_inner {
            key = left.to_owned();
        } else if left != "data" {
            continue;
        }
        let value = if right.starts_with('!') { "" } else { right.trim_matches(['"', '\'']) };
        entries.0.insert(key.clone(), value.to_owned());
        open = value.contains('[') && !value.contains(']');
    }
    entries
}

impl Entries {
    fn first(&self, keys: &[&str]) -> Option<&str> {
        keys.iter().find_map(|key| self.0.get(*key)).map(String::as_str)
    }

    fn numbers(&self, keys: &[&str]) -> Result<Option<Vec<f64>>> {
        let Some(text) = self.first(keys) else { return Ok(None) };
        // Nested lists, as numpy's matrices become, are one.
        let words = text.split([',', '[', ']', ' ', '\t']).filter(|word| !word.is_empty());
        let number = |word: &str| word.parse::<f64>().ok().filter(|x| x.is_finite());
        words
            .map(number)
            .collect::<Option<Vec<f64>>>()
            .map(Some)
            .ok_or_else(|| Error::failed(format!("`{}` holds something that is no finite number: `{text}`", keys[0])))
    }

    fn lens(&self) -> Result<Lens> {
        let missing = |what: &str| {
            Error::failed(format!("`{what}` is missing"))
                .help("the file is a calibration that OpenCV or ROS wrote, in YAML or JSON")
        };
        let size = match self.numbers(&["image_size", "imageSize"])? {
            Some(size) => size,
            None => {
                let side =
                    |key: &str| self.numbers(&[key])?.and_then(|n| n.first().copied()).ok_or_else(|| missing(key));
                vec![side("image_width")?, side("image_height")?]
            }
        };
        let &[width, height] = size.as_slice() else { return Err(missing("image_width")) };
        if !(1.0..1e9).contains(&width) || !(1.0..1e9).contains(&height) {
            return Err(Error::failed(format!("the picture's size is {width} x {height} px")));
        }
        let matrix = self.numbers(&["camera_matrix", "cameraMatrix", "K"])?.ok_or_else(|| missing("camera_matrix"))?;
        let &[fx, skew, cx, _, fy, cy, ..] = matrix.as_slice() else { return Err(missing("camera_matrix")) };
        if matrix.len() != 9 {
            return Err(Error::failed(format!("`camera_matrix` holds {} numbers instead of 9", matrix.len())));
        }
        let d = self.numbers(&["distortion_coefficients", "dist_coeffs", "distCoeffs", "D"])?.unwrap_or_default();
        let word = self.first(&["distortion_model"]).unwrap_or_default();
        let model = match word {
            "" | "plumb_bob" | "rational_polynomial" | "radtan" => Model::Brown,
            "equidistant" | "fisheye" => Model::Fisheye,
            other => {
                return Err(Error::failed(format!("distortion_model `{other}`"))
                    .help("plumb_bob, rational_polynomial and equidistant are read"));
            }
        };
        let is_fisheye = self.numbers(&["fisheye_model"])?.is_some_and(|n| n.first() == Some(&1.0));
        let model = if is_fisheye { Model::Fisheye } else { model };
        let of = |k: usize| d.get(k).copied().unwrap_or(0.0);
        let plain = Distortion { model, b1: fx - fy, b2: skew, ..Distortion::default() };
        let distortion = match (model, d.len()) {
            (Model::Fisheye, 0 | 4) => Distortion { k1: of(0), k2: of(1), k3: of(2), r8: of(3), ..plain },
            (Model::Brown, 0 | 4 | 5 | 8 | 12 | 14) if of(12) == 0.0 && of(13) == 0.0 => Distortion {
                k1: of(0),
                k2: of(1),
                p1: of(2),
                p2: of(3),
                k3: of(4),
                k4: of(5),
                k5: of(6),
                k6: of(7),
                s: [of(8), of(9), of(10), of(11)],
                ..plain
            },
            (_, n) => {
                return Err(Error::failed(format!("`distortion_coefficients` holds {n} numbers"))
                    .help("0, 4, 5, 8 or 12 of an ordinary lens, without tilt, or 4 of a fisheye are read"));
            }
        };
        let lens = Lens { width: width as usize, height: height as usize, focal_px: fy, cx, cy, distortion };
        lens.check()?;
        Ok(lens)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Written by OpenCV 5.0: `cv2.FileStorage(name, cv2.FILE_STORAGE_WRITE)`.
    const YAML: &str = include_str!("../../tests/data/lenses/calibration.yml");
    const JSON: &str = include_str!("../../tests/data/lenses/calibration.json");

    fn want() -> Lens {
        let distortion = Distortion {
            k1: -0.09,
            k2: 0.05,
            p1: 4e-4,
            p2: -3e-4,
            k3: 0.01,
            b1: 1003.68 - 984.0,
            ..Distortion::default()
        };
        Lens { width: 968, height: 648, focal_px: 984.0, cx: 488.2, cy: 320.1, distortion }
    }

    #[test]
    fn what_opencv_writes_is_read() {
        assert_eq!(parse("c.yml", YAML).unwrap(), want());
        assert_eq!(parse("c.json", JSON).unwrap(), want());
    }

    #[test]
    fn what_ros_writes_is_read() {
        let text = "image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320.5,\n    0, 501.0, 240, 0, 0, 1]\n\
                    distortion_model: equidistant\ndistortion_coefficients:\n  rows: 1\n  cols: 4\n  data: [0.1, 0.02, -0.003, 0.0004]\n\
                    projection_matrix:\n  rows: 3\n  cols: 4\n  data: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\n";
        let lens = parse("head.yaml", text).unwrap();
        let d = lens.distortion;
        assert_eq!((lens.focal_px, lens.cx, lens.width, d.model), (501.0, 320.5, 640, Model::Fisheye));
        assert_eq!((d.k1, d.k2, d.k3, d.r8, d.b1), (0.1, 0.02, -0.003, 0.0004, -1.0));
    }

    #[test]
    fn faults_are_named() {
        let says = |text: &str, word: &str| {
            let e = parse("c.yml", text).unwrap_err().to_string();
            assert!(e.contains("c.yml") && e.contains(word), "{e}");
        };
        says("", "image_width");
        says("{", "c.yml");
        says(&YAML.replace("image_height", "high"), "image_height");
        says(&YAML.replace("camera_matrix", "matrix"), "camera_matrix");
        says(&YAML.replace("968", "nine"), "nine");
        says(&YAML.replace("camera_matrix", "distortion_model: fov\ncamera_matrix"), "`fov`");
        says("image_size: [9, 9]\nK: [9, 0, 4, 0, 9, 4, 0, 0, 1]\nD: [1, 2, 3]\n", "3 numbers");
        says("image_size: [9, 9]\nK: [9, 0, 4, 0, 9, 4]\n", "6 numbers");
    }
}
