//! `[sweep]`: one study, many settings; all combinations of the values of its axes.
//!
//! ```toml
//! [sweep]
//! "extract.high" = [0.01, 0.02, 0.04]                             # an axis: a list of values
//! "simulate.seed" = { from = 1, to = 20 }                         # a range, both ends included; step 1 if not given
//! "merge.tolerance" = { from = 0.001, to = 0.1, count = 5, scale = "log" }
//! "rootness.gamma23, rootness.gamma12" = [[0.5, 0.5], [1.0, 1.0]] # parameters that change together: one axis
//! ```
//!
//! With `traits = true` every point's roots are traced and measured too, which takes longer than extracting them: traits
//! are then columns of `sweep.csv`.
//!
//! Any parameter of any section can be swept. Points are numbered from 1; axes come in the order of the file and the
//! last one changes fastest. Numbers of a range are rounded to 12 digits, so that 0.1 + 2 * 0.1 reads 0.3.

use super::document::Document;
use crate::error::{Error, Result};
use serde::Deserialize;
use std::fmt::Write;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

/// Points of one sweep; more is more likely a slip than a wish.
const MOST_POINTS: usize = 10_000;

/// A range of numbers.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Steps {
    from: f64,
    to: f64,
    step: Option<f64>,
    count: Option<usize>,
    #[serde(default)]
    scale: Scale,
}

/// How the numbers of a range with a count are spaced.
#[derive(Deserialize, Default, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Scale {
    #[default]
    Linear,
    Log,
}

impl Steps {
    /// The numbers as TOML; `whole` writes them without a fraction.
    fn numbers(&self, whole: bool) -> std::result::Result<Vec<String>, String> {
        let Self { from, to, step, count, scale } = *self;
        if !(from.is_finite() && to.is_finite()) {
            return Err("the ends of a range are finite numbers".into());
        }
        let values: Vec<f64> = match (step, count) {
            (Some(_), Some(_)) => return Err("a range has a `step` or a `count`, not both".into()),
            (_, None) if scale == Scale::Log => return Err("a logarithmic range needs a `count`".into()),
            (step, None) => {
                let step = step.unwrap_or(1.0);
                let steps = ((to - from) / step + 1e-9).floor();
                if !(0.0..MOST_POINTS as f64).contains(&steps) {
                    return Err(format!("steps of {step} do not lead from {from} to {to} in fewer than {MOST_POINTS}"));
                }
                (0..=steps as usize).map(|n| from + n as f64 * step).collect()
            }
            (None, Some(count)) => {
                if !(2..=MOST_POINTS).contains(&count) {
                    return Err(format!("the `count` of a range is a number from 2 to {MOST_POINTS}"));
                }
                if scale == Scale::Log && !(from > 0.0 && to > 0.0) {
                    return Err("a logarithmic range lies above 0".into());
                }
                let share = |n: usize| n as f64 / (count - 1) as f64;
                let at = |n: usize| match scale {
                    Scale::Linear => from + (to - from) * share(n),
                    Scale::Log => (from.ln() + (to.ln() - from.ln()) * share(n)).exp(),
                };
                (0..count).map(at).collect()
            }
        };
        let text = |value: &f64| match whole {
            true => format!("{value:.0}"),
            false => format!("{:?}", format!("{value:.11e}").parse::<f64>().unwrap_or(*value)),
        };
        Ok(values.iter().map(text).collect())
    }
}

/// An axis as the file has it: its parameters, where they stand, and a list or a range.
struct Written<'t> {
    parameters: Vec<String>,
    span: Range<usize>,
    value: Spanned<DeValue<'t>>,
    /// The numbers of a range, as TOML.
    numbers: Vec<String>,
}

/// The section as the file has it, with its ranges counted out.
pub(super) struct Section<'t> {
    axes: Vec<Written<'t>>,
    /// Whether points have traits.
    pub(super) traits: bool,
}

/// One value of each of an axis' parameters.
type Row<'s> = Vec<Spanned<DeValue<'s>>>;

/// Parameters that change together, and their values.
struct Axis<'s> {
    parameters: &'s [String],
    rows: Vec<Row<'s>>,
}

