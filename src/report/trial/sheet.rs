//! All plants from the side, in one scale; a plant's days stand beside each other.

use super::Page;
use crate::optics::Tank;
use crate::report::page::html::escape;
use crate::roots::{Root, ink};
use imageproc::geometry::approximate_polygon_dp;
use imageproc::point::Point;
use std::fmt::Write;

/// Lines are drawn within this of their points, mm.
const TOLERANCE_MM: f64 = 0.3;
const MARGIN_MM: f64 = 2.0;

/// The section with a picture per capture.
pub(super) fn section(page: &Page<'_>, t: &mut String) {
    let known = || page.captures.iter().filter_map(|c| Some((c, c.known.as_ref().ok()?)));
    let scale = Scale::of(known().map(|(_, k)| k.tank));
    t.push_str(
        "<section><h2>All plants</h2>\n<p>From the side (x and z), all in one scale, coloured by order; a picture leads to the plant’s own \
         page.</p>\n<div class=\"sheet\">\n",
    );
    for (c, known) in known() {
        let _ = write!(t, "<figure><a href=\"{}\">", escape(&c.link));
        scale.open(known.tank, &format!("aria-label=\"Roots of {}\"", escape(&c.title())), t);
        let radius = known.tank.inner_radius_mm();
        let (level, width) = (known.tank.water_level_mm, 2.0 * radius);
        let _ = write!(t, "<path class=\"water\" d=\"M{:.1} {level:.1}h{width:.1}\"/>", -radius);
        for traced in known.system.roots.iter().filter(|r| r.root.points_mm.len() > 1) {
            line(&traced.root, ink::by_order(&traced.root), t);
        }
        let groups: Vec<String> = c.groups.iter().filter(|g| !g.is_empty()).map(|g| escape(g)).collect();
        let _ = writeln!(
            t,
            "</svg></a><figcaption>{}{}{}</figcaption></figure>",
            c.linked(),
            if groups.is_empty() { "" } else { "<br>" },
            groups.join(", ")
        );
    }
    t.push_str("</div>\n</section>\n");
}

/// One scale for all pictures: each is as wide and as high as the largest tank.
pub(super) struct Scale {
    far_mm: f64,
    pub(super) deep_mm: f64,
}

impl Scale {
    /// Of these tanks.
    pub(super) fn of<'a>(tanks: impl Iterator<Item = &'a Tank>) -> Self {
        tanks.fold(Self { far_mm: 0.0, deep_mm: 0.0 }, |most, tank| Self {
            far_mm: most.far_mm.max(tank.inner_radius_mm()),
            deep_mm: most.deep_mm.max(tank.floor_mm()),
        })
    }

    /// Opens a picture, which has these attributes too, with the outline of a tank.
    pub(super) fn open(&self, tank: &Tank, attributes: &str, t: &mut String) {
        let (radius, floor) = (tank.inner_radius_mm(), tank.floor_mm());
        let _ = write!(
            t,
            "<svg role=\"img\" {attributes} viewBox=\"{:.1} {:.1} {:.1} {:.1}\">\
             <rect class=\"tank\" x=\"{:.1}\" y=\"0\" width=\"{:.1}\" height=\"{floor:.1}\"/>",
            -self.far_mm - MARGIN_MM,
            -MARGIN_MM,
            2.0 * (self.far_mm + MARGIN_MM),
            self.deep_mm + 2.0 * MARGIN_MM,
            -radius,
            2.0 * radius,
        );
    }
}

/// A root from the side, x and z.
pub(super) fn line(root: &Root, [r, g, b]: [u8; 3], t: &mut String) {
    let curve: Vec<Point<f64>> = root.points_mm.iter().map(|p| Point::new(p[0], p[2])).collect();
    let points = approximate_polygon_dp(&curve, TOLERANCE_MM, false);
    let line: Vec<String> = points.iter().map(|p| format!("{:.1} {:.1}", p.x, p.y)).collect();
    let width = 2.0 * root.radii_mm.iter().sum::<f64>() / root.radii_mm.len() as f64;
    let _ = write!(
        t,
        "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{:.2}\" d=\"M{}\"/>",
        width.max(0.6),
        line.join(" ")
    );
}
