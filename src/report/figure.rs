//! A figure for papers: the roots from two sides and from above, to one scale, on white, with a scale bar; SVG in mm of paper.
//!
//! Lines are as wide as the roots, at least `LEAST_PT`; what is nearer is drawn over what is farther. Roots are coloured by order (Okabe and
//! Ito's colours without those that white swallows), or along viridis without its lightest end by diameter or depth: maps that colour-blind
//! eyes read. Equal values give equal bytes.

use crate::optics::Tank;
use crate::roots::{Root, curve};
use std::fmt::Write;

/// What colours tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    /// The branching order.
    Order,
    /// The diameter, mm.
    Diameter,
    /// The depth under the water surface, mm.
    Depth,
}

/// A figure.
#[derive(Debug, Clone, Copy)]
pub struct Figure<'a> {
    /// The tank.
    pub tank: &'a Tank,
    /// The roots.
    pub roots: &'a [Root],
    /// What colours tell.
    pub colour: Colour,
    /// Width on paper, mm.
    pub width_mm: f64,
    /// Size of the letters, points.
    pub font_pt: f64,
}

/// Thinnest line, points: printers lose thinner ones.
const LEAST_PT: f64 = 0.25;
const MM_PER_PT: f64 = 25.4 / 72.0;
/// Space between panels and about the figure, mm of paper.
const GAP_MM: f64 = 3.0;
/// Length of a stretch of one colour and width, mm of root.
const STRETCH_MM: f64 = 1.5;
/// Room below the deepest root, mm of the tank.
const BELOW_MM: f64 = 4.0;
/// From order 0 on; what is later has the last.
const ORDERS: [[u8; 3]; 6] = [[0, 0, 0], [213, 94, 0], [0, 114, 178], [0, 158, 115], [204, 121, 167], [86, 180, 233]];
const VIRIDIS: [[u8; 3]; 7] =
    [[68, 1, 84], [70, 50, 127], [54, 92, 141], [39, 127, 142], [31, 161, 135], [74, 194, 109], [159, 218, 58]];

