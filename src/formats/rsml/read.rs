//! Reads RSML as written by this program and as met in practice.
//!
//! Accepted beyond the schema: coordinates in pixels (divided by `resolution`, then by the unit), any of
//! the units m, dm, cm, mm, µm (um, micron), nm, inch (in), pixel; missing metadata; flat points; `ID` for
//! `id`; samples with their value as text; functions over `polyline`, `uniform` and `length`; foreign attributes
//! and elements (skipped). Diameters are in the unit of their property-definition where that is a length,
//! else in that of the coordinates. Where a root has no diameter its radii are 0. Orders are counted from the nesting.

use crate::error::{Error, Result};
use crate::roots::Root;
use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// The roots in mm, parents first, numbered in the order of the file.
    pub roots: Vec<Root>,
    /// Deviations from the schema that were read over, and assumptions made.
    pub notes: Vec<String>,
}

/// Millimetres of a unit; none for pixels and strangers.
fn millimetres(unit: &str) -> Option<f64> {
    Some(match unit.trim().to_ascii_lowercase().as_str() {
        "m" | "meter" | "metre" => 1000.0,
        "dm" => 100.0,
        "cm" | "centimeter" | "centimetre" => 10.0,
        "mm" | "millimeter" | "millimetre" => 1.0,
        "um" | "µm" | "micron" | "micrometer" | "micrometre" => 1e-3,
        "nm" => 1e-6,
        "inch" | "in" | "inches" => 25.4,
        _ => return None,
    })
}

/// A function of a root as read.
#[derive(Default)]
struct Function {
    name: String,
    domain: String,
    values: Vec<f64>,
    positions: Vec<Option<f64>>,
}

/// A root as read, in the file's units.
#[derive(Default)]
struct Raw {
    parent: Option<usize>,
    order: u32,
    name: String,
    points: Vec<[f64; 3]>,
    functions: Vec<Function>,
}

#[derive(Default)]
struct State {
    path: Vec<String>,
    text: String,
    unit: Option<String>,
    resolution: Option<f64>,
    label: String,
    diameter_unit: Option<String>,
    raw: Vec<Raw>,
    open: Vec<usize>,
    notes: Vec<String>,
    plants: usize,
}

/// Reads the content of an RSML file called `name` in messages.
///
/// # Errors
/// Where the text is not well-formed XML, holds no root, or a coordinate is not a number; names the line.
pub fn read(name: &str, text: &str) -> Result<Reading> {
    let mut reader = Reader::from_str(text);
    let mut state = State::default();
    let fault = |reader: &Reader<&[u8]>, what: String| {
        let at = (reader.buffer_position() as usize).min(text.len());
        let line = text.as_bytes()[..at].iter().filter(|&&b| b == b'\n').count() + 1;
        Error::failed(format!("`{name}`, line {line}: {what}"))
    };
    loop {
        match reader.read_event() {
            Ok(Event::Start(tag)) => state.start(&tag).map_err(|e| fault(&reader, e))?,
            Ok(Event::Empty(tag)) => {
                state.start(&tag).map_err(|e| fault(&reader, e))?;
                state.end();
            }
            Ok(Event::Text(part)) => state.text.push_str(&part),
            Ok(Event::GeneralRef(part)) => state.text.push_str(&entity(&part)),
            Ok(Event::End(_)) => state.end(),
            Ok(Event::Eof) => break,
            Ok(_) => {}
            Err(e) => return Err(fault(&reader, e.to_string()).help("the file is not well-formed XML")),
        }
    }
    if !state.path.is_empty() {
        return Err(fault(&reader, format!("<{}> is not closed", state.path.join("><"))));
    }
    state.finish(name)
}

