//! What every piece hangs on.

use super::arborescence::{Edge, arborescence};
use super::base::upper;
use super::passing::Passing;
use super::{HierarchyParams, Line};
use crate::roots::repair::{Kind, Repair};
use crate::roots::strand::End;
use crate::roots::trace::Pieces;

/// Hanging on nothing: dearer than any tie.
const NOTHING_MM: f64 = 1e4;
/// Share of a piece at either end over which its taper is judged.
const THIRD: usize = 3;

/// What is passed through is thicker by this factor at least.
const THICKER: f64 = 1.3;

/// Stretch to either side over which the thickness about a point is taken, mm.
const ABOUT_MM: f64 = 10.0;

/// How a piece hangs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hang {
    /// On a point of another piece, by a point of its own.
    On {
        /// The other piece.
        parent: usize,
        /// The point there.
        parent_point: usize,
        /// The point of its own, an end or one between.
        point: usize,
    },
    /// By an end on what is hidden of the base root: the crown above, or what is below.
    Crown(End),
    /// On nothing: it is the base, or stands alone.
    Free,
}

/// Per piece how it hangs; `passings` are all that there are among the pieces.
pub fn attach(
    pieces: &Pieces,
    lines: &[Line<'_>],
    passings: &[Passing],
    base: usize,
    params: &HierarchyParams,
    log: &mut Vec<Repair>,
) -> Vec<Hang> {
    let crown = lines.len();
    let (mut edges, mut hangs) = (Vec::new(), Vec::new());
    let mut put = |from: usize, to: usize, cost: f64, hang: Hang| {
        edges.push(Edge { from, to, cost });
        hangs.push(hang);
    };
    put(crown, base, 0.0, Hang::Free);
    for tie in &pieces.ties {
        let cost = tie.cost(lines[tie.onto].radius_mm(tie.knot));
        let own = match tie.end {
            End::First => 0,
            End::Last => lines[tie.strand].last(),
        };
        let (here, there) = (thickness(&lines[tie.strand], own), thickness(&lines[tie.onto], tie.knot));
        let cost = |own: f64, parent: f64| cost + params.thicker_mm * squared(own / parent);
        let by_end = cost(here, there) + params.taper_mm * taper(&lines[tie.strand], tie.end);
        put(tie.onto, tie.strand, by_end, Hang::On { parent: tie.onto, parent_point: tie.knot, point: own });
        let body = Hang::On { parent: tie.strand, parent_point: own, point: tie.knot };
        put(tie.strand, tie.onto, cost(there, here) + params.by_body_mm, body);
    }
    for out in &pieces.out_of_sight {
        // Most that leave downwards are tips.
        let below = if out.below { params.by_body_mm } else { 0.0 };
        let cost = out.way_mm + params.unseen_mm * taper(&lines[out.piece], out.end) + below;
        put(crown, out.piece, cost, Hang::Crown(out.end));
    }
    for piece in (0..lines.len()).filter(|&k| k != base) {
        put(crown, piece, NOTHING_MM, Hang::Free);
    }
    // No root passes through another: what seems to, springs there to both sides.
    for p in passings.iter().filter(|p| p.piece != base) {
        let (own, parent) = (thickness(&lines[p.piece], p.point), thickness(&lines[p.other], p.other_point));
        if p.distance_mm < parent && parent > THICKER * own {
            let cost = 0.1 * p.distance_mm + params.thicker_mm * squared(own / parent) + params.by_body_mm;
            put(p.other, p.piece, cost, Hang::On { parent: p.other, parent_point: p.other_point, point: p.point });
        }
    }
    let mut chosen = arborescence(crown + 1, crown, &edges);
    let is_free = |k: usize| k != base && chosen[k].is_some_and(|e| matches!(hangs[e], Hang::Free));
    let of_free: Vec<&Passing> = passings.iter().filter(|p| is_free(p.piece)).collect();
    if !of_free.is_empty() {
        for &&Passing { piece, point, other, other_point, distance_mm } in &of_free {
            let cost = distance_mm + 2.0 * params.by_body_mm;
            for (child, own, parent, parent_point) in
                [(piece, point, other, other_point), (other, other_point, piece, point)]
            {
                edges.push(Edge { from: parent, to: child, cost });
                hangs.push(Hang::On { parent, parent_point, point: own });
            }
        }
        chosen = arborescence(crown + 1, crown, &edges);
    }
    let result: Vec<Hang> = (0..crown).map(|k| chosen[k].map_or(Hang::Free, |e| hangs[e])).collect();
    report(pieces, lines, &result, log);
    result
}

/// Squared thickness at the far end over that at this one: above 1 where a piece would grow thicker from here.
fn taper(line: &Line<'_>, end: End) -> f64 {
    let third = line.last() / THIRD;
    let (first, last) = (line.typical_radius_mm(0, third), line.typical_radius_mm(line.last() - third, line.last()));
    squared(if end == End::First { last / first } else { first / last })
}

/// A ratio's square, a quarter at least and four at most.
fn squared(ratio: f64) -> f64 {
    if ratio.is_nan() { 1.0 } else { (ratio * ratio).clamp(0.25, 4.0) }
}

/// Median radius about a point, mm.
fn thickness(line: &Line<'_>, point: usize) -> f64 {
    let [before, behind] = End::BOTH.map(|end| line.beyond(point, end, ABOUT_MM));
    line.typical_radius_mm(before, behind)
}

/// Writes down what was inferred, cut and opened.
fn report(pieces: &Pieces, lines: &[Line<'_>], hangs: &[Hang], log: &mut Vec<Repair>) {
    for (k, hang) in hangs.iter().enumerate() {
        let line = &lines[k];
        match *hang {
            Hang::Crown(end) => {
                let at = line.at(if end == End::First { 0 } else { line.last() });
                let out = pieces.out_of_sight.iter().find(|o| o.piece == k && o.end == end);
                let (way, whither) = out.map_or((0.0, "up"), |o| (o.way_mm, if o.below { "down" } else { "up" }));
                let reason = format!("runs out of sight {way:.1} mm on, {whither}wards: hung on what is hidden there");
                log.push(Repair::new(Kind::Inferred, &at, 0.0, reason));
            }
            Hang::On { parent, parent_point, point } if point > 0 && point < line.last() => {
                let gap = (lines[parent].at(parent_point) - line.at(point)).norm();
                let reason = format!("hangs by its middle: it passes {gap:.1} mm from the axis of a root that hangs");
                log.push(Repair::new(Kind::Split, &line.at(point), 0.0, reason));
            }
            _ => {}
        }
    }
    for tie in &pieces.ties {
        let radius = lines[tie.onto].radius_mm(tie.knot);
        let gap = (tie.distance_mm - radius).max(0.0);
        let own = if tie.end == End::First { 0 } else { lines[tie.strand].last() };
        let hangs_on = |child: usize, parent: usize| matches!(hangs[child], Hang::On { parent: p, .. } if p == parent);
        let used = hangs_on(tie.strand, tie.onto) || hangs_on(tie.onto, tie.strand);
        let by_this_end = matches!(hangs[tie.strand], Hang::On { point, .. } if point == own);
        if gap <= pieces.link_mm && !used && !by_this_end {
            let reason = format!(
                "this end touches another root, but hanging by it would cost more ({:.2} mm)",
                tie.cost(radius)
            );
            log.push(Repair::new(Kind::Opened, &lines[tie.strand].at(own), gap, reason));
        }
    }
}

/// The end by which a piece that stands alone begins: the clearly thicker one, else the upper one.
pub fn free_base(line: &Line<'_>) -> End {
    match taper(line, End::First) {
        t if t < 0.7 => End::First,
        t if t > 1.4 => End::Last,
        _ => upper(line),
    }
}