/// A panel: its title, the coordinates that go across and down, and the one along which it looks, with 1 where that grows towards us.
type Panel = (&'static str, usize, usize, (usize, f64));
const PANELS: [Panel; 3] = [("x, z", 0, 2, (1, 1.0)), ("y, z", 1, 2, (0, -1.0)), ("x, y", 0, 1, (2, -1.0))];

/// A stretch of a root: its points in space and what is drawn of it.
struct Stretch {
    points_mm: Vec<[f64; 3]>,
    diameter_mm: f64,
    colour: [u8; 3],
}

impl Figure<'_> {
    /// The figure as SVG.
    pub fn svg(&self) -> String {
        let (far, font) = (self.tank.inner_radius_mm(), self.font_pt * MM_PER_PT);
        let deepest =
            self.roots.iter().flat_map(|r| &r.points_mm).map(|p| p[2]).fold(self.tank.water_level_mm, f64::max);
        let bottom = (deepest + BELOW_MM).min(self.tank.floor_mm());
        let panels = PANELS.len() as f64;
        let scale = (self.width_mm - GAP_MM * (panels + 1.0)) / (2.0 * far * panels);
        let (top, tall) = (GAP_MM + 1.4 * font, scale * bottom.max(2.0 * far));
        let height = top + tall + GAP_MM + 3.6 * font + GAP_MM;
        let mut t = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0:.2}mm\" height=\"{1:.2}mm\" viewBox=\"0 0 {0:.2} {1:.2}\" \
             font-family=\"sans-serif\" font-size=\"{font:.3}\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
            self.width_mm, height
        );
        let range = self.range();
        let mut stretches: Vec<Stretch> = self.roots.iter().flat_map(|root| self.stretches(root, range)).collect();
        for (n, panel) in PANELS.iter().enumerate() {
            let left = GAP_MM + (2.0 * far * scale + GAP_MM) * n as f64;
            self.panel(panel, [left, top], scale, bottom, &mut stretches, &mut t);
        }
        let foot = top + tall + GAP_MM;
        self.scale_bar([GAP_MM, foot], scale, font, &mut t);
        self.legend([self.width_mm / 2.0, foot], range, font, &mut t);
        t + "</svg>\n"
    }

    fn panel(
        &self,
        &(title, across, down, (along, towards)): &Panel,
        [left, top]: [f64; 2],
        scale: f64,
        bottom: f64,
        stretches: &mut [Stretch],
        t: &mut String,
    ) {
        let far = self.tank.inner_radius_mm();
        let font = self.font_pt * MM_PER_PT;
        let (wide, above) = (2.0 * far * scale, if down == 2 { 0.0 } else { -far });
        let _ = writeln!(t, "<g><text x=\"{left:.2}\" y=\"{:.2}\">{title}</text>", top - 0.4 * font);
        let thin = "fill=\"none\" stroke=\"#888\" stroke-width=\"0.15\"";
        if down == 2 {
            let (water, end) = (top + scale * self.tank.water_level_mm, top + scale * bottom);
            let _ = writeln!(
                t,
                "<path {thin} d=\"M{left:.2} {top:.2}V{end:.2}M{0:.2} {top:.2}V{end:.2}\"/>\
                 <path {thin} stroke-dasharray=\"1 0.8\" d=\"M{left:.2} {water:.2}h{wide:.2}\"/>",
                left + wide
            );
        } else {
            let _ = writeln!(
                t,
                "<circle {thin} cx=\"{:.2}\" cy=\"{:.2}\" r=\"{:.2}\"/>",
                left + wide / 2.0,
                top + wide / 2.0,
                wide / 2.0
            );
        }
        // The far ones first.
        let depth =
            |s: &Stretch| towards * s.points_mm.iter().map(|p| p[along]).sum::<f64>() / s.points_mm.len() as f64;
        stretches.sort_by(|a, b| depth(a).total_cmp(&depth(b)));
        let _ = writeln!(t, "<g fill=\"none\" stroke-linecap=\"round\" stroke-linejoin=\"round\">");
        for s in stretches.iter() {
            let place = |p: &[f64; 3]| {
                format!("{:.2} {:.2}", left + scale * (p[across] + far), top + scale * (p[down] - above))
            };
            let line: Vec<String> = s.points_mm.iter().map(place).collect();
            let [r, g, b] = s.colour;
            let _ = writeln!(
                t,
                "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{:.3}\" d=\"M{}\"/>",
                (scale * s.diameter_mm).max(LEAST_PT * MM_PER_PT),
                line.join("L")
            );
        }
        t.push_str("</g></g>\n");
    }

    /// The root in stretches of one colour and width.
    fn stretches(&self, root: &Root, range: [f64; 2]) -> Vec<Stretch> {
        let arc = curve::chord_lengths(&root.points_mm);
        let (mut all, mut from) = (Vec::new(), 0);
        for k in 1..arc.len() {
            if arc[k] - arc[from] < STRETCH_MM && k + 1 < arc.len() {
                continue;
            }
            let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / (k + 1 - from) as f64;
            let diameter_mm = 2.0 * mean(&mut root.radii_mm[from..=k].iter().copied());
            let depth_mm = mean(&mut root.points_mm[from..=k].iter().map(|p| p[2])) - self.tank.water_level_mm;
            let colour = match self.colour {
                Colour::Order => of_order(root.order),
                Colour::Diameter => ramp((diameter_mm - range[0]) / (range[1] - range[0])),
                Colour::Depth => ramp((depth_mm - range[0]) / (range[1] - range[0])),
            };
            all.push(Stretch { points_mm: root.points_mm[from..=k].to_vec(), diameter_mm, colour });
            from = k;
        }
        all
    }

    /// What the ends of the ramp stand for, mm: outliers would take all of it.
    fn range(&self) -> [f64; 2] {
        let mut values: Vec<f64> = match self.colour {
            Colour::Order => return [0.0, 1.0],
            Colour::Diameter => self.roots.iter().flat_map(|r| &r.radii_mm).map(|r| 2.0 * r).collect(),
            Colour::Depth => {
                self.roots.iter().flat_map(|r| &r.points_mm).map(|p| p[2] - self.tank.water_level_mm).collect()
            }
        };
        values.sort_by(f64::total_cmp);
        let at =
            |share: f64| values.get((share * values.len().saturating_sub(1) as f64) as usize).copied().unwrap_or(0.0);
        [at(0.01), at(0.99).max(at(0.01) + 1e-6)]
    }

    fn scale_bar(&self, [x, y]: [f64; 2], scale: f64, font: f64, t: &mut String) {
        // The longest round length that takes at most the half of a panel.
        let most = self.tank.inner_radius_mm();
        let round = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0].into_iter().rfind(|l| *l <= most).unwrap_or(1.0);
        let (wide, line) = (scale * round, y + 0.5 * font);
        let _ = writeln!(
            t,
            "<path id=\"scale\" fill=\"none\" stroke=\"#000\" stroke-width=\"0.4\" d=\"M{x:.2} {line:.2}h{wide:.3}\"/>\
             <text x=\"{x:.2}\" y=\"{:.2}\">{round} mm</text>",
            line + 1.3 * font
        );
    }

    fn legend(&self, [x, y]: [f64; 2], [low, high]: [f64; 2], font: f64, t: &mut String) {
        let title = match self.colour {
            Colour::Order => {
                let mut orders: Vec<u32> = self.roots.iter().map(|r| r.order).collect();
                orders.sort_unstable();
                orders.dedup();
                for (n, order) in orders.iter().enumerate() {
                    let [r, g, b] = of_order(*order);
                    let left = x + 5.2 * font * n as f64;
                    let _ = writeln!(
                        t,
                        "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"0.8\" d=\"M{left:.2} {:.2}h{font:.2}\"/>\
                         <text x=\"{:.2}\" y=\"{:.2}\">order {order}</text>",
                        y + 0.5 * font,
                        left + 1.3 * font,
                        y + 0.85 * font
                    );
                }
                return;
            }
            Colour::Diameter => "diameter",
            Colour::Depth => "depth",
        };
        let wide = self.width_mm / 4.0;
        let steps = 8 * VIRIDIS.len();
        for k in 0..steps {
            let [r, g, b] = ramp(k as f64 / (steps - 1) as f64);
            let step = wide / steps as f64;
            // A little wider, so that no seam shows.
            let _ = writeln!(
                t,
                "<rect x=\"{:.3}\" y=\"{y:.2}\" width=\"{:.3}\" height=\"{font:.2}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
                x + step * k as f64,
                step * 1.2
            );
        }
        let digits = usize::from(high - low < 20.0);
        let under = y + 2.1 * font;
        let _ = writeln!(
            t,
            "<text x=\"{x:.2}\" y=\"{under:.2}\">{low:.digits$}</text><text x=\"{:.2}\" y=\"{under:.2}\" text-anchor=\"middle\">{title}, mm</text>\
             <text x=\"{:.2}\" y=\"{under:.2}\" text-anchor=\"end\">{high:.digits$}</text>",
            x + wide / 2.0,
            x + wide
        );
    }
}

