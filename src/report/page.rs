//! The page that sums up a result: one self-contained HTML file beside its pictures.
//!
//! It works by double click: no script, no network; the overlays are the files in `overlays/`.

use super::palette;
use crate::evaluation::{BAND_MM, Band, Place, Score, Sight};
use crate::optics::Tank;
use crate::volume::Grid;
use std::fmt::Write;

/// What the page shows.
pub struct Page<'a> {
    /// Name of the study.
    pub name: &'a str,
    /// The tank.
    pub tank: &'a Tank,
    /// The voxels.
    pub grid: &'a Grid,
    /// Root voxels: place (mm, tank frame) and number of the connected piece.
    pub roots: &'a [([f32; 3], u32)],
    /// The score, where the truth is known.
    pub score: Option<&'a Score>,
    /// What the views see of the water.
    pub sight: &'a [Sight],
    /// The score by place, where the truth is known.
    pub bands: &'a [Band],
    /// Parameters per stage, as (stage, JSON text).
    pub settings: &'a [(String, String)],
    /// What stages warned of.
    pub warnings: &'a [String],
    /// The photographs' point spread, px, where diameters were measured in them.
    pub spread_px: Option<f64>,
    /// Paths of the overlays, relative to the page.
    pub overlays: &'a [String],
}

/// Root voxels drawn at most per projection; more would not be told apart.
const MOST_DRAWN: usize = 6000;

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:70rem;padding:0 1rem;color:#222}\
h1,h2{font-weight:600}table{border-collapse:collapse}td,th{padding:.2rem .8rem;text-align:right;border-bottom:1px solid #ddd}\
td:first-child,th:first-child{text-align:left}.grid{display:grid;grid-template-columns:repeat(auto-fill,minmax(15rem,1fr));gap:.5rem}\
.grid img{width:100%;display:block}.warn{background:#fff4d6;padding:.5rem 1rem;border-left:4px solid #e0a800}\
svg{background:#111;max-width:100%}pre{white-space:pre-wrap;margin:0;text-align:left;font-size:12px}figure{margin:0}";

impl Page<'_> {
    /// The page as HTML.
    pub fn html(&self) -> String {
        let mut t = format!(
            "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{STYLE}</style></head>\
             <body><h1>{0}</h1>\n",
            escape(self.name)
        );
        let pieces = self.roots.iter().map(|r| r.1 + 1).max().unwrap_or(0);
        let [depth, rows, columns] = self.grid.shape;
        let _ = writeln!(
            t,
            "<p>{} root voxels in {pieces} connected pieces; grid {columns} × {rows} × {depth} of {} mm; tank of radius \
             {} mm, wall {} mm, indices {} / {} / {}.</p>",
            self.roots.len(),
            self.grid.spacing_mm,
            self.tank.radius_mm,
            self.tank.wall_mm,
            self.tank.index.air,
            self.tank.index.wall,
            self.tank.index.water
        );
        if let Some(spread_px) = self.spread_px {
            let _ = writeln!(
                t,
                "<p>Diameters were measured in the photographs, with a point spread of {spread_px:.2} px (standard deviation).</p>"
            );
        }
        for warning in self.warnings {
            let _ = writeln!(t, "<p class=\"warn\">{}</p>", escape(warning));
        }
        if let Some(score) = self.score {
            t.push_str("<h2>Against the truth</h2><table><tr><th>within</th><th>precision</th><th>recall</th><th>F1</th></tr>\n");
            for a in &score.at {
                let _ = writeln!(
                    t,
                    "<tr><td>{} mm</td><td>{:.3}</td><td>{:.3}</td><td>{:.3}</td></tr>",
                    a.tolerance_mm, a.precision, a.recall, a.f1
                );
            }
            t.push_str("</table>\n");
        }
        self.places(&mut t);
        t.push_str("<h2>Roots</h2><div class=\"grid\">\n");
        let far = self.tank.inner_radius_mm();
        let deep = self.grid.spacing_mm * depth as f64;
        for (title, across, down, low, high) in [
            ("from the side (x, z)", 0, 2, 0.0, deep),
            ("from the side (y, z)", 1, 2, 0.0, deep),
            ("from above (x, y)", 0, 1, -far, far),
        ] {
            let _ = writeln!(
                t,
                "<figure>{}<figcaption>{title}</figcaption></figure>",
                self.projection(across, down, low, high)
            );
        }
        t.push_str("</div>\n<h2>Overlays</h2><p>Extracted roots drawn back through the refraction; each connected piece has its colour.</p><div class=\"grid\">\n");
        for path in self.overlays {
            let path = escape(path);
            let _ = writeln!(t, "<a href=\"{path}\"><img loading=\"lazy\" src=\"{path}\" alt=\"{path}\"></a>");
        }
        t.push_str("</div>\n<h2>Settings</h2><table>\n");
        for (stage, params) in self.settings {
            let _ = writeln!(t, "<tr><td>{}</td><td><pre>{}</pre></td></tr>", escape(stage), escape(params));
        }
        t.push_str("</table></body></html>\n");
        t
    }

    /// What is seen and how right the result is next to wall, surface, floor and belts.
    fn places(&self, t: &mut String) {
        let water: usize = self.sight.iter().map(|s| s.voxels).sum();
        if water == 0 {
            return;
        }
        let percent =
            |part: f64, whole: f64| if whole > 0.0 { format!("{:.1} %", 100.0 * part / whole) } else { "–".into() };
        let _ = write!(
            t,
            "<h2>What the views see</h2><p>Of each part of the water in the grid: voxels that too few views see are left \
             unknown and hold no root; nothing else is left out. Bands are {BAND_MM} mm wide.</p>\
             <table><tr><th>part</th><th>share of the water</th><th>unseen</th>"
        );
        if !self.bands.is_empty() {
            t.push_str(
                "<th>true roots</th><th>of them unseen</th><th>recall 1 mm</th><th>points</th><th>precision 1 mm</th>",
            );
        }
        t.push_str("</tr>\n");
        for s in self.sight.iter().filter(|s| s.voxels > 0) {
            let (voxels, unseen) = (s.voxels as f64, s.unseen as f64);
            let name = match s.place {
                Place::Belt => "level with a belt",
                Place::Surface => "under the water surface",
                Place::Floor => "over the floor",
                Place::Wall => "at the wall",
                Place::Elsewhere => "elsewhere",
            };
            let _ = write!(
                t,
                "<tr><td>{name}</td><td>{}</td><td>{}</td>",
                percent(voxels, water as f64),
                percent(unseen, voxels)
            );
            if let Some(band) = self.bands.iter().find(|b| b.place == s.place) {
                let share = |x: Option<f64>| x.map_or("–".into(), |x| format!("{x:.3}"));
                let length = s.true_length_mm.unwrap_or(0.0);
                let _ = write!(
                    t,
                    "<td>{length:.0} mm</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td>",
                    percent(s.unseen_length_mm.unwrap_or(0.0), length),
                    share(band.recall),
                    band.points,
                    share(band.precision)
                );
            }
            t.push_str("</tr>\n");
        }
        t.push_str("</table>\n");
    }

    /// Root voxels projected along an axis, as SVG; `low` to `high` is the range of the downward coordinate.
    fn projection(&self, across: usize, down: usize, low: f64, high: f64) -> String {
        let far = self.tank.inner_radius_mm();
        let mut svg =
            format!("<svg viewBox=\"{:.1} {low:.1} {:.1} {:.1}\" width=\"340\">", -far, 2.0 * far, high - low);
        let step = self.roots.len().div_ceil(MOST_DRAWN).max(1);
        let radius = self.grid.spacing_mm * 0.6;
        for (place, piece) in self.roots.iter().step_by(step) {
            let [r, g, b] = palette::distinct(*piece as usize);
            let _ = write!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
                place[across], place[down]
            );
        }
        svg + "</svg>"
    }
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    #[test]
    fn names_are_escaped_and_every_overlay_is_shown() {
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 120.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let grid = Grid::of_tank(&tank, 1.0, 100.0).unwrap();
        let page = Page {
            name: "a<b>",
            tank: &tank,
            grid: &grid,
            roots: &[([1.0, 2.0, 3.0], 0)],
            score: None,
            sight: &[
                Sight {
                    place: Place::Wall,
                    voxels: 40,
                    unseen: 10,
                    true_length_mm: Some(8.0),
                    unseen_length_mm: Some(2.0),
                },
                Sight { place: Place::Floor, voxels: 0, unseen: 0, true_length_mm: None, unseen_length_mm: None },
            ],
            bands: &[Band { place: Place::Wall, true_length_mm: 9.0, recall: Some(0.75), points: 7, precision: None }],
            settings: &[("merge".into(), "{}".into())],
            warnings: &["few views".into()],
            spread_px: Some(0.436),
            overlays: &["overlays/000.jpg".into(), "overlays/001.jpg".into()],
        };
        let html = page.html();
        assert!(html.contains("a&lt;b&gt;") && !html.contains("a<b>") && html.contains("few views"));
        assert!(html.contains("a point spread of 0.44 px"));
        assert_eq!(html.matches("<img").count(), 2);
        assert!(
            html.contains(
                "<td>at the wall</td><td>100.0 %</td><td>25.0 %</td><td>8 mm</td><td>25.0 %</td><td>0.750</td>"
            )
        );
        assert!(!html.contains("over the floor"));
        assert_eq!(html.matches("<circle").count(), 3);
    }
}
