//! Who springs from whom: the base, parents, orders.
//!
//! The base is the strand of the largest (mean scale)² × vertical extent × verticality among those that come
//! near the top of what is seen: the thickest and most vertical one at the crown. From it the tree grows
//! strand by strand: of all ties onto placed strands the cheapest is taken (Prim), so a strand that is tied
//! at both ends springs from the nearer one, and the ring is opened at its weaker tie. A strand whose upper
//! end runs into the hidden zone at the crown springs from the base there. A strand that no end ties but that
//! crosses a placed one within both radii is cut in two laterals at the crossing.

use super::bridge::Workshop;
use super::repair::{Kind, Repair};
use super::strand::{End, Strand};
use super::tie::{Tie, TieParams, ties};
use crate::optics::Vec3;

/// Where a strand hangs in the tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The strand it springs from and the knot there; none for the base and for strands tied to nothing.
    pub parent: Option<(usize, usize)>,
    /// The end at its base.
    pub base: End,
    /// Branching order.
    pub order: u32,
    /// Whether the tie to the parent is visible, so that the gap may be drawn.
    pub tied: bool,
}

/// Cuts, places and orders the strands; gives the strands with their places, `None` for those that hang on nothing.
pub fn place(
    mut strands: Vec<Strand>,
    workshop: &Workshop<'_>,
    params: &TieParams,
    log: &mut Vec<Repair>,
) -> (Vec<Strand>, Vec<Option<Place>>) {
    loop {
        let all = ties(&strands, workshop, params);
        let (places, mut opened) = grow(&strands, &all, workshop, params);
        if let Some((cut, knot, reason)) = crossing(&strands, &places, &all, workshop) {
            let at = strands[cut].at(knot);
            log.push(Repair::new(Kind::Split, &at, 0.0, reason));
            let [first, last] = halves(&strands[cut], knot, workshop);
            strands[cut] = first;
            strands.push(last);
            continue;
        }
        log.append(&mut opened);
        return (strands, places);
    }
}

/// Prim's tree from the base.
fn grow(
    strands: &[Strand],
    all: &[Tie],
    workshop: &Workshop<'_>,
    params: &TieParams,
) -> (Vec<Option<Place>>, Vec<Repair>) {
    let mut places: Vec<Option<Place>> = vec![None; strands.len()];
    let mut log = Vec::new();
    let Some(base) = base_of(strands) else { return (places, log) };
    let top =
        if strands[base].at(0).z <= strands[base].at(strands[base].knots.len() - 1).z { End::First } else { End::Last };
    places[base] = Some(Place { parent: None, base: top, order: 0, tied: false });
    let hidden: Vec<Option<(End, f64)>> = strands.iter().map(|s| runs_into_hidden(s, workshop, params)).collect();
    loop {
        let tie = all
            .iter()
            .filter(|t| places[t.strand].is_none() && places[t.onto].is_some())
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        // Going out of sight is worth as much as a tie over half the allowed gap.
        let out = (0..strands.len())
            .filter(|&s| places[s].is_none())
            .filter_map(|s| hidden[s].map(|(end, way)| (s, end, 0.5 * params.gap_mm + way)))
            .min_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
        match (tie, out) {
            (Some(t), out) if out.is_none_or(|o| t.cost <= o.2) => {
                let order = places[t.onto].map_or(0, |p| p.order) + 1;
                places[t.strand] = Some(Place { parent: Some((t.onto, t.knot)), base: t.end, order, tied: true });
            }
            (_, Some((s, end, way))) => {
                let onto = strands[base].end(top);
                places[s] = Some(Place { parent: Some((base, onto)), base: end, order: 1, tied: false });
                log.push(Repair::new(
                    Kind::Inferred,
                    &strands[s].at(strands[s].end(end)),
                    0.0,
                    format!("runs out of sight {way:.1} mm on, towards the crown: taken for a lateral of the base"),
                ));
            }
            _ => break,
        }
    }
    for tie in all {
        let Some(place) = places[tie.strand] else { continue };
        let ring = place.base != tie.end
            && places[tie.onto].is_some_and(|o| o.parent.is_none_or(|(p, _)| p != tie.strand))
            && place.parent.is_some_and(|(p, _)| p != tie.onto || tie.cost < 0.5 * params.gap_mm);
        if ring && tie.gap_mm <= workshop.link_mm {
            let strand = &strands[tie.strand];
            log.push(Repair::new(
                Kind::Opened,
                &strand.at(strand.end(tie.end)),
                tie.gap_mm,
                format!("both ends touch other roots; this end is the weaker tie (cost {:.2} mm)", tie.cost),
            ));
        }
    }
    (places, log)
}

