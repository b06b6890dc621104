//! The curves of a sweep: its scores against its first parameter, as SVG and as a table.
//!
//! Points that share the first parameter's value (those of a second axis, such as seeds) are averaged.

use super::table::Table;
use crate::error::Result;
use crate::report::curves::{At, Curve, Panel, curves};

/// A panel of the picture: name of its axis, range that is shown at least, factor, columns of the table with their
/// names.
type Axis = (&'static str, std::ops::Range<f64>, f64, &'static [(&'static str, &'static str)]);

/// What is drawn, where the table has it.
const AXES: &[Axis] = &[
    ("F1", 0.0..1.0, 1.0, &[("f1_0.5mm", "within 0.5 mm"), ("f1_1mm", "within 1 mm"), ("f1_2mm", "within 2 mm")]),
    ("length error, %", -10.0..10.0, 100.0, &[("length_bias", "length")]),
    ("camera error, px", 0.0..1.0, 1.0, &[("camera_rms_px", "rms")]),
];

/// The curves of a sweep.
pub struct Curves {
    parameter: String,
    panels: Vec<Panel>,
}

impl Curves {
    /// The curves over the parameter; `None` where it has fewer than two values that are numbers, or nothing was
    /// scored.
    pub fn of(table: &Table, parameter: &str) -> Option<Self> {
        let x = table.numbers(parameter)?;
        let mut values: Vec<f64> = x.iter().copied().flatten().collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        if values.len() < 2 {
            return None;
        }
        let curve = |column: &str, name: &str, factor: f64| -> Option<Curve> {
            let y = table.numbers(column)?;
            let at = |&value: &f64| {
                let here: Vec<f64> = x
                    .iter()
                    .zip(&y)
                    .filter(|(x, _)| **x == Some(value))
                    .filter_map(|(_, y)| Some((*y)? * factor))
                    .collect();
                let mean = here.iter().sum::<f64>() / here.len() as f64;
                let (low, high) = here.iter().fold((mean, mean), |(a, b), y| (a.min(*y), b.max(*y)));
                (!here.is_empty()).then_some(At { x: value, mean, low, high })
            };
            Some(Curve { name: name.to_owned(), points: values.iter().filter_map(at).collect() })
        };
        let panel = |(label, range, factor, columns): &Axis| {
            let curves: Vec<Curve> = columns.iter().filter_map(|(column, name)| curve(column, name, *factor)).collect();
            (!curves.is_empty()).then(|| Panel { label: (*label).to_owned(), range: range.clone(), curves })
        };
        let panels: Vec<Panel> = AXES.iter().filter_map(panel).collect();
        (!panels.is_empty()).then(|| Self { parameter: parameter.to_owned(), panels })
    }

    /// The picture.
    ///
    /// # Errors
    /// Where it cannot be drawn.
    pub fn svg(&self, title: &str) -> Result<String> {
        curves(title, &self.parameter, &self.panels)
    }

    /// One row per value of the parameter: of each curve the mean, the smallest and the greatest.
    ///
    /// # Errors
    /// Where a row cannot be written.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let mut table = Table::default();
        let mut values: Vec<f64> =
            self.panels.iter().flat_map(|p| &p.curves).flat_map(|c| &c.points).map(|p| p.x).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        for x in values {
            table.rows.push(Vec::new());
            table.put(&self.parameter, x.to_string());
            for panel in &self.panels {
                for curve in &panel.curves {
                    let Some(at) = curve.points.iter().find(|p| p.x == x) else { continue };
                    for (what, y) in [("mean", at.mean), ("least", at.low), ("greatest", at.high)] {
                        table.put(&format!("{} {}: {what}", panel.label, curve.name), format!("{y:.4}"));
                    }
                }
            }
        }
        table.csv()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let mut table = Table::default();
        for (noise, seed, f1) in [("8.0", "1", "0.5"), ("2.0", "1", "0.9"), ("2.0", "2", "0.7"), ("8.0", "2", "")] {
            table.rows.push(Vec::new());
            table.put("noise", noise.into());
            table.put("seed", seed.into());
            table.put("f1_1mm", f1.into());
        }
        table
    }

    #[test]
    fn equal_values_are_averaged_and_failed_points_left_out() {
        let curves = Curves::of(&table(), "noise").unwrap();
        let points = &curves.panels[0].curves[0].points;
        assert_eq!(points.len(), 2);
        assert!((points[0].mean - 0.8).abs() < 1e-12 && points[0].low == 0.7 && points[0].high == 0.9);
        assert_eq!(points[1], At { x: 8.0, mean: 0.5, low: 0.5, high: 0.5 });
        let csv = String::from_utf8(curves.csv().unwrap()).unwrap();
        assert_eq!(csv.lines().nth(1), Some("2,0.8000,0.7000,0.9000"), "{csv}");
        assert!(curves.svg("s").unwrap().contains("noise"));
    }

    #[test]
    fn words_and_single_values_have_no_curve() {
        let mut table = table();
        assert!(Curves::of(&table, "nothing").is_none());
        for row in &mut table.rows {
            row[0] = "mean".into();
        }
        assert!(Curves::of(&table, "noise").is_none());
    }
}
