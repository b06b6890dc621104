//! A contact sheet: the roots of every point of a sweep from the side, with its values and its score; below, where a
//! slice is asked for, its pictures with the roots in it as red dots.  Paper, figures 6, 8, 9.
//!
//! A self-contained SVG: pictures are embedded PNGs, texts are texts. A picture is the greatest rootness along y:
//! brightness is 0.35 + 0.65 sqrt(rootness / the sheet's greatest), so that sheets of one sweep compare by eye.

use crate::error::Result;
use crate::formats::picture;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use ndarray::{Array2, Array3};
use std::fmt::Write;

/// Root voxels of one point: place (mm, tank frame) and rootness.
pub type Voxels = Vec<([f32; 3], f32)>;

/// One picture of the sheet.
pub struct Panel {
    /// Lines above the picture; the first stands out.
    pub lines: Vec<String>,
    /// The root voxels, or why there are none.
    pub roots: std::result::Result<Voxels, String>,
    /// Half the width of the scene, mm.
    pub radius_mm: f64,
    /// Depth of the scene, mm.
    pub depth_mm: f64,
    /// Edge of a voxel, mm.
    pub spacing_mm: f64,
    /// A horizontal slice, where there is one.
    pub slice: Option<Slice>,
}

/// A horizontal slice of a point's volumes.
pub struct Slice {
    /// Square pictures as PNG, each with what it shows.
    pub pictures: Vec<(String, Vec<u8>)>,
    /// Roots in the slice: x, y, mm, tank frame; drawn on the first picture.
    pub roots: Vec<[f32; 2]>,
    /// x and y go from this to its opposite, mm.
    pub half_mm: f64,
}

/// Width of a panel, px.
const WIDTH: f64 = 240.0;
/// Space between panels, px.
const GAP: f64 = 12.0;
/// Space for title and link, px.
const TOP: f64 = 52.0;
/// Height of a line of text, px.
const LINE: f64 = 16.0;
/// Letters of a line in a panel.
const LETTERS: usize = 36;
/// Pixels of an embedded picture at most per side; finer voxels share pixels.
const MOST_PX: f64 = 480.0;
/// RGB of the background.
const GROUND: [u8; 3] = [17, 17, 17];

/// The sheet as SVG, `columns` panels a row; `page` is the address of one that shows the roots in space.
///
/// # Errors
/// Where a picture cannot be written.
pub fn sheet(title: &str, panels: &[Panel], columns: usize, page: Option<&str>) -> Result<String> {
    let columns = columns.clamp(1, panels.len().max(1));
    let text_px = LINE * panels.iter().map(|p| p.lines.len()).max().unwrap_or(0) as f64 + 6.0;
    let aspect = panels.iter().map(|p| p.depth_mm / (2.0 * p.radius_mm)).fold(0.0, f64::max);
    let slices = panels.iter().filter_map(|p| p.slice.as_ref()).map(|s| s.pictures.len()).max().unwrap_or(0);
    let (step_x, step_y) = (WIDTH + GAP, text_px + WIDTH * aspect + (WIDTH + LINE + 4.0) * slices as f64 + GAP);
    let (width, height) = (GAP + step_x * columns as f64, TOP + GAP + step_y * panels.len().div_ceil(columns) as f64);
    let all = panels.iter().filter_map(|p| p.roots.as_ref().ok()).flatten();
    let greatest = all.map(|(_, rootness)| *rootness).fold(f32::MIN_POSITIVE, f32::max);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"12\"><rect width=\"100%\" height=\"100%\" \
         fill=\"white\"/><text x=\"{GAP}\" y=\"28\" font-size=\"18\">{}</text>\n",
        escape(title)
    );
    if let Some(page) = page {
        let page = escape(page);
        let _ = writeln!(
            svg,
            "<a href=\"{page}\"><text x=\"{GAP}\" y=\"44\" fill=\"#0a6788\" text-decoration=\"underline\">side by side in space: {page}</text></a>"
        );
    }
    for (n, panel) in panels.iter().enumerate() {
        let (x, y) = (GAP + step_x * (n % columns) as f64, TOP + step_y * (n / columns) as f64);
        for (k, line) in panel.lines.iter().enumerate() {
            let weight = if k == 0 { " font-weight=\"bold\"" } else { "" };
            let baseline = y + LINE * (k as f64 + 1.0);
            let _ = writeln!(svg, "<text x=\"{x:.0}\" y=\"{baseline:.0}\"{weight}>{}</text>", escape(line));
        }
        let (top, tall) = (y + text_px, WIDTH * panel.depth_mm / (2.0 * panel.radius_mm));
        let place = format!("x=\"{x:.0}\" y=\"{top:.0}\" width=\"{WIDTH:.0}\" height=\"{tall:.0}\"");
        match &panel.roots {
            Ok(roots) => {
                let png = picture::png(side_view(panel, roots, greatest).view())?;
                let _ = writeln!(svg, "<image {place} href=\"data:image/png;base64,{}\"/>", STANDARD.encode(&png));
                if let Some(slice) = &panel.slice {
                    slice.draw(&mut svg, x, y + text_px + WIDTH * aspect);
                }
            }
            Err(why) => {
                let _ = writeln!(svg, "<rect {place} fill=\"#fff4d6\"/>");
                let fit = (((tall - 8.0) / LINE).floor() as usize).max(1);
                for (k, line) in wrapped(why).iter().take(fit).enumerate() {
                    let baseline = top + LINE * (k as f64 + 1.0) + 4.0;
                    let _ = writeln!(svg, "<text x=\"{:.0}\" y=\"{baseline:.0}\">{}</text>", x + 6.0, escape(line));
                }
            }
        }
    }
    Ok(svg + "</svg>\n")
}

