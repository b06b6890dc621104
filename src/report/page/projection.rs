//! The roots from two sides and from above as SVG: what paper shows, and browsers without script or WebGL.

use crate::optics::Tank;
use crate::roots::{RootSystem, ink};
use imageproc::geometry::approximate_polygon_dp;
use imageproc::point::Point;
use std::fmt::Write;

/// Lines are drawn within this of their points, mm.
const TOLERANCE_MM: f64 = 0.15;
const MARGIN_MM: f64 = 2.0;

/// The three projections, coloured by order.
pub fn sides(tank: &Tank, system: &RootSystem) -> String {
    let far = tank.inner_radius_mm();
    let mut t = String::new();
    for (title, across, down) in
        [("From the side, x and z", 0, 2), ("From the side, y and z", 1, 2), ("From above, x and y", 0, 1)]
    {
        let (low, high) = if down == 2 { (0.0, tank.floor_mm()) } else { (-far, far) };
        let _ = write!(
            t,
            "<figure><svg role=\"img\" aria-label=\"Roots: {title}\" viewBox=\"{:.1} {:.1} {:.1} {:.1}\">",
            -far - MARGIN_MM,
            low - MARGIN_MM,
            2.0 * (far + MARGIN_MM),
            high - low + 2.0 * MARGIN_MM
        );
        if down == 2 {
            let _ = write!(
                t,
                "<rect class=\"tank\" x=\"{:.1}\" y=\"{low:.1}\" width=\"{:.1}\" height=\"{:.1}\"/><path class=\"water\" d=\"M{:.1} {:.1}h{:.1}\"/>",
                -far,
                2.0 * far,
                high - low,
                -far,
                tank.water_level_mm,
                2.0 * far
            );
        } else {
            let _ = write!(t, "<circle class=\"tank\" r=\"{far:.1}\"/>");
        }
        for traced in &system.roots {
            let root = &traced.root;
            if root.points_mm.is_empty() {
                continue;
            }
            let [r, g, b] = ink::by_order(root);
            let curve: Vec<Point<f64>> = root.points_mm.iter().map(|p| Point::new(p[across], p[down])).collect();
            let points = approximate_polygon_dp(&curve, TOLERANCE_MM, false);
            let line: Vec<String> = points.iter().map(|p| format!("{:.1} {:.1}", p.x, p.y)).collect();
            let width = 2.0 * root.radii_mm.iter().sum::<f64>() / root.radii_mm.len() as f64;
            let _ = write!(
                t,
                "<path stroke=\"#{r:02x}{g:02x}{b:02x}\" stroke-width=\"{:.2}\" d=\"M{}\"/>",
                width.max(0.4),
                line.join(" ")
            );
        }
        let _ = writeln!(t, "</svg><figcaption>{title}</figcaption></figure>");
    }
    t
}
