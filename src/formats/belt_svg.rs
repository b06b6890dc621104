//! Belts to print: the random pattern of the simulation at true scale, as SVG in mm.
//!
//! The strip is as long as the outer circumference and an overlap, on which the pattern goes on as it began, so that
//! the glued belt closes without a seam. A strip longer than the sheet is cut into pieces, stacked on the page, each
//! beginning on the overlap of the piece before. Registration marks: at both edges of a piece, a short line where it
//! starts to overlap; laid on the marks' numbers, the pieces fit. A bar of 50 mm tells whether the printer kept the scale.

use crate::error::{Error, Result};
use crate::simulation::BeltPrint;
use std::fmt::Write;

/// Space around and between the pieces, mm.
const MARGIN_MM: f64 = 8.0;
/// Length of a registration mark, mm.
const MARK_MM: f64 = 3.0;

/// A belt for a tank of that outer radius, as high as wanted; `sheet_mm` is the printable length of a sheet (277 for
/// A4 across), `overlap_mm` the overlap of pieces.
///
/// # Errors
/// Where a length is not positive and finite, or the overlap leaves nothing of a sheet.
pub fn belt_svg(radius_mm: f64, height_mm: f64, seed: u64, sheet_mm: f64, overlap_mm: f64) -> Result<String> {
    for (name, value) in
        [("radius", radius_mm), ("height", height_mm), ("sheet length", sheet_mm), ("overlap", overlap_mm)]
    {
        if !(value.is_finite() && value > 0.0 && value < 1e5) {
            return Err(Error::usage(format!("the belt's {name} is {value} mm")).help("give a positive length in mm"));
        }
    }
    if sheet_mm < 2.0 * overlap_mm + 10.0 {
        return Err(Error::usage(format!(
            "a sheet of {sheet_mm} mm leaves no room beside overlaps of {overlap_mm} mm"
        ))
        .help("give a longer sheet or a smaller overlap"));
    }
    let print = BeltPrint::new(radius_mm, height_mm, seed);
    let around = std::f64::consts::TAU * radius_mm;
    // Each piece carries `advance` of the circumference and the overlap.
    let pieces = (around / (sheet_mm - overlap_mm)).ceil() as usize;
    let advance = around / pieces as f64;
    let (width, pitch) = (advance + overlap_mm, height_mm + 2.0 * MARGIN_MM);
    let (page_width, page_height) = (width + 2.0 * MARGIN_MM, pieces as f64 * pitch + 2.0 * MARGIN_MM);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{page_width:.3}mm\" height=\"{page_height:.3}mm\" \
         viewBox=\"0 0 {page_width:.3} {page_height:.3}\">\n\
         <title>Belt for a tank of {radius_mm} mm outer radius, {height_mm} mm high, seed {seed}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
    );
    for piece in 0..pieces {
        let top = MARGIN_MM + piece as f64 * pitch;
        let start = piece as f64 * advance;
        let _ = writeln!(svg, "<g id=\"piece{}\" transform=\"translate({MARGIN_MM} {top:.3})\">", piece + 1);
        let _ = writeln!(svg, "<path fill=\"#000\" d=\"{}\"/>", cells(&print, start, width, height_mm));
        let _ = writeln!(
            svg,
            "<rect width=\"{width:.3}\" height=\"{height_mm}\" fill=\"none\" stroke=\"#888\" stroke-width=\"0.1\"/>"
        );
        // Where this piece is laid on the one before, and where the next one is laid on it.
        for (x, label) in [(0.0, piece), (advance, piece + 1)] {
            for (from, to) in [(-0.5 - MARK_MM, -0.5), (height_mm + 0.5, height_mm + 0.5 + MARK_MM)] {
                let _ = writeln!(
                    svg,
                    "<path d=\"M{x:.3} {from:.3}V{to:.3}\" stroke=\"#000\" stroke-width=\"0.2\" fill=\"none\"/>"
                );
            }
            let number = label % pieces + 1;
            let _ = writeln!(
                svg,
                "<text x=\"{:.3}\" y=\"{:.3}\" font-family=\"sans-serif\" font-size=\"3\">{number}</text>",
                x + 0.8,
                height_mm + MARK_MM + 0.3
            );
        }
        svg.push_str("</g>\n");
    }
    let y = page_height - MARGIN_MM;
    let _ = writeln!(
        svg,
        "<path d=\"M{MARGIN_MM} {0:.3}v3h50v-3\" stroke=\"#000\" stroke-width=\"0.2\" fill=\"none\"/>\n\
         <text x=\"{1:.3}\" y=\"{2:.3}\" font-family=\"sans-serif\" font-size=\"3.5\">50 mm: print at 100 %; outer \
         radius {radius_mm} mm, seed {seed}</text>\n</svg>",
        y,
        MARGIN_MM + 53.0,
        y + 3.0
    );
    Ok(svg)
}

/// Path of the black cells between `start` and `start + width` along the circumference, runs of a row joined.
fn cells(print: &BeltPrint, start: f64, width: f64, height_mm: f64) -> String {
    let mut path = String::new();
    let cell = print.cell_mm;
    let first = (start / cell).floor() as usize;
    let last = ((start + width) / cell).ceil() as usize;
    for row in 0..print.rows {
        let (y, bottom) = (row as f64 * cell, ((row + 1) as f64 * cell).min(height_mm));
        let mut column = first;
        while column < last {
            if !print.is_black(row, column) {
                column += 1;
                continue;
            }
            let from = column;
            while column < last && print.is_black(row, column) {
                column += 1;
            }
            let x0 = (from as f64 * cell - start).max(0.0);
            let x1 = (column as f64 * cell - start).min(width);
            if x1 > x0 {
                let _ = write!(path, "M{x0:.3} {y:.3}H{x1:.3}V{bottom:.3}H{x0:.3}z");
            }
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_cover_the_circumference_at_true_scale() {
        let svg = belt_svg(90.0, 28.0, 1, 277.0, 10.0).unwrap();
        assert_eq!(svg.matches("<g id").count(), 3);
        let advance = std::f64::consts::TAU * 90.0 / 3.0;
        assert!(svg.contains(&format!("width=\"{:.3}mm\"", advance + 10.0 + 2.0 * MARGIN_MM)));
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(belt_svg(20.0, 28.0, 1, 277.0, 10.0).unwrap().matches("<g id").count(), 1);
    }

    #[test]
    fn the_overlap_repeats_the_beginning() {
        let print = BeltPrint::new(20.0, 10.0, 3);
        let around = std::f64::consts::TAU * 20.0;
        let begin = cells(&print, 0.0, 5.0 * print.cell_mm, 10.0);
        let end = cells(&print, around, 5.0 * print.cell_mm, 10.0);
        assert_eq!(begin, end);
    }

    #[test]
    fn impossible_belts_are_refused() {
        assert!(belt_svg(-1.0, 28.0, 1, 277.0, 10.0).is_err());
        assert!(belt_svg(90.0, 28.0, 1, 25.0, 10.0).is_err());
    }
}