/// What a point lays over the study.
pub(super) struct Override<'s> {
    pub(super) parameter: &'s str,
    pub(super) value: Spanned<DeValue<'s>>,
    /// The value for people.
    pub(super) text: String,
}

impl<'t> Section<'t> {
    /// Takes the section out of the document; `None` where there is none.
    ///
    /// # Errors
    /// Axes that are none, all at once, each at its place.
    pub(super) fn take(document: &mut Document<'t>) -> Result<Option<Self>> {
        let Some((_, mut table)) = document.take_table("sweep") else { return Ok(None) };
        let (mut written, mut traits) = (Vec::new(), false);
        let switch = table.iter().find(|(key, _)| key.get_ref() == "traits").map(|(key, _)| key.clone());
        if let Some(value) = switch.and_then(|key| table.remove(&key)) {
            traits = value.get_ref().as_bool().ok_or_else(|| {
                document.fault(
                    "[sweep] `traits` is true or false, or an axis such as \"traits.layer_mm\"",
                    Some(value.span()),
                )
            })?;
        }
        flatten("", table, &mut written);
        written.sort_by_key(|axis| axis.span.start);
        let mut faults = Vec::new();
        let mut written = once(written, document, &mut faults);
        for axis in &mut written {
            if let Err(fault) = axis.check(document) {
                faults.push(fault);
            }
        }
        Error::many(faults)?;
        Ok(if written.is_empty() { None } else { Some(Self { axes: written, traits }) })
    }

    /// The swept parameters in order.
    pub(super) fn parameters(&self) -> Vec<String> {
        self.axes.iter().flat_map(|axis| axis.parameters.clone()).collect()
    }

    /// How many values the last axis has.
    pub(super) fn fastest(&self) -> usize {
        self.axes.last().map_or(1, |axis| axis.len())
    }

    /// The overrides of every point, in order.
    ///
    /// # Errors
    /// Where there are too many points.
    pub(super) fn points(&self) -> Result<Vec<Vec<Override<'_>>>> {
        let count = self.axes.iter().fold(1_usize, |n, axis| n.saturating_mul(axis.len()));
        if count > MOST_POINTS {
            return Err(Error::usage(format!("[sweep] makes {count} points, at most {MOST_POINTS} are run"))
                .help("sweep fewer parameters at once, or change several together on one axis"));
        }
        let axes: Vec<Axis<'_>> = self.axes.iter().map(Written::axis).collect::<Result<_>>()?;
        Ok((0..count).map(|point| overrides(&axes, point)).collect())
    }
}

fn overrides<'s>(axes: &[Axis<'s>], point: usize) -> Vec<Override<'s>> {
    let (mut rest, mut chosen) = (point, Vec::new());
    for axis in axes.iter().rev() {
        chosen.push((axis, rest % axis.rows.len()));
        rest /= axis.rows.len();
    }
    let of_axis = |(axis, row): (&Axis<'s>, usize)| {
        let values = axis.parameters.iter().zip(axis.rows[row].clone());
        values.map(|(parameter, value)| Override { parameter, text: shown(value.get_ref()), value }).collect::<Vec<_>>()
    };
    chosen.into_iter().rev().flat_map(of_axis).collect()
}

/// The axes with those of the command line in the place of the file's over the same parameters, however these are spelt;
/// a parameter on two axes is a fault.
fn once<'t>(written: Vec<Written<'t>>, document: &Document<'t>, faults: &mut Vec<Error>) -> Vec<Written<'t>> {
    let mut axes: Vec<Written<'t>> = Vec::new();
    for axis in written {
        let same = axes.iter_mut().find(|other| other.parameters == axis.parameters);
        if let (Some(other), true) = (same, document.is_override(&axis.span)) {
            *other = axis;
            continue;
        }
        let twice = axis.parameters.iter().find(|p| axes.iter().any(|other| other.parameters.contains(p)));
        if let Some(parameter) = twice {
            let message = format!("[sweep] `{parameter}` is on two axes");
            faults.push(document.fault(&message, Some(axis.span.clone())).help("sweep a parameter once"));
        }
        axes.push(axis);
    }
    axes
}

