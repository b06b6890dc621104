//! `rootvox export figure`: the roots of a result as a figure for papers.

use super::terminal::talkln;
use crate::error::{Error, Result};
use crate::report::figure::{Colour, Figure as Drawing};
use crate::study::compare::of_folder;
use clap::Args;
use std::path::PathBuf;
use svg2pdf::usvg::{Options, Tree};

/// Resolution of a PNG, dots per inch.
const DPI: f32 = 600.0;

/// The roots of a result as a figure for papers: from two sides and from above, in mm.
///
/// All panels have one scale, and a scale bar. Lines are as wide as the roots. Colours are those that colour-blind eyes tell apart.
/// The ending of the file says its form: .svg, .pdf (both with lines and letters that stay sharp), or .png (600 dots per inch).
///
/// Example:
///   rootvox export figure results/plant-7 --colour depth --font-size 7 -o figure.pdf
#[derive(Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Figure {
    /// A results folder.
    results: PathBuf,
    /// What colours tell: order, diameter or depth.
    #[arg(long, value_name = "WHAT", default_value = "order", value_parser = ["order", "diameter", "depth"])]
    colour: String,
    /// Size of the letters, points, 4 to 24.
    #[arg(long, value_name = "PT", default_value_t = 8.0)]
    font_size: f64,
    /// Width on paper, mm, 50 to 1000.
    #[arg(long, value_name = "MM", default_value_t = 170.0)]
    width: f64,
    /// The file to write: .svg, .pdf or .png.
    #[arg(long, short, value_name = "FILE")]
    out: PathBuf,
}

impl Figure {
    pub(super) fn run(&self) -> Result<()> {
        let form = self.out.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
        if !["svg", "pdf", "png"].contains(&form.as_str()) {
            return Err(Error::usage(format!("--out {}: the ending says no form of figure", self.out.display()))
                .help("end it in .svg, .pdf or .png"));
        }
        for (name, value, least, most) in
            [("font-size", self.font_size, 4.0, 24.0), ("width", self.width, 50.0, 1000.0)]
        {
            if !(least..=most).contains(&value) {
                return Err(Error::usage(format!("--{name} is {value}")).help(format!("give {least} to {most}")));
            }
        }
        let shown = of_folder(&self.results)?;
        let colour = match self.colour.as_str() {
            "diameter" => Colour::Diameter,
            "depth" => Colour::Depth,
            _ => Colour::Order,
        };
        let (roots, font_pt) = (&shown.roots[..], self.font_size);
        let svg = Drawing { tank: &shown.tank, roots, colour, width_mm: self.width, font_pt }.svg();
        let bytes = match form.as_str() {
            "svg" => svg.into_bytes(),
            "pdf" => pdf(&tree(&svg)?)?,
            _ => png(&tree(&svg)?, self.width)?,
        };
        std::fs::write(&self.out, bytes).map_err(|e| Error::io("write", &self.out, e))?;
        talkln!("figure written: {}", self.out.display());
        Ok(())
    }
}

/// The drawing with its letters in a font of this machine.
fn tree(svg: &str) -> Result<Tree> {
    let mut options = Options::default();
    let fonts = options.fontdb_mut();
    fonts.load_system_fonts();
    let families: Vec<String> = fonts.faces().flat_map(|face| &face.families).map(|(name, _)| name.clone()).collect();
    let usual = ["Arial", "Helvetica", "Liberation Sans", "DejaVu Sans", "Noto Sans"];
    let Some(sans) =
        usual.into_iter().find(|name| families.iter().any(|f| f == name)).or(families.first().map(String::as_str))
    else {
        return Err(Error::failed("this machine has no font to draw letters with")
            .help("install one, such as Debian's fonts-dejavu-core, or write an .svg"));
    };
    let sans = sans.to_owned();
    options.fontdb_mut().set_sans_serif_family(sans);
    Tree::from_str(svg, &options).map_err(|e| Error::failed(format!("the figure cannot be drawn: {e}")))
}

fn pdf(tree: &Tree) -> Result<Vec<u8>> {
    // Without a resolution of its own, a unit of the drawing is a CSS pixel.
    let page = svg2pdf::PageOptions { dpi: 96.0 };
    svg2pdf::to_pdf(tree, svg2pdf::ConversionOptions::default(), page)
        .map_err(|e| Error::failed(format!("the figure cannot be written as PDF: {e}")))
}

fn png(tree: &Tree, width_mm: f64) -> Result<Vec<u8>> {
    let scale = DPI / 25.4 * width_mm as f32 / tree.size().width();
    let size = [tree.size().width(), tree.size().height()].map(|x| (x * scale).round() as u32);
    let mut pixels = resvg::tiny_skia::Pixmap::new(size[0], size[1])
        .ok_or_else(|| Error::failed(format!("a picture of {} x {} px is too large", size[0], size[1])))?;
    resvg::render(tree, resvg::tiny_skia::Transform::from_scale(scale, scale), &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| Error::failed(format!("the figure cannot be written as PNG: {e}")))
}
