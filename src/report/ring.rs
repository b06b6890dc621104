//! The ring of cameras around the tank, from above and from the side, as SVG.

use crate::optics::{Tank, Vec3, View};
use std::fmt::Write as _;

/// Side of a panel, px.
const PANEL: f64 = 460.0;
/// Length of the drawn line of sight, as a part of the panel.
const SIGHT: f64 = 0.06;

/// Cameras (dots with their lines of sight; every fifth by its number, from 0) and tank in true proportions: x to the right and
/// y down seen from above; distance from the axis to the right and depth down seen from the side.
pub fn svg(views: &[View], tank: &Tank) -> String {
    let centres: Vec<Vec3> = views.iter().map(View::centre_in_tank).collect();
    let sights: Vec<Vec3> = views.iter().map(|v| v.rotation.row(2).transpose()).collect();
    let reach = centres.iter().map(|c| c.xy().norm()).fold(tank.radius_mm, f64::max) * 1.12;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        2.0 * PANEL,
        PANEL + 30.0
    );
    let scale = PANEL / (2.0 * reach);
    let above = |x: &Vec3| (0.5 * PANEL + scale * x.x, 30.0 + 0.5 * PANEL + scale * x.y);
    let _ = writeln!(
        out,
        "<text x=\"8\" y=\"18\">from above: {} cameras, tank of {:.1} mm radius</text>",
        views.len(),
        tank.radius_mm
    );
    let (cx, cy) = above(&Vec3::zeros());
    for radius in [tank.radius_mm, tank.inner_radius_mm()] {
        let _ = writeln!(
            out,
            "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"{:.2}\" fill=\"none\" stroke=\"#2080c0\"/>",
            radius * scale
        );
    }
    // The side panel holds the tank and every camera, each at its distance from the axis.
    let low = centres.iter().map(|c| c.z).fold(tank.height_mm, f64::max);
    let high = centres.iter().map(|c| c.z).fold(0.0, f64::min);
    let (width, tall) = (reach + tank.radius_mm * 1.2, (low - high) * 1.15);
    let side_scale = (PANEL / width).min(PANEL / tall);
    let top = 30.0 + 0.5 * (PANEL - side_scale * (low - high));
    let side = |rho: f64, z: f64| (PANEL + side_scale * (rho + tank.radius_mm * 1.1), top + side_scale * (z - high));
    let _ = writeln!(
        out,
        "<text x=\"{}\" y=\"18\">from the side: distance from the axis, depth below the rim</text>",
        PANEL + 8.0
    );
    let mut band = |from: f64, to: f64, style: &str| {
        let ((x0, y0), (x1, y1)) = (side(-tank.radius_mm, from), side(tank.radius_mm, to));
        let _ = writeln!(
            out,
            "<rect x=\"{x0:.1}\" y=\"{y0:.1}\" width=\"{:.1}\" height=\"{:.1}\" {style}/>",
            x1 - x0,
            y1 - y0
        );
    };
    band(tank.water_level_mm, tank.floor_mm(), "fill=\"#d8ecf8\"");
    for belt in &tank.belts_mm {
        band(belt[0], belt[1], "fill=\"#999999\"");
    }
    band(0.0, tank.height_mm, "fill=\"none\" stroke=\"#2080c0\"");
    for (k, (c, sight)) in centres.iter().zip(&sights).enumerate() {
        let rho = c.xy().norm();
        let outward = if rho > 0.0 { c.xy() / rho } else { c.xy() };
        let long = SIGHT * PANEL;
        let flat = (sight.xy().dot(&outward), sight.z);
        for ((x, y), (dx, dy)) in [(above(c), (sight.x, sight.y)), (side(rho, c.z), flat)] {
            let _ = writeln!(
                out,
                "<path d=\"M{x:.1} {y:.1}l{:.1} {:.1}\" stroke=\"#e08020\"/><circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"2.5\" fill=\"#c03020\"/>",
                long * dx,
                long * dy
            );
        }
        if k % 5 == 0 {
            let (x, y) = above(&(c * 1.05));
            let _ = writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{k}</text>");
        }
    }
    out + "</svg>\n"
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Distortion, Index, Lens, Mat3};

    #[test]
    fn every_camera_is_drawn_twice() {
        let lens =
            Lens { width: 200, height: 200, focal_px: 300.0, cx: 99.5, cy: 99.5, distortion: Distortion::default() };
        let rotation = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
        let view = |z: f64| View { lens, rotation, translation_mm: -(rotation * Vec3::new(-300.0, 0.0, z)) };
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 120.0,
            wall_mm: 3.0,
            water_level_mm: 5.0,
            index: Index::default(),
            belts_mm: vec![[0.0, 20.0]],
        };
        let text = svg(&[view(50.0), view(60.0)], &tank);
        assert_eq!(text.matches("r=\"2.5\"").count(), 4);
        assert!(!text.contains("NaN") && text.ends_with("</svg>\n"));
    }
}
