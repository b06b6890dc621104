//! Strands that arch over the crown are two roots.
//!
//! Two roots that leave the crown to either side may be linked over its top into one strand. Roots grow away from the crown: a
//! strand whose highest point lies near the top of all that was traced, above both of its ends by more than `window_mm`, is
//! cut there where it turns by more than 60 degrees between the chords over `window_mm` to either side: a root that rises and
//! sinks again bends gently.

use super::bridge::Workshop;
use super::repair::{Kind, Repair};
use super::strand::{End, Strand};

/// What begins within this share of the whole depth below the uppermost is near the top: belts hide the crown.
pub const NEAR_TOP: f64 = 0.15;

/// Least turn over the crown, degrees.
const SHARP_DEG: f64 = 60.0;

/// The strands, those that arch over the crown cut at their highest points.
pub fn part(strands: Vec<Strand>, window_mm: f64, workshop: &Workshop<'_>, log: &mut Vec<Repair>) -> Vec<Strand> {
    let depths = || strands.iter().flat_map(|s| s.knots.iter().map(|k| k[2]));
    let (top, bottom) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let mut parted = Vec::with_capacity(strands.len());
    for strand in strands {
        let z = |n: usize| workshop.points[strand.points[n]].position_mm.z;
        let last = strand.points.len() - 1;
        let apex = (0..=last).min_by(|&a, &b| z(a).total_cmp(&z(b))).unwrap_or(0);
        let is_arch = z(apex) <= top + NEAR_TOP * (bottom - top) && z(0).min(z(last)) > z(apex) + window_mm;
        let place = workshop.points[strand.points[apex]].position_mm;
        let knot = strand.nearest(&place).0;
        let [back, on] = End::BOTH.map(|end| strand.direction_into(knot, end, window_mm));
        let turn_deg = match (back, on) {
            (Some(back), Some(on)) if is_arch => (-back.dot(&on)).clamp(-1.0, 1.0).acos().to_degrees(),
            _ => 0.0,
        };
        if turn_deg <= SHARP_DEG {
            parted.push(strand);
            continue;
        }
        let reason = format!("arches over the crown, turning by {turn_deg:.0} degrees: taken for two roots");
        log.push(Repair::new(Kind::Split, &place, 0.0, reason));
        parted.push(workshop.strand(strand.points[..=apex].to_vec()));
        parted.push(workshop.strand(strand.points[apex..].to_vec()));
    }
    parted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Vec3;
    use crate::roots::ridge::{Field, RidgePoint};
    use crate::volume::Grid;
    use ndarray::Array3;

    /// Lengths of what becomes of a strand through these corners, with another one far below.
    fn lengths(corners: &[Vec3]) -> Vec<f64> {
        let (mut points, mut chains) = (Vec::new(), Vec::new());
        for way in [corners, &[Vec3::new(50.0, 0.0, 20.0), Vec3::new(50.0, 0.0, 120.0)]] {
            let first = points.len();
            for leg in way.windows(2) {
                let (step, n) = (leg[1] - leg[0], ((leg[1] - leg[0]).norm() / 0.5).round() as usize);
                points.extend((0..n).map(|k| RidgePoint {
                    position_mm: leg[0] + step * (k as f64 / n as f64),
                    tangent: step.normalize(),
                    rootness: 1.0,
                    sigma_mm: 0.3,
                    strong: true,
                }));
            }
            chains.push((first..points.len()).collect::<Vec<_>>());
        }
        let rootness = Array3::zeros((2, 2, 2));
        let grid = Grid { origin_mm: [0.0; 3], spacing_mm: 0.5, shape: [2, 2, 2] };
        let field = Field { grid, rootness: rootness.view() };
        let workshop = Workshop { points: &points, field, step_mm: 0.5, wavelength_mm: 6.0, link_mm: 1.3 };
        let strands = chains.into_iter().map(|chain| workshop.strand(chain)).collect();
        let mut log = Vec::new();
        let parted = part(strands, 6.0, &workshop, &mut log);
        assert_eq!(parted.len(), 2 + log.len());
        parted[..parted.len() - 1].iter().map(Strand::length_mm).collect()
    }

    #[test]
    fn only_arches_over_the_crown_are_cut() {
        let (left, crown, right) = (Vec3::new(-30.0, 0.0, 40.0), Vec3::new(0.0, 0.0, 20.0), Vec3::new(0.0, 0.0, 110.0));
        let halves = lengths(&[left, crown, right]);
        assert_eq!(halves.len(), 2);
        assert!((halves[0] - 36.0).abs() < 2.0 && (halves[1] - 90.0).abs() < 2.0, "{halves:?}");
        // A root that hangs from the crown, one whose other end is hardly lower, a gentle arch, and one far below.
        for whole in [
            vec![crown, right],
            vec![Vec3::new(-20.0, 0.0, 24.0), crown, right],
            vec![Vec3::new(-40.0, 0.0, 40.0), crown, Vec3::new(40.0, 0.0, 30.0)],
            vec![Vec3::new(-30.0, 0.0, 90.0), Vec3::new(0.0, 0.0, 60.0), right],
        ] {
            assert_eq!(lengths(&whole).len(), 1, "{whole:?}");
        }
    }
}
