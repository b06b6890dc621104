//! Moves an added line onto the evidence: the crest of the rootness across it.
//!
//! Noise has crests too, everywhere. One counts only from `FLOOR` times the median rootness along the traced roots on, so that a
//! line over empty water stays where it was drawn.

use crate::optics::Vec3;
use crate::roots::{Field, TracedRoot, curve};

/// A crest of less than this share of a traced root's usual rootness is noise: a little more than where tracing itself stops following.
const FLOOR: f64 = 0.2;
/// Wavelength under which an added root does not bend, in steps between its points.
const SMOOTH_STEPS: f64 = 6.0;
/// Steps of the search for the crest, in each direction across the root.
const CREST_STEPS: i32 = 4;

/// The rootness, and from which on it is a root's.
#[derive(Debug)]
pub struct Evidence<'a> {
    /// The rootness.
    pub field: Field<'a>,
    /// Less is noise; infinite where no root tells.
    pub floor: f64,
}

impl<'a> Evidence<'a> {
    /// The rootness, judged by that along the traced roots.
    pub fn new(field: Field<'a>, roots: &[TracedRoot]) -> Self {
        let points = roots.iter().flat_map(|r| &r.root.points_mm);
        let mut along: Vec<f64> = points.map(|p| field.at(&Vec3::from(*p))).filter(|r| r.is_finite()).collect();
        along.sort_by(f64::total_cmp);
        let floor = along.get(along.len() / 2).filter(|r| **r > 0.0).map_or(f64::INFINITY, |median| FLOOR * median);
        Self { field, floor }
    }

    /// The line with each point moved across it onto the crest within `snap_mm`, smoothed where it moved; and the share of its points,
    /// 0 to 1, that found one.
    pub fn snapped(&self, line: &[[f64; 3]], step_mm: f64, snap_mm: f64) -> (Vec<[f64; 3]>, f64) {
        let at = |k: usize| Vec3::from(line[k]);
        let crests: Vec<Option<Vec3>> = (0..line.len())
            .map(|k| {
                let ahead = at((k + 1).min(line.len() - 1)) - at(k.saturating_sub(1));
                self.crest(&at(k), &ahead, snap_mm)
            })
            .collect();
        let found = crests.iter().flatten().count();
        if found == 0 {
            return (line.to_vec(), 0.0);
        }
        let moved: Vec<[f64; 3]> =
            crests.iter().zip(line).map(|(crest, p)| crest.map_or(*p, <[f64; 3]>::from)).collect();
        (curve::smooth(&moved, step_mm, SMOOTH_STEPS * step_mm), found as f64 / line.len() as f64)
    }

    /// The place of the greatest rootness across a direction, where that is a root's.
    fn crest(&self, at: &Vec3, ahead: &Vec3, snap_mm: f64) -> Option<Vec3> {
        let ahead = ahead.try_normalize(1e-12)?;
        let side = if ahead.x.abs() < 0.9 { Vec3::x() } else { Vec3::y() };
        let u = ahead.cross(&side).normalize();
        let v = ahead.cross(&u);
        let mut best: Option<(f64, Vec3)> = None;
        for i in -CREST_STEPS..=CREST_STEPS {
            for j in -CREST_STEPS..=CREST_STEPS {
                let (i, j) = (f64::from(i) / f64::from(CREST_STEPS), f64::from(j) / f64::from(CREST_STEPS));
                if i * i + j * j > 1.0 {
                    continue;
                }
                let p = at + (u * i + v * j) * snap_mm;
                let value = self.field.at(&p);
                if value >= self.floor && best.is_none_or(|(most, _)| value > most) {
                    best = Some((value, p));
                }
            }
        }
        best.map(|(_, p)| p)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roots::Root;
    use crate::volume::Grid;

    /// Noise of a twentieth of a root's rootness everywhere, and one root along z.
    #[test]
    fn a_line_over_empty_water_does_not_move() {
        let grid = Grid { origin_mm: [0.0; 3], spacing_mm: 0.5, shape: [41, 61, 61] };
        let noise = |k: usize, j: usize, i: usize| ((k * 73 + j * 179 + i * 283) % 97) as f64 / 97.0;
        let rootness = ndarray::Array3::from_shape_fn((41, 61, 61), |(k, j, i)| {
            let p = grid.point_mm(k as f64, j as f64, i as f64);
            ((-((p.x - 5.0).powi(2) + (p.y - 5.0).powi(2))).exp() + 0.05 * noise(k, j, i)) as f32
        });
        let line = |x: f64, y: f64| -> Vec<[f64; 3]> { (0..40).map(|k| [x, y, 0.5 * f64::from(k)]).collect() };
        let field = || Field { grid, rootness: rootness.view() };
        let points_mm = line(5.0, 5.0);
        let n = points_mm.len();
        let traced = TracedRoot {
            root: Root { id: 0, parent: -1, order: 0, radii_mm: vec![0.4; n], points_mm },
            radius_sd_mm: vec![0.0; n],
            views: vec![9; n],
            confidence: vec![1.0; n],
        };
        let evidence = Evidence::new(field(), &[traced]);
        let drawn = line(22.0, 20.0);
        assert_eq!(evidence.snapped(&drawn, 0.5, 1.0), (drawn, 0.0));
        let (moved, share) = evidence.snapped(&line(5.6, 5.0), 0.5, 1.0);
        assert!(share > 0.99 && moved.iter().all(|p| (p[0] - 5.0).hypot(p[1] - 5.0) < 0.2), "{share}: {moved:?}");
        // Where no root tells what one is like, nothing moves.
        let beside = line(5.6, 5.0);
        assert_eq!(Evidence::new(field(), &[]).snapped(&beside, 0.5, 1.0), (beside, 0.0));
    }
}