/// The text of an entity such as `lt` or `#181`; empty for strangers.
fn entity(name: &str) -> String {
    let known = [("lt", '<'), ("gt", '>'), ("amp", '&'), ("quot", '"'), ("apos", '\'')];
    if let Some((_, c)) = known.iter().find(|(n, _)| *n == name) {
        return c.to_string();
    }
    let code = name.strip_prefix('#').and_then(|n| match n.strip_prefix('x') {
        Some(hex) => u32::from_str_radix(hex, 16).ok(),
        None => n.parse().ok(),
    });
    code.and_then(char::from_u32).map_or_else(String::new, String::from)
}

impl State {
    fn note(&mut self, note: impl Into<String>) {
        let note = note.into();
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
    }

    fn start(&mut self, tag: &BytesStart<'_>) -> std::result::Result<(), String> {
        let element = tag.local_name().as_ref().to_string();
        let mut attributes = Vec::new();
        for attribute in tag.attributes() {
            let attribute = attribute.map_err(|e| e.to_string())?;
            let key = attribute.key.as_ref().to_string();
            let value = quick_xml::escape::unescape(&attribute.value).map_err(|e| e.to_string())?.into_owned();
            attributes.push((key, value));
        }
        let get = |key: &str| attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
        let number = |value: &str| {
            value
                .trim()
                .parse::<f64>()
                .ok()
                .filter(|x| x.is_finite())
                .ok_or_else(|| format!("`{value}` is not a number"))
        };
        let within = self.path.last().cloned().unwrap_or_default();
        match element.as_str() {
            "plant" => self.plants += 1,
            "root" => {
                if attributes.iter().any(|(k, _)| k.ends_with(":accession")) {
                    self.note("attribute `po:accession`: the schema has `accession`");
                }
                if get("id").is_none() && get("ID").is_some() {
                    self.note("attribute `ID`: the schema has `id`");
                }
                let name = get("id").or(get("ID")).or(get("label")).unwrap_or_default().to_string();
                let order = self.open.len() as u32;
                self.raw.push(Raw { parent: self.open.last().copied(), order, name, ..Raw::default() });
                self.open.push(self.raw.len() - 1);
            }
            "point" if within == "polyline" => {
                let root = *self.open.last().ok_or("a polyline outside a root")?;
                let coordinate = |key: &str| get(key).map(number).transpose();
                let x = coordinate("x")?.ok_or("a point without x")?;
                let y = coordinate("y")?.ok_or("a point without y")?;
                self.raw[root].points.push([x, y, coordinate("z")?.unwrap_or(0.0)]);
            }
            "function" => {
                if let Some(&root) = self.open.last() {
                    self.raw[root].functions.push(Function {
                        name: get("name").unwrap_or_default().to_string(),
                        domain: get("domain").unwrap_or("polyline").to_string(),
                        ..Function::default()
                    });
                }
            }
            "sample" => {
                let value = get("value").map(number).transpose()?;
                let position = get("position").map(number).transpose()?;
                if let Some(function) = self.function() {
                    function.positions.push(position);
                    function.values.push(value.unwrap_or(f64::NAN));
                }
            }
            _ => {}
        }
        self.path.push(element);
        self.text.clear();
        Ok(())
    }

    fn function(&mut self) -> Option<&mut Function> {
        let root = *self.open.last()?;
        self.raw[root].functions.last_mut()
    }

    fn end(&mut self) {
        let element = self.path.pop().unwrap_or_default();
        let text = self.text.trim().to_string();
        let within = self.path.last().map_or("", String::as_str).to_string();
        match (element.as_str(), within.as_str()) {
            ("unit", "metadata") => self.unit = Some(text),
            ("resolution", "metadata") => self.resolution = text.parse().ok(),
            ("last-modified", _) if !text.contains('T') => self.note("`last-modified` is not a date and time"),
            ("label", "property-definition" | "function-definition") => self.label = text,
            ("unit", "property-definition" | "function-definition") if self.label == "diameter" => {
                self.diameter_unit = Some(text);
            }
            ("sample", _) => {
                let value = text.parse::<f64>();
                let mut as_text = false;
                if let Some(function) = self.function()
                    && let (Some(last), Ok(value)) = (function.values.last_mut(), value)
                    && last.is_nan()
                {
                    *last = value;
                    as_text = true;
                }
                if as_text {
                    self.note("a sample's value as text: the schema has the attribute `value`");
                }
            }
            ("root", _) => {
                self.open.pop();
            }
            _ => {}
        }
        self.text.clear();
    }

