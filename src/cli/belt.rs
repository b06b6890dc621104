//! `rootvox belt`: a strip to print and glue around the tank.

use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::formats::belt_svg::belt_svg;
use clap::Args;
use std::fs;
use std::path::PathBuf;

/// Draw a belt to print: a random pattern that photographs are matched by, at true scale.
///
/// Glue one at the top and one, of another seed, at the bottom of the tank. The strip is cut into pieces that fit a
/// sheet; each piece's beginning is laid on the mark with its number on the piece before, and the last one on the first.
/// Print at 100 % (no fitting to the page) and check the bar of 50 mm with a ruler.
///
/// Example:
///   rootvox belt --radius 90 --height 28 -o belt.svg
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub struct Belt {
    /// Outer radius of the tank, mm: its circumference over 6.2832.
    #[arg(long, value_name = "MM")]
    radius: f64,
    /// Height of the belt, mm.
    #[arg(long, value_name = "MM")]
    height: f64,
    /// Seed of the pattern; every belt of a tank needs its own.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Printable length of a sheet, mm: 277 is A4 across.
    #[arg(long, value_name = "MM", default_value_t = 277.0)]
    sheet: f64,
    /// Overlap of two pieces, mm.
    #[arg(long, value_name = "MM", default_value_t = 10.0)]
    overlap: f64,
    /// The SVG to write.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
}

impl Belt {
    /// Writes the belt.
    ///
    /// # Errors
    /// Lengths that make no belt, a file that cannot be written.
    pub fn run(&self) -> Result<()> {
        let svg = belt_svg(self.radius, self.height, self.seed, self.sheet, self.overlap)?;
        fs::write(&self.out, svg).map_err(|e| Error::io("write", &self.out, e))?;
        talkln!("belt written: {}", self.out.display());
        Ok(())
    }
}
