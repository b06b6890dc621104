//! Curves: what a sweep measured against a parameter, as SVG.
//!
//! Panels stand below each other over one x axis. Where a value of the parameter was measured several times (other
//! plants, other seeds), the curve goes through the means and a bar spans the smallest and the greatest.

use crate::error::{Error, Result};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

/// One value of the parameter, and what was measured there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct At {
    /// The parameter.
    pub x: f64,
    /// Mean of the measurements.
    pub mean: f64,
    /// Smallest of them.
    pub low: f64,
    /// Greatest of them.
    pub high: f64,
}

/// A curve, points by rising x.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its name in the legend.
    pub name: String,
    /// Its points.
    pub points: Vec<At>,
}

/// Curves over one y axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Name of the axis, with its unit.
    pub label: String,
    /// Range of the axis that is shown at least.
    pub range: Range<f64>,
    /// The curves.
    pub curves: Vec<Curve>,
}

const WIDTH: u32 = 640;
const PANEL_HEIGHT: u32 = 230;
const TITLE_HEIGHT: u32 = 34;
/// Colours that also readers who do not see red against green tell apart (Okabe and Ito 2008).
const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115), RGBColor(204, 121, 167)];

/// The panels as SVG.
///
/// # Errors
/// Where there is nothing to draw.
pub fn curves(title: &str, x_label: &str, panels: &[Panel]) -> Result<String> {
    let mut svg = String::new();
    let height = TITLE_HEIGHT + PANEL_HEIGHT * panels.len() as u32;
    picture(&mut svg, height, title, x_label, panels)
        .map_err(|e| Error::failed(format!("cannot draw the curves of `{title}`: {e}")))?;
    Ok(svg)
}

type Drawn = std::result::Result<(), DrawingAreaErrorKind<std::io::Error>>;

fn picture(svg: &mut String, height: u32, title: &str, x_label: &str, panels: &[Panel]) -> Drawn {
    let root = SVGBackend::with_string(svg, (WIDTH, height)).into_drawing_area();
    root.fill(&WHITE)?;
    let (head, body) = root.split_vertically(TITLE_HEIGHT);
    head.draw_text(title, &("sans-serif", 18).into_text_style(&head), (12, 10))?;
    let areas = body.split_evenly((panels.len().max(1), 1));
    for (n, (panel, area)) in panels.iter().zip(&areas).enumerate() {
        draw(panel, area, if n + 1 == panels.len() { x_label } else { "" })?;
    }
    root.present()
}

/// Smallest range that holds all numbers, widened by a share on both sides.
fn span(numbers: impl Iterator<Item = f64>, share: f64) -> Option<Range<f64>> {
    let ends = |(low, high): (f64, f64), x: f64| (low.min(x), high.max(x));
    let (low, high) = numbers.filter(|x| x.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
    let margin = share * (high - low);
    (low <= high).then_some(low - margin..high + margin)
}

fn draw(panel: &Panel, area: &DrawingArea<SVGBackend<'_>, Shift>, x_label: &str) -> Drawn {
    let all = || panel.curves.iter().flat_map(|c| &c.points);
    let x = span(all().map(|p| p.x), 0.03).unwrap_or(0.0..1.0);
    let x = if x.end > x.start { x } else { x.start - 0.5..x.end + 0.5 };
    let least = &panel.range;
    let y = span(all().flat_map(|p| [p.low, p.high]), 0.05).unwrap_or(least.clone());
    let y = y.start.min(least.start)..y.end.max(least.end);
    let mut chart = ChartBuilder::on(area)
        .margin(8)
        .margin_right(20)
        .x_label_area_size(if x_label.is_empty() { 22 } else { 40 })
        .y_label_area_size(58)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc(x_label)
        .y_desc(panel.label.as_str())
        .x_labels(8)
        .y_labels(6)
        .label_style(("sans-serif", 12))
        .axis_desc_style(("sans-serif", 13))
        .draw()?;
    for (curve, colour) in panel.curves.iter().zip(COLOURS.into_iter().cycle()) {
        let bars = curve.points.iter().filter(|p| p.high > p.low);
        chart.draw_series(bars.map(|p| PathElement::new(vec![(p.x, p.low), (p.x, p.high)], colour.mix(0.5))))?;
        chart
            .draw_series(LineSeries::new(curve.points.iter().map(|p| (p.x, p.mean)), colour.stroke_width(2)))?
            .label(curve.name.as_str())
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour.stroke_width(2)));
        chart.draw_series(curve.points.iter().map(|p| Circle::new((p.x, p.mean), 3, colour.filled())))?;
    }
    if panel.curves.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .background_style(WHITE.mix(0.8))
            .label_font(("sans-serif", 12))
            .draw()?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_curve_axis_and_name_is_drawn() {
        let at = |x: f64, mean: f64| At { x, mean, low: mean - 0.1, high: mean + 0.1 };
        let panel = |label: &str, names: &[&str]| Panel {
            label: label.into(),
            range: 0.0..1.0,
            curves: names
                .iter()
                .map(|n| Curve { name: (*n).into(), points: vec![at(1.0, 0.5), at(2.0, 0.75)] })
                .collect(),
        };
        let svg = curves("a < b", "noise", &[panel("F1", &["0.5 mm", "1 mm"]), panel("bias", &["length"])]).unwrap();
        for text in ["a &lt; b", "noise", "F1", "bias", "0.5 mm", "1 mm"] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(svg.matches("<circle").count(), 6);
    }

    #[test]
    fn a_single_point_and_none_at_all_are_no_fault() {
        let one = At { x: 3.0, mean: 0.2, low: 0.2, high: 0.2 };
        let panel =
            |points| Panel { label: "F1".into(), range: 0.0..1.0, curves: vec![Curve { name: "F1".into(), points }] };
        assert!(curves("t", "x", &[panel(vec![one])]).unwrap().contains("<circle"));
        assert!(curves("t", "x", &[panel(Vec::new())]).is_ok() && curves("t", "x", &[]).is_ok());
    }
}