/// Axes out of nested tables: `extract.high = [..]` is `"extract.high" = [..]`.
fn flatten<'t>(prefix: &str, table: DeTable<'t>, axes: &mut Vec<Written<'t>>) {
    for (key, value) in table {
        let span = key.span();
        let name = if prefix.is_empty() { key.get_ref().to_string() } else { format!("{prefix}.{}", key.get_ref()) };
        match value.get_ref() {
            DeValue::Table(inner) if !inner.iter().any(|(k, _)| k.get_ref() == "from") => {
                flatten(&name, inner.clone(), axes);
            }
            _ => {
                let parameters = name.split(',').map(|p| p.trim().to_owned()).collect();
                axes.push(Written { parameters, span, value, numbers: Vec::new() });
            }
        }
    }
}

impl<'t> Written<'t> {
    /// Refuses what is no axis, and counts a range out.
    fn check(&mut self, document: &Document<'t>) -> Result<()> {
        let fault = |message: &str, span: Range<usize>| document.fault(&format!("[sweep] {message}"), Some(span));
        if let Some(bad) = self.parameters.iter().find(|p| p.split('.').count() < 2 || p.split('.').any(str::is_empty))
        {
            let message = format!("`{bad}` names no parameter, write SECTION.KEY such as \"extract.high\"");
            return Err(fault(&message, self.span.clone()));
        }
        let at = self.value.span();
        match self.value.get_ref() {
            DeValue::Array(rows) if rows.is_empty() => Err(fault("an axis has at least one value", at)),
            DeValue::Array(_) if self.parameters.len() == 1 => Ok(()),
            DeValue::Array(rows) => {
                let wanted = self.parameters.len();
                let short = |row: &&Spanned<DeValue<'t>>| row.get_ref().as_array().is_none_or(|r| r.len() != wanted);
                match rows.iter().find(short) {
                    None => Ok(()),
                    Some(row) => Err(fault(
                        &format!("{wanted} parameters change together: expected a list of {wanted} values"),
                        row.span(),
                    )),
                }
            }
            DeValue::Table(table) if self.parameters.len() == 1 => {
                let whole = table.iter().all(|(key, value)| key.get_ref() != "count" && value.get_ref().is_integer());
                let steps = Steps::deserialize(ValueDeserializer::from(self.value.clone()))
                    .map_err(|e| fault(e.message(), e.span().unwrap_or(at.clone())))?;
                self.numbers = steps.numbers(whole).map_err(|why| fault(&why, at))?;
                Ok(())
            }
            DeValue::Table(_) => Err(fault("a range is an axis of one parameter", at)),
            other => Err(fault(
                &format!("expected a list of values or a range {{ from, to, step }}, found {}", other.type_str()),
                at,
            )),
        }
    }

    fn len(&self) -> usize {
        self.value.get_ref().as_array().map_or(self.numbers.len(), |rows| rows.len())
    }

    fn axis(&self) -> Result<Axis<'_>> {
        let one = self.parameters.len() == 1;
        let rows = match self.value.get_ref() {
            DeValue::Array(rows) if one => rows.iter().map(|value| vec![value.clone()]).collect(),
            DeValue::Array(rows) => rows
                .iter()
                .filter_map(|row| row.get_ref().as_array())
                .map(|row| row.iter().cloned().collect())
                .collect(),
            _ => {
                let number = |text| {
                    let value = DeValue::parse(text).map_err(|e| Error::failed(format!("{text}: {}", e.message())))?;
                    Ok(vec![Spanned::new(self.value.span(), value.into_inner())])
                };
                self.numbers.iter().map(|text| number(text)).collect::<Result<_>>()?
            }
        };
        Ok(Axis { parameters: &self.parameters, rows })
    }
}

/// A value for people: as TOML, strings bare.
fn shown(value: &DeValue<'_>) -> String {
    let list = |items: Vec<String>| items.join(", ");
    match value {
        DeValue::String(text) => text.to_string(),
        DeValue::Integer(n) => n.to_string(),
        DeValue::Float(x) => x.to_string(),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(d) => d.to_string(),
        DeValue::Array(items) => format!("[{}]", list(items.iter().map(|v| shown(v.get_ref())).collect())),
        DeValue::Table(table) => {
            format!(
                "{{ {} }}",
                list(table.iter().map(|(k, v)| format!("{} = {}", k.get_ref(), shown(v.get_ref()))).collect())
            )
        }
    }
}

