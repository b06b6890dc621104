//! Agisoft Metashape's cameras XML (File > Export > Export Cameras).
//!
//! What is read: the first chunk with aligned cameras; its sensors, frame or (equidistant) fisheye, with the adjusted
//! calibration (`class` "adjusted", else any); per camera its label and `transform`, the 4x4 matrix `chunk_from_cam` row by row; the
//! transform of the chunk or, in newer files, of its component (rotation, translation, scale) where there is one, applied to
//! all poses. Cameras that are not aligned or switched off are left out. A label may lack the photograph's ending.
//!
//! Differences that are undone here: cx and cy count from the picture's middle, the corner of the top-left pixel is
//! (0, 0), p1 and p2 change places against OpenCV's, and k4 counts by r⁸. p3 and p4 have no counterpart here: what moves a
//! corner of the picture by 0.1 px or more is refused.

use crate::calibration::sparse::{SparseModel, SparseView};
use crate::error::{Error, Result};
use crate::optics::{Distortion, Lens, Mat3, Model, Vec3};
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use std::collections::BTreeMap;

/// A calibration by tag.
#[derive(Default, Clone)]
struct Sensor {
    id: String,
    adjusted: bool,
    kind: String,
    size: Option<(f64, f64)>,
    values: BTreeMap<String, f64>,
}

/// A rigid motion with scale, as a chunk or component has it.
#[derive(Clone)]
struct Motion {
    rotation: Mat3,
    translation: Vec3,
    scale: f64,
}

impl Default for Motion {
    fn default() -> Self {
        Self { rotation: Mat3::identity(), translation: Vec3::zeros(), scale: 1.0 }
    }
}

#[derive(Default)]
struct Camera {
    label: String,
    sensor: String,
    component: String,
    off: bool,
    transform: Option<[f64; 16]>,
}

#[derive(Default)]
struct State {
    path: Vec<String>,
    text: String,
    sensors: Vec<Sensor>,
    cameras: Vec<Camera>,
    chunk: Motion,
    components: BTreeMap<String, Motion>,
    component: String,
    in_calibration: Option<Sensor>,
    chunks: usize,
}

/// Reads the content of the file `name`: a model without points, in the frame and unit of the chunk's transform.
///
/// # Errors
/// Names file and element: no XML, no aligned camera, numbers that are missing or not finite, a
/// transform that is no rigid motion, a lens that [`Lens`] cannot express.
pub fn parse(name: &str, text: &str) -> Result<SparseModel> {
    let mut reader = Reader::from_str(text);
    let mut state = State::default();
    let broken = |e: &dyn std::fmt::Display, at: u64| {
        let line = 1 + text.get(..at as usize).unwrap_or(text).matches('\n').count();
        Error::failed(format!("`{name}` line {line}: {e}")).help("is it a cameras XML of Metashape, and whole?")
    };
    loop {
        match reader.read_event() {
            Ok(Event::Start(e)) => state.open(&e).map_err(|e| broken(&e.message, reader.buffer_position()))?,
            Ok(Event::Empty(e)) => {
                state.open(&e).map_err(|e| broken(&e.message, reader.buffer_position()))?;
                state.close().map_err(|e| broken(&e.message, reader.buffer_position()))?;
            }
            Ok(Event::Text(t)) => state.text.push_str(&t),
            Ok(Event::End(_)) => state.close().map_err(|e| broken(&e.message, reader.buffer_position()))?,
            Ok(Event::Eof) => break,
            Ok(_) => {}
            Err(e) => return Err(broken(&e, reader.error_position())),
        }
    }
    if !state.path.is_empty() {
        return Err(broken(&format!("ends within <{}>", state.path.join("><")), text.len() as u64));
    }
    state.model().map_err(|e| e.at(format!("`{name}`")))
}

fn attribute(e: &BytesStart, name: &str) -> Result<Option<String>> {
    match e.try_get_attribute(name) {
        Ok(Some(a)) => Ok(Some(a.value.into_owned())),
        Ok(None) => Ok(None),
        Err(fault) => Err(Error::failed(format!("attribute {name}: {fault}"))),
    }
}

