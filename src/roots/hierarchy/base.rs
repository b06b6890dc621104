//! Which piece the plant stands on.

use super::attach::Hang;
use super::{HierarchyParams, Line};
use crate::roots::strand::End;

/// Stretch below a piece's upper end that is judged, mm: some diameters of a taproot.
const STRETCH_MM: f64 = 30.0;
/// Pieces that begin within this share of the whole depth below the uppermost may be the base: belts hide the crown.
const NEAR_TOP: f64 = 0.15;

/// The upper end of a piece.
pub fn upper(line: &Line<'_>) -> End {
    if line.at(0).z <= line.at(line.last()).z { End::First } else { End::Last }
}

/// The piece near the top whose first stretch has the largest radius × vertical extent; none without pieces.
pub fn base(lines: &[Line<'_>]) -> Option<usize> {
    let depths = || lines.iter().flat_map(|l| l.piece.root.points_mm.iter().map(|p| p[2]));
    let (high, low) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    let score = |line: &Line<'_>| {
        let end = upper(line);
        let top = if end == End::First { 0 } else { line.last() };
        let to = line.beyond(top, end.other(), STRETCH_MM);
        line.typical_radius_mm(top, to) * (line.at(to).z - line.at(top).z).max(0.0)
    };
    let begins = |line: &Line<'_>| line.at(0).z.min(line.at(line.last()).z);
    (0..lines.len())
        .filter(|&k| begins(&lines[k]) <= high + NEAR_TOP * (low - high))
        .max_by(|&a, &b| score(&lines[a]).total_cmp(&score(&lines[b])).then(b.cmp(&a)))
}

/// Climbs from the base on to pieces that hang on its upper end and lead on upwards at its thickness: the uppermost is the
/// base, and what was hangs on it. Gives the base.
pub fn climb(lines: &[Line<'_>], hangs: &mut [Hang], mut base: usize, params: &HierarchyParams) -> usize {
    for _ in 0..lines.len() {
        let line = &lines[base];
        let top = if upper(line) == End::First { 0 } else { line.last() };
        let radius = line.typical_radius_mm(top, line.beyond(top, upper(line).other(), STRETCH_MM));
        let leads_on = |n: usize| match hangs[n] {
            Hang::On { parent, parent_point, point } if parent == base => {
                let other = &lines[n];
                let far = if point == 0 { other.last() } else { 0 };
                let ratio = (other.typical_radius_mm(0, other.last()) / radius).ln() / params.thinner;
                (point == 0 || point == other.last())
                    && (line.arc_mm[parent_point] - line.arc_mm[top]).abs() <= radius
                    && line.at(top).z - other.at(far).z > 0.7 * other.length_mm()
                    && ratio.abs() < 2.0
            }
            _ => false,
        };
        let Some(next) = (0..lines.len()).find(|&n| leads_on(n)) else { break };
        if let Hang::On { parent_point, point, .. } = hangs[next] {
            hangs[base] = Hang::On { parent: next, parent_point: point, point: parent_point };
            hangs[next] = Hang::Free;
        }
        base = next;
    }
    base
}