fn of_order(order: u32) -> [u8; 3] {
    ORDERS[(order as usize).min(ORDERS.len() - 1)]
}

/// The colour at a share of the ramp, 0 to 1.
fn ramp(share: f64) -> [u8; 3] {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let k = (at as usize).min(VIRIDIS.len() - 2);
    std::array::from_fn(|c| {
        let (a, b) = (f64::from(VIRIDIS[k][c]), f64::from(VIRIDIS[k + 1][c]));
        (a + (at - k as f64) * (b - a)).round() as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Index;

    fn svg(colour: Colour, font_pt: f64) -> String {
        let tank = Tank {
            radius_mm: 43.0,
            height_mm: 130.0,
            wall_mm: 3.0,
            water_level_mm: 10.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let at = |k: usize| [0.0, 0.0, 20.0 + k as f64];
        let root = Root {
            id: 0,
            parent: -1,
            order: 1,
            points_mm: (0..=30).map(at).collect(),
            radii_mm: (0..=30).map(|k| 1.0 - 0.02 * f64::from(k)).collect(),
        };
        Figure { tank: &tank, roots: &[root], colour, width_mm: 252.0, font_pt }.svg()
    }

    #[test]
    fn the_scale_bar_is_true() {
        // Three panels of 80 mm and four gaps of 3 mm: one mm of paper per mm.
        let text = svg(Colour::Order, 8.0);
        assert!(text.contains("d=\"M3.00 ") && text.contains("h20.000\"") && text.contains(">20 mm</text>"), "{text}");
        assert!(text.contains("width=\"252.00mm\"") && text.contains(">order 1</text>") && text.contains("#d55e00"));
        // The root's base is 20 mm below the rim, and 2 mm wide there.
        let top = 3.0 + 1.4 * 8.0 * MM_PER_PT;
        assert!(
            text.contains(&format!("d=\"M43.00 {:.2}L", top + 20.0)) && text.contains("stroke-width=\"1.9"),
            "{text}"
        );
    }

    #[test]
    fn ramps_tell_what_their_ends_are() {
        let text = svg(Colour::Diameter, 8.0);
        assert!(text.contains(">diameter, mm<") && text.contains(">0.8<") && text.contains(">2.0<"), "{text}");
        assert!(svg(Colour::Depth, 8.0).contains(">depth, mm<"));
        assert!(svg(Colour::Depth, 16.0).contains("font-size=\"5.644\""));
        assert_eq!((ramp(-1.0), ramp(2.0)), (VIRIDIS[0], VIRIDIS[6]));
    }
}