fn numbers<const N: usize>(text: &str, what: &str) -> Result<[f64; N]> {
    let values = text
        .split_whitespace()
        .map(|w| w.parse::<f64>().ok().filter(|x| x.is_finite()))
        .collect::<Option<Vec<f64>>>()
        .ok_or_else(|| {
            Error::failed(format!("<{what}> holds something that is no finite number: `{}`", text.trim()))
        })?;
    let n = values.len();
    values.try_into().map_err(|_| Error::failed(format!("<{what}> holds {n} numbers instead of {N}")))
}

impl State {
    fn open(&mut self, e: &BytesStart) -> Result<()> {
        let tag = e.name().as_ref().to_owned();
        self.text.clear();
        let text_of = |key: &str| attribute(e, key).map(Option::unwrap_or_default);
        match tag.as_str() {
            "chunk" => {
                self.chunks += 1;
                if self.cameras.iter().all(|c| c.transform.is_none()) {
                    let (path, chunks) = (std::mem::take(&mut self.path), self.chunks);
                    *self = Self { path, chunks, ..Self::default() };
                }
            }
            "sensor" => self.sensors.push(Sensor { id: text_of("id")?, ..Sensor::default() }),
            "calibration" => {
                let adjusted = text_of("class")? == "adjusted";
                self.in_calibration = Some(Sensor { adjusted, kind: text_of("type")?, ..Sensor::default() });
            }
            "resolution" => {
                let side = |text: String| text.parse::<f64>().ok().filter(|x| *x >= 1.0);
                let size = side(text_of("width")?).zip(side(text_of("height")?));
                if let Some(calibration) = &mut self.in_calibration {
                    calibration.size = size;
                } else if let Some(sensor) = self.sensors.last_mut() {
                    sensor.size = sensor.size.or(size);
                }
            }
            "component" => self.component = text_of("id")?,
            "camera" => self.cameras.push(Camera {
                label: text_of("label")?,
                sensor: text_of("sensor_id")?,
                component: text_of("component_id")?,
                off: ["0", "false"].contains(&text_of("enabled")?.as_str()),
                transform: None,
            }),
            _ => {}
        }
        self.path.push(tag);
        Ok(())
    }

    fn within(&self, tag: &str) -> bool {
        self.path.iter().any(|t| t == tag)
    }

    fn motion(&mut self) -> &mut Motion {
        if self.within("component") {
            self.components.entry(self.component.clone()).or_default()
        } else {
            &mut self.chunk
        }
    }

    fn close(&mut self) -> Result<()> {
        let Some(tag) = self.path.pop() else { return Ok(()) };
        let text = std::mem::take(&mut self.text);
        let parent = self.path.last().map(String::as_str).unwrap_or_default();
        match (tag.as_str(), parent) {
            ("calibration", "sensor") => {
                if let (Some(found), Some(sensor)) = (self.in_calibration.take(), self.sensors.last_mut())
                    && (found.adjusted || !sensor.adjusted)
                {
                    *sensor = Sensor { id: sensor.id.clone(), size: found.size.or(sensor.size), ..found };
                }
            }
            (key, "calibration") if key != "resolution" => {
                if let (Some(calibration), Ok([value])) = (&mut self.in_calibration, numbers::<1>(&text, key)) {
                    calibration.values.insert(key.to_owned(), value);
                }
            }
            ("transform", "camera") => {
                let matrix = numbers::<16>(&text, "transform")?;
                if let Some(camera) = self.cameras.last_mut() {
                    camera.transform = Some(matrix);
                }
            }
            ("rotation", "transform") => {
                self.motion().rotation = Mat3::from_row_slice(&numbers::<9>(&text, "rotation")?)
            }
            ("translation", "transform") => self.motion().translation = Vec3::from(numbers::<3>(&text, "translation")?),
            ("scale", "transform") => self.motion().scale = numbers::<1>(&text, "scale")?[0],
            _ => {}
        }
        Ok(())
    }

