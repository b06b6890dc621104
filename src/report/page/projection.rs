//! The roots from two sides and from above as SVG: what paper shows, and browsers without script or WebGL.

use crate::optics::Tank;
use crate::roots::{Root, ink};
use imageproc::geometry::approximate_polygon_dp;
use imageproc::point::Point;
use std::fmt::Write;

/// Lines are drawn within this of their points, mm.
const TOLERANCE_MM: f64 = 0.15;
const MARGIN_MM: f64 = 2.0;

/// From the front: x goes across, z down.
pub const FRONT: [usize; 2] = [0, 2];

/// The three projections, coloured by order.
pub fn sides(tank: &Tank, roots: &[Root]) -> String {
    let mut t = String::new();
    for (title, axes) in
        [("From the side, x and z", FRONT), ("From the side, y and z", [1, 2]), ("From above, x and y", [0, 1])]
    {
        let svg = side(tank, roots, axes, &format!("Roots: {title}"), |n| ink::by_order(&roots[n]));
        let _ = writeln!(t, "<figure>{svg}<figcaption>{title}</figcaption></figure>");
    }
    t
}

/// One projection as SVG: which coordinates go across and down, what it is called, and the colour of the root at a place of the list.
pub fn side(
    tank: &Tank,
    roots: &[Root],
    [across, down]: [usize; 2],
    label: &str,
    colour: impl Fn(usize) -> [u8; 3],
) -> String {
    let far = tank.inner_radius_mm();
    let (low, high) = if down == 2 { (0.0, tank.floor_mm()) } else { (-far, far) };
    let mut t = format!(
        "<svg role=\"img\" aria-label=\"{}\" viewBox=\"{:.1} {:.1} {:.1} {:.1}\">",
        super::html::escape(label),
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
    for (n, root) in roots.iter().enumerate().filter(|(_, root)| !root.points_mm.is_empty()) {
        let [r, g, b] = colour(n);
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
    t + "</svg>"
}
