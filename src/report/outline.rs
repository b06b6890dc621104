//! The tank's outline drawn on a photograph, with the edges that were seen.  Paper 2.2.3, figure 2.
//!
//! Rims and sides of the registered tank are thin lines; each edge point is a dot from which a line shows by how much,
//! and where to, the registered edge lies off, [`MAGNIFIED`] times as long as it is. Pixels are the photograph's own,
//! lens distortion left in.

use crate::calibration::Edge;
use crate::optics::{Tank, Vec3, View};
use ndarray::Array3;

/// How much longer than they are misses are drawn.
pub const MAGNIFIED: f64 = 30.0;

const TANK: [u8; 3] = [64, 200, 255];
const SEEN: [u8; 3] = [255, 220, 40];
const MISS: [u8; 3] = [255, 60, 60];

/// Draws on `photo` (y, x, rgb); `radius_mm` is that of the surface whose outline is drawn.
pub fn draw(photo: &mut Array3<u8>, view: &View, tank: &Tank, radius_mm: f64, edges: &[Edge]) {
    let pixel = |x: &Vec3| {
        let c = view.rotation * x + view.translation_mm;
        (c.z > 1e-6).then(|| view.lens.pixel(c.x / c.z, c.y / c.z))
    };
    let on = |azimuth: f64, z: f64| Vec3::new(radius_mm * azimuth.cos(), radius_mm * azimuth.sin(), z);
    let mut path = |points: &mut dyn Iterator<Item = Vec3>| {
        let mut last = None;
        for x in points {
            let here = pixel(&x);
            if let (Some(a), Some(b)) = (last, here) {
                line(photo, a, b, TANK);
            }
            last = here;
        }
    };
    let bands = tank.belts_mm.iter().flatten().copied();
    for z in [0.0, tank.height_mm].into_iter().chain(bands) {
        path(&mut (0..=180).map(|k| on(std::f64::consts::TAU * f64::from(k) / 180.0, z)));
    }
    // The lines along which sight grazes the wall.
    let centre = view.centre_in_tank();
    let (toward, distance) = (centre.y.atan2(centre.x), centre.x.hypot(centre.y));
    if distance > radius_mm {
        for side in [-1.0, 1.0] {
            let azimuth = toward + side * (radius_mm / distance).acos();
            path(&mut (0..=40).map(|k| on(azimuth, tank.height_mm * f64::from(k) / 40.0)));
        }
    }
    for e in edges {
        let end = (e.u + MAGNIFIED * e.miss_px[0], e.v + MAGNIFIED * e.miss_px[1]);
        line(photo, (e.u, e.v), end, MISS);
        for (dx, dy) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0), (0.0, -1.0), (0.0, 1.0)] {
            dot(photo, e.u + dx, e.v + dy, SEEN);
        }
    }
}

fn dot(photo: &mut Array3<u8>, u: f64, v: f64, colour: [u8; 3]) {
    let (h, w, _) = photo.dim();
    let (x, y) = (u.round(), v.round());
    if x >= 0.0 && y >= 0.0 && x < w as f64 && y < h as f64 {
        for (c, value) in colour.into_iter().enumerate() {
            photo[(y as usize, x as usize, c)] = value;
        }
    }
}

/// A line one pixel wide, at most a picture's diagonal long.
fn line(photo: &mut Array3<u8>, a: (f64, f64), b: (f64, f64), colour: [u8; 3]) {
    let (h, w, _) = photo.dim();
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    if !length.is_finite() {
        return;
    }
    let steps = (2.0 * length.min((w as f64).hypot(h as f64))).ceil().max(1.0);
    for k in 0..=steps as usize {
        let t = k as f64 * 0.5 / length.max(0.5);
        dot(photo, a.0 + t.min(1.0) * (b.0 - a.0), a.1 + t.min(1.0) * (b.1 - a.1), colour);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{Distortion, Index, Lens, Mat3};

    #[test]
    fn rims_sides_and_edges_are_drawn_where_they_are() {
        let lens =
            Lens { width: 200, height: 200, focal_px: 300.0, cx: 99.5, cy: 99.5, distortion: Distortion::default() };
        // Camera on +x at half the height, looking along -x; right is +y... down is +z.
        let rotation = Mat3::new(0.0, -1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0);
        let view = View { lens, rotation, translation_mm: -(rotation * Vec3::new(300.0, 0.0, 60.0)) };
        let tank = Tank {
            radius_mm: 40.0,
            height_mm: 120.0,
            wall_mm: 3.0,
            water_level_mm: 5.0,
            index: Index::default(),
            belts_mm: vec![],
        };
        let mut photo = Array3::zeros((200, 200, 3));
        let edges = [
            Edge { view: 0, u: 100.0, v: 60.0, miss_px: [0.0, 0.5] },
            Edge { view: 0, u: -5.0, v: 1e9, miss_px: [f64::NAN, 0.0] },
        ];
        draw(&mut photo, &view, &tank, 40.0, &edges);
        let is = |x: usize, y: usize, c: [u8; 3]| (0..3).all(|k| photo[(y, x, k)] == c[k]);
        // The side line at half the height: tan = 40 / sqrt(300² - 40²).
        let side = 99.5 + 300.0 * 40.0 / (300.0_f64.powi(2) - 1600.0).sqrt();
        assert!(is(side.round() as usize, 100, TANK));
        // The near rim in the middle: 60 mm above at 260 mm.
        assert!(is(100, (99.5_f64 - 300.0 * 60.0 / 260.0).round() as usize, TANK));
        assert!(is(100, 60, SEEN) && is(100, 72, MISS) && !is(100, 80, MISS));
    }
}