impl Slice {
    /// Its pictures one below the other from (x, y) on, px.
    fn draw(&self, svg: &mut String, x: f64, y: f64) {
        let half = self.half_mm;
        for (n, (title, png)) in self.pictures.iter().enumerate() {
            let top = y + (WIDTH + LINE + 4.0) * n as f64;
            let (title, baseline, top, side) = (escape(title), top + LINE, top + LINE + 4.0, 2.0 * half);
            let place = format!("x=\"{x:.0}\" y=\"{top:.0}\" width=\"{WIDTH:.0}\" height=\"{WIDTH:.0}\"");
            let area = format!("x=\"{0:.2}\" y=\"{0:.2}\" width=\"{side:.2}\" height=\"{side:.2}\"", -half);
            let _ = writeln!(
                svg,
                "<text x=\"{x:.0}\" y=\"{baseline:.0}\">{title}</text><svg {place} viewBox=\"{0:.2} {0:.2} {side:.2} \
                 {side:.2}\"><image {area} href=\"data:image/png;base64,{1}\"/>",
                -half,
                STANDARD.encode(png)
            );
            for [x, y] in self.roots.iter().filter(|_| n == 0) {
                let _ = write!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{:.2}\" fill=\"red\"/>", half / 90.0);
            }
            svg.push_str("</svg>\n");
        }
    }
}

/// The voxels seen along y: x to the right, z down.
fn side_view(panel: &Panel, roots: &Voxels, greatest: f32) -> Array3<u8> {
    let pixel_mm = panel.spacing_mm.max(2.0 * panel.radius_mm / MOST_PX);
    let cells = |mm: f64| (mm / pixel_mm).ceil().max(1.0) as usize;
    let mut seen = Array2::<f32>::zeros((cells(panel.depth_mm), cells(2.0 * panel.radius_mm)));
    for ([x, _, z], rootness) in roots {
        let column = ((f64::from(*x) + panel.radius_mm) / pixel_mm).floor();
        let row = (f64::from(*z) / pixel_mm).floor();
        if column >= 0.0
            && row >= 0.0
            && let Some(cell) = seen.get_mut((row as usize, column as usize))
        {
            *cell = cell.max(*rootness);
        }
    }
    let (rows, columns) = seen.dim();
    Array3::from_shape_fn((rows, columns, 3), |(row, column, channel)| {
        let rootness = seen[[row, column]];
        if rootness <= 0.0 {
            return GROUND[channel];
        }
        (255.0 * (0.35 + 0.65 * (rootness / greatest).min(1.0).sqrt())) as u8
    })
}

/// Lines of words that fit into a panel; a word longer than a line is cut.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for piece in letters.chunks(LETTERS) {
            let piece: String = piece.iter().collect();
            match lines.last_mut() {
                Some(line) if line.chars().count() + 1 + piece.chars().count() <= LETTERS => {
                    line.push(' ');
                    line.push_str(&piece);
                }
                _ => lines.push(piece),
            }
        }
    }
    lines
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(roots: std::result::Result<Voxels, String>) -> Panel {
        let lines = vec!["point 1".into(), "a < b".into()];
        Panel { lines, roots, radius_mm: 10.0, depth_mm: 30.0, spacing_mm: 1.0, slice: None }
    }

    #[test]
    fn the_side_view_keeps_the_brightest_and_drops_what_lies_outside() {
        let roots = vec![([-9.5, 3.0, 0.5], 0.25), ([-9.5, -3.0, 0.5], 1.0), ([99.0, 0.0, 5.0], 1.0)];
        let p = panel(Ok(Vec::new()));
        let view = side_view(&p, &roots, 1.0);
        assert_eq!(view.dim(), (30, 20, 3));
        assert_eq!(view[[0, 0, 0]], 255);
        assert_eq!(view.iter().filter(|&&v| v != 17).count(), 3, "one voxel lies in the scene");
    }

    #[test]
    fn failed_points_have_their_place_on_the_sheet() {
        let svg =
            sheet("s", &[panel(Ok(vec![([0.0; 3], 0.5)])), panel(Err("no camera".into()))], 2, Some("compare.html"))
                .unwrap();
        assert!(svg.contains("data:image/png;base64,iVBOR") && svg.contains("no camera") && svg.contains("a &lt; b"));
        assert!(svg.contains("<a href=\"compare.html\">"));
    }

    #[test]
    fn roots_of_a_slice_are_dots_on_its_first_picture() {
        let pictures = vec![("merged".into(), vec![1]), ("coverage".into(), vec![2])];
        let slice = Slice { pictures, roots: vec![[1.0, -2.0], [3.0, 4.0]], half_mm: 10.5 };
        let svg = sheet("s", &[Panel { slice: Some(slice), ..panel(Ok(Vec::new())) }], 1, None).unwrap();
        let (merged, coverage) = (svg.find(">merged<").unwrap(), svg.find(">coverage<").unwrap());
        assert_eq!(svg[merged..coverage].matches("<circle").count(), 2);
        assert_eq!(svg[coverage..].matches("<circle").count(), 0);
        assert!(svg.contains("viewBox=\"-10.50 -10.50 21.00 21.00\""));
    }
}