    fn model(&self) -> Result<SparseModel> {
        let aligned: Vec<&Camera> = self.cameras.iter().filter(|c| c.transform.is_some() && !c.off).collect();
        if aligned.is_empty() {
            return Err(Error::failed(format!("none of the {} cameras is aligned", self.cameras.len()))
                .help("align the photographs in Metashape, then export the cameras as XML"));
        }
        let model =
            SparseModel { views: aligned.iter().map(|c| self.view(c)).collect::<Result<_>>()?, points: Vec::new() };
        model.check()?;
        Ok(model)
    }

    fn view(&self, camera: &Camera) -> Result<SparseView> {
        let sensor = self.sensors.iter().find(|s| s.id == camera.sensor).ok_or_else(|| {
            Error::failed(format!("camera `{}` names sensor `{}`, which the file lacks", camera.label, camera.sensor))
        })?;
        let lens = sensor.lens().map_err(|e| e.at(format!("sensor `{}`", sensor.id)))?;
        let m = camera.transform.unwrap_or_default();
        let chunk_from_cam = Mat3::new(m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10]);
        let centre = Vec3::new(m[3], m[7], m[11]);
        let motion = self.components.get(&camera.component).unwrap_or(&self.chunk);
        let rigid = |r: &Mat3| (r * r.transpose() - Mat3::identity()).abs().max() < 1e-5 && r.determinant() > 0.0;
        if !rigid(&chunk_from_cam) || !rigid(&motion.rotation) || motion.scale <= 0.0 {
            return Err(Error::failed(format!("the transform of camera `{}` is no rigid motion", camera.label)));
        }
        let rotation = nearest_rotation(&(motion.rotation * chunk_from_cam)).transpose();
        let centre = motion.rotation * centre * motion.scale + motion.translation;
        Ok(SparseView { file: camera.label.clone(), lens, rotation, translation: -(rotation * centre) })
    }
}

/// The file's digits leave a matrix a little off.
fn nearest_rotation(m: &Mat3) -> Mat3 {
    let svd = m.svd(true, true);
    match (svd.u, svd.v_t) {
        (Some(u), Some(v_t)) => u * v_t,
        _ => *m,
    }
}

impl Sensor {
    fn lens(&self) -> Result<Lens> {
        let of = |key: &str| self.values.get(key).copied().unwrap_or(0.0);
        let Some(((width, height), focal)) = self.size.zip(self.values.get("f").copied()) else {
            return Err(Error::failed("the calibration holds no focal length `f` or no resolution")
                .help("export the cameras from an aligned chunk"));
        };
        let model = match self.kind.as_str() {
            "" | "frame" => Model::Brown,
            "fisheye" | "equidistant_fisheye" => Model::Fisheye,
            other => {
                return Err(Error::failed(format!("its calibration is of type `{other}`"))
                    .help("frame and (equidistant) fisheye cameras are read (Tools > Camera Calibration > Type)"));
            }
        };
        let corner = 0.5 * width.hypot(height) / focal;
        let tangential = 3.0 * focal * corner.powi(2) * of("p1").hypot(of("p2"));
        for (key, px) in
            [("p3", of("p3") * corner.powi(2) * tangential), ("p4", of("p4") * corner.powi(4) * tangential)]
        {
            if px.abs() >= 0.1 {
                return Err(Error::failed(format!("{key} moves the picture's corners by {:.1} px", px.abs()))
                    .help("fix p3 and p4 at 0 in Metashape (Tools > Optimize Cameras) and export anew"));
            }
        }
        let (k1, k2, k3, r8) = (of("k1"), of("k2"), of("k3"), of("k4"));
        let (p1, p2, b1, b2) = (of("p2"), of("p1"), of("b1"), of("b2"));
        let lens = Lens {
            width: width as usize,
            height: height as usize,
            focal_px: focal,
            cx: 0.5 * width + of("cx") - 0.5,
            cy: 0.5 * height + of("cy") - 0.5,
            distortion: Distortion { model, k1, k2, p1, p2, k3, r8, b1, b2, ..Distortion::default() },
        };
        lens.check()?;
        Ok(lens)
    }
}

#[cfg(test)]
mod tests;