    fn finish(mut self, name: &str) -> Result<Reading> {
        let resolution = self.resolution.filter(|r| r.is_finite() && *r > 0.0).unwrap_or_else(|| {
            self.notes.push("no resolution: 1 pixel per unit assumed".to_string());
            1.0
        });
        let unit = self.unit.clone().unwrap_or_default();
        let scale = millimetres(&unit).unwrap_or_else(|| {
            self.notes.push(format!("unit `{unit}` is no length: taken for mm"));
            1.0
        }) / resolution;
        let diameter_scale = self.diameter_unit.as_deref().and_then(millimetres).unwrap_or(scale);
        let mut numbers = vec![-1_i64; self.raw.len()];
        let mut roots = Vec::new();
        let mut notes = self.notes;
        for (k, raw) in self.raw.iter().enumerate() {
            if raw.points.is_empty() {
                notes.push(format!("root `{}` has no points and was left out", raw.name));
                continue;
            }
            if raw.points.len() == 1 {
                notes.push(format!("root `{}` has one point; the schema asks for two", raw.name));
            }
            numbers[k] = roots.len() as i64;
            let points_mm: Vec<[f64; 3]> = raw.points.iter().map(|p| p.map(|v| v * scale)).collect();
            let radii_mm = raw
                .functions
                .iter()
                .find(|f| f.name == "diameter")
                .map_or_else(|| vec![0.0; points_mm.len()], |f| along(f, &raw.points, 0.5 * diameter_scale));
            let parent = raw.parent.map_or(-1, |p| numbers[p]);
            roots.push(Root { id: numbers[k], parent, order: raw.order, points_mm, radii_mm });
        }
        if roots.is_empty() {
            return Err(Error::failed(format!("`{name}` holds no root")).help("is it an RSML file?"));
        }
        if self.plants > 1 {
            notes.push(format!("{} plants are read as one", self.plants));
        }
        Ok(Reading { roots, notes })
    }
}

/// The values of a function at the points of its polyline, times `scale`; a value that is missing is the
/// nearest one before it.
fn along(function: &Function, points: &[[f64; 3]], scale: f64) -> Vec<f64> {
    let values = &function.values;
    if values.is_empty() {
        return vec![0.0; points.len()];
    }
    let arc = crate::roots::curve::chord_lengths(points);
    let length = arc.last().copied().unwrap_or(0.0);
    let n = values.len();
    let positions: Vec<f64> = match function.domain.as_str() {
        "polyline" => (0..n).map(|k| arc[k.min(arc.len() - 1)]).collect(),
        "length" => {
            (0..n).map(|k| function.positions[k].unwrap_or(length * k as f64 / (n - 1).max(1) as f64)).collect()
        }
        _ => (0..n).map(|k| length * function.positions[k].unwrap_or(k as f64 / (n - 1).max(1) as f64)).collect(),
    };
    let value_at = |s: f64| {
        let after = positions.iter().position(|&p| p >= s).unwrap_or(n - 1);
        let before = after.saturating_sub(1);
        let width = positions[after] - positions[before];
        let f = if width > 0.0 { ((s - positions[before]) / width).clamp(0.0, 1.0) } else { 1.0 };
        values[before] + f * (values[after] - values[before])
    };
    arc.iter()
        .map(|&s| value_at(s))
        .scan(0.0, |last, v| {
            if v.is_finite() {
                *last = v;
            }
            Some(*last * scale)
        })
        .collect()
}