/// The thickest, most vertical strand near the top.
pub fn base_of(strands: &[Strand]) -> Option<usize> {
    let top = |s: &Strand| s.knots.iter().map(|k| k[2]).fold(f64::INFINITY, f64::min);
    let bottom = |s: &Strand| s.knots.iter().map(|k| k[2]).fold(f64::NEG_INFINITY, f64::max);
    let (high, low) = (
        strands.iter().map(top).fold(f64::INFINITY, f64::min),
        strands.iter().map(bottom).fold(f64::NEG_INFINITY, f64::max),
    );
    let score = |s: &Strand| {
        let extent = bottom(s) - top(s);
        s.mean(4).powi(2) * extent * extent / s.length_mm().max(1e-9)
    };
    (0..strands.len())
        .filter(|&s| top(&strands[s]) <= high + 0.15 * (low - high))
        .max_by(|&a, &b| score(&strands[a]).total_cmp(&score(&strands[b])).then(b.cmp(&a)))
}

/// The end that leaves the seen water upwards, and how far away, mm.
fn runs_into_hidden(strand: &Strand, workshop: &Workshop<'_>, params: &TieParams) -> Option<(End, f64)> {
    let field = workshop.field;
    let step = 0.5 * field.grid.spacing_mm;
    let (nz, ny, nx) = field.rootness.dim();
    let low = field.grid.point_mm(0.0, 0.0, 0.0);
    let high = field.grid.point_mm(nz as f64 - 1.0, ny as f64 - 1.0, nx as f64 - 1.0);
    let middle = 0.5 * (low + high);
    // Near the wall a root leaves the seen water sideways: that says nothing of the crown.
    let reach = 0.5 * (high.x - low.x) - params.baseline_mm;
    let mut best: Option<(End, f64)> = None;
    for end in End::BOTH {
        let from = strand.at(strand.end(end));
        let outward = strand.outward(end, params.baseline_mm);
        if outward.z > 0.3 || from.z > middle.z || strand.at(strand.end(end.other())).z < from.z {
            continue;
        }
        for k in 0..=(params.gap_mm / step) as usize {
            let way = k as f64 * step;
            let p: Vec3 = from + outward * way;
            if (p.x - middle.x).hypot(p.y - middle.y) > reach {
                break;
            }
            if field.at(&p).is_nan() {
                if best.is_none_or(|b| way < b.1) {
                    best = Some((end, way));
                }
                break;
            }
        }
    }
    best
}

/// A strand to cut: hanging on nothing, it crosses a placed one, or a placed one ends on it.
fn crossing(
    strands: &[Strand],
    places: &[Option<Place>],
    all: &[Tie],
    workshop: &Workshop<'_>,
) -> Option<(usize, usize, String)> {
    let spacing = workshop.field.grid.spacing_mm;
    let inner = |s: usize, k: usize| {
        let margin = (3.0 / workshop.step_mm) as usize;
        k >= margin && k + margin < strands[s].knots.len()
    };
    let mut best: Option<(f64, usize, usize, usize)> = None;
    for (s, strand) in strands.iter().enumerate().filter(|&(s, _)| places[s].is_none()) {
        for (o, other) in strands.iter().enumerate().filter(|&(o, _)| places[o].is_some()) {
            for k in 0..strand.knots.len() {
                if !inner(s, k) {
                    continue;
                }
                let (onto, distance) = other.nearest(&strand.at(k));
                let gap = distance - other.radius_mm(onto) - spacing;
                if gap <= 0.0 && best.is_none_or(|b| distance < b.0) {
                    best = Some((distance, s, k, o));
                }
            }
        }
    }
    if let Some((distance, s, k, _)) = best {
        return Some((s, k, format!("hangs on nothing by its ends but passes {distance:.1} mm from a placed root")));
    }
    let tie = all.iter().find(|t| {
        places[t.strand].is_some_and(|p| p.base != t.end)
            && places[t.onto].is_none()
            && inner(t.onto, t.knot)
            && t.gap_mm <= workshop.link_mm
    })?;
    Some((tie.onto, tie.knot, "hangs on nothing, but a placed root ends on it".to_string()))
}

/// Both parts of a strand cut at a knot.
fn halves(strand: &Strand, knot: usize, workshop: &Workshop<'_>) -> [Strand; 2] {
    let at = strand.at(knot);
    let along = strand.tangent(knot);
    // The first ridge point beyond the cut, counted from the point nearest to it.
    let near = (0..strand.points.len())
        .min_by(|&a, &b| {
            let distance = |k: usize| (workshop.points[strand.points[k]].position_mm - at).norm_squared();
            distance(a).total_cmp(&distance(b))
        })
        .unwrap_or(0);
    let beyond = (workshop.points[strand.points[near]].position_mm - at).dot(&along) > 0.0;
    let cut = if beyond { near } else { near + 1 }.clamp(1, strand.points.len() - 1);
    [strand.points[..cut].to_vec(), strand.points[cut..].to_vec()].map(|points| workshop.strand(points))
}