/// Numbers as people list pages: `1-3, 7`.
pub fn ranges(numbers: &[usize]) -> String {
    let mut text = String::new();
    let mut rest = numbers;
    while let [first, ..] = *rest {
        let run = rest.iter().enumerate().take_while(|(n, number)| **number == first + n).count();
        let comma = if text.is_empty() { "" } else { ", " };
        let _ = match run {
            1 => write!(text, "{comma}{first}"),
            2 => write!(text, "{comma}{first}, {}", first + 1),
            _ => write!(text, "{comma}{first}-{}", first + run - 1),
        };
        rest = &rest[run..];
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::document::Sources;

    /// The texts of every point's values, or the messages of all faults.
    fn points(text: &str) -> std::result::Result<Vec<String>, String> {
        points_with(text, &[])
    }

    fn points_with(text: &str, overrides: &[String]) -> std::result::Result<Vec<String>, String> {
        let sources = Sources::new("study.toml", text, overrides).unwrap();
        let mut document = Document::parse(&sources).unwrap();
        let section = Section::take(&mut document).map_err(|e| e.to_string())?.unwrap();
        let points = section.points().map_err(|e| e.to_string())?;
        Ok(points.iter().map(|p| p.iter().map(|o| o.text.as_str()).collect::<Vec<_>>().join(" ")).collect())
    }

    #[test]
    fn grids_ranges_and_axes_of_several_parameters() {
        let text = "[sweep]\nextract.high = [1, 2]\n\"a.b, a.c\" = [[1.5, true], [2.5, false]]\n";
        assert_eq!(points(text).unwrap(), ["1 1.5 true", "1 2.5 false", "2 1.5 true", "2 2.5 false"]);
        assert_eq!(points("[sweep]\n\"a.b\" = { from = 1, to = 3 }").unwrap(), ["1", "2", "3"]);
        assert_eq!(points("[sweep]\na.b = { from = 0.1, to = 0.3, step = 0.1 }").unwrap(), ["0.1", "0.2", "0.3"]);
        let log = "[sweep]\na.b = { from = 0.001, to = 0.1, count = 3, scale = \"log\" }";
        assert_eq!(points(log).unwrap(), ["0.001", "0.01", "0.1"]);
        assert_eq!(points("[sweep]\na.b = { from = 3, to = 1, step = -1 }").unwrap(), ["3", "2", "1"]);
    }

    #[test]
    fn an_axis_of_the_command_line_takes_the_place_of_the_files_however_it_is_spelt() {
        for file in ["\"a.b\" = [1, 2]", "a.b = [1, 2]"] {
            for set in ["sweep.a.b=[3, 4, 5]", "sweep.\"a.b\"=[3, 4, 5]"] {
                let found = points_with(&format!("[sweep]\n{file}\n"), &[set.to_owned()]);
                assert_eq!(found.unwrap(), ["3", "4", "5"], "{file} {set}");
            }
        }
    }

    #[test]
    fn what_is_no_axis_is_shown_at_its_place() {
        for (axis, word) in [
            ("\"a.b\" = 3", "found integer"),
            ("\"a.b\" = []", "at least one"),
            ("\"b\" = [3]", "names no parameter"),
            ("\"a.b, a.c\" = [[1, 2], [3]]", "list of 2 values"),
            ("\"a.b\" = [1]\na.b = [2]", "two axes"),
            ("\"a.b\" = { from = 1, to = 0 }", "do not lead"),
            ("\"a.b\" = { from = 1, to = 9, stop = 3 }", "stop"),
            ("\"a.b\" = { from = 0, to = 1, count = 5, scale = \"log\" }", "above 0"),
            ("\"a.b\" = { from = 1, to = 1e9 }", "fewer than"),
            ("\"a.b\" = { from = 1, to = 900 }\n\"a.c\" = { from = 1, to = 900 }", "810000 points"),
        ] {
            let message = points(&format!("[sweep]\n{axis}\n")).unwrap_err();
            assert!(message.contains(word), "{axis}: {message}");
            assert!(
                message.contains("line 2") || message.contains("line 3") || message.contains("points"),
                "{message}"
            );
        }
    }

    #[test]
    fn numbers_are_listed_as_ranges() {
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3, 7, 9, 10");
        assert_eq!(ranges(&[]), "");
    }
}
