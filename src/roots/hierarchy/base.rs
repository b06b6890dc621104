//! Which piece the plant stands on.
//!
//! Pieces that begin near the top are tried in turn: each way that the base root would take from there is weighed by the area it
//! covers seen from the side, going down: ∫ r dz. The taproot is thick and leads down; a way that begins on it higher up weighs
//! more than one that begins below a gap.

use super::Line;
use super::part::Part;
use crate::roots::crown::NEAR_TOP;
use crate::roots::strand::End;

/// Stretch below a piece's upper end that is judged, mm: some diameters of a taproot.
const STRETCH_MM: f64 = 30.0;
/// Pieces that are tried: where several ridges meet, which of them holds the taproot's top is chance. More cost time alone.
const TRIED: usize = 64;

/// The upper end of a piece.
pub fn upper(line: &Line<'_>) -> End {
    if line.at(0).z <= line.at(line.last()).z { End::First } else { End::Last }
}

/// The pieces to be tried: those near the top whose first stretches have the largest radius × vertical extent, largest first;
/// none without pieces.
pub fn candidates(lines: &[Line<'_>]) -> Vec<usize> {
    let top_mm = near_top_mm(lines);
    let score = |line: &Line<'_>| {
        let end = upper(line);
        let top = if end == End::First { 0 } else { line.last() };
        let to = line.beyond(top, end.other(), STRETCH_MM);
        line.typical_radius_mm(top, to) * (line.at(to).z - line.at(top).z).max(0.0)
    };
    let begins = |line: &Line<'_>| line.at(0).z.min(line.at(line.last()).z);
    let mut near: Vec<usize> = (0..lines.len()).filter(|&k| begins(&lines[k]) <= top_mm).collect();
    near.sort_by(|&a, &b| score(&lines[b]).total_cmp(&score(&lines[a])).then(a.cmp(&b)));
    near.truncate(TRIED);
    near
}

/// Depth down to which something is near the top of what is seen, mm.
pub fn near_top_mm(lines: &[Line<'_>]) -> f64 {
    let depths = || lines.iter().flat_map(|l| l.piece.root.points_mm.iter().map(|p| p[2]));
    let (high, low) = (depths().fold(f64::INFINITY, f64::min), depths().fold(f64::NEG_INFINITY, f64::max));
    high + NEAR_TOP * (low - high)
}

/// The area that a way covers seen from the side where it leads down, mm², and how far that is, mm.
pub fn seen_from_side(lines: &[Line<'_>], way: &[Part]) -> (f64, f64) {
    let of = |part: &Part| {
        let line = &lines[part.piece];
        let (from, to, down) =
            if part.from <= part.to { (part.from, part.to, 1.0) } else { (part.to, part.from, -1.0) };
        (from..to).fold((0.0, 0.0), |(area, depth), k| {
            let dz = (down * (line.at(k + 1).z - line.at(k).z)).max(0.0);
            (area + dz * 0.5 * (line.radius_mm(k) + line.radius_mm(k + 1)), depth + dz)
        })
    };
    way.iter().map(of).fold((0.0, 0.0), |sum, part| (sum.0 + part.0, sum.1 + part.1))
}
