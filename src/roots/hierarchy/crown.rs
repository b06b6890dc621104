//! Whether a plant stands on a taproot or on many roots.
//!
//! Roots that run out of sight upwards spring from what is hidden there. Where there are three of them and the base root's mean
//! thickness is no more than √2 times their median, it is one of them, and all have order 0; else it is a taproot, and
//! they are its laterals. The mean is taken over depth: the area that a way covers seen from the side over how far it leads down.
//!
//! Of a plant without a taproot, roots that touch near the top part in the crown: what springs there from a root of order 0, and
//! is no thinner than these by more than that factor, is one of them too.

use super::Line;
use super::base::{near_top_mm, seen_from_side};
use super::walk::Grown;
use crate::math::robust::median;
use crate::roots::repair::{Kind, Repair};
use crate::roots::strand::End;
use crate::roots::trace::Pieces;

/// A taproot is thicker by this factor at least: twice in cross-section.
const TAPROOT: f64 = std::f64::consts::SQRT_2;
/// One or two roots out of sight are rather the uppermost laterals of a taproot whose width is misjudged.
const FEWEST: usize = 3;

/// Gives the base root (the first) its equals, unless it is a taproot: roots that hang on nothing and have order 0.
pub fn share(lines: &[Line<'_>], pieces: &Pieces, grown: &mut [Grown], log: &mut Vec<Repair>) {
    let hidden: Vec<usize> = (1..grown.len()).filter(|&n| leaves_upwards(lines, pieces, &grown[n])).collect();
    let mut others: Vec<f64> = hidden.iter().map(|&n| thickness_mm(lines, &grown[n])).collect();
    if others.len() < FEWEST || thickness_mm(lines, &grown[0]) > TAPROOT * median(&mut others) {
        return;
    }
    for n in hidden {
        raise(&mut grown[n], "runs out of sight upwards in a plant without a taproot", log);
    }
    let mut all: Vec<f64> = grown.iter().filter(|g| g.order == 0).map(|g| thickness_mm(lines, g)).collect();
    let (top_mm, least) = (near_top_mm(lines), median(&mut all) / TAPROOT);
    for n in 1..grown.len() {
        let springs_from_equal = grown[n].parent.is_some_and(|parent| grown[parent].order == 0);
        if springs_from_equal && grown[n].place.z <= top_mm && thickness_mm(lines, &grown[n]) >= least {
            raise(
                &mut grown[n],
                "parts near the top from a root that is no thicker, in a plant without a taproot",
                log,
            );
        }
    }
}

fn raise(root: &mut Grown, reason: &str, log: &mut Vec<Repair>) {
    (root.parent, root.order, root.tied) = (None, 0, false);
    log.push(Repair::new(Kind::Inferred, &root.place, 0.0, format!("{reason}: of order 0")));
}

/// Whether a root hangs on what is hidden above.
fn leaves_upwards(lines: &[Line<'_>], pieces: &Pieces, root: &Grown) -> bool {
    let first = root.parts[0];
    let begins_at = |end: End| first.from == if end == End::First { 0 } else { lines[first.piece].last() };
    !root.tied && pieces.out_of_sight.iter().any(|o| !o.below && o.piece == first.piece && begins_at(o.end))
}

/// Mean radius over depth, mm; 0 for what leads nowhere down.
fn thickness_mm(lines: &[Line<'_>], root: &Grown) -> f64 {
    let (area_mm2, depth_mm) = seen_from_side(lines, &root.parts);
    if depth_mm > 0.0 { area_mm2 / depth_mm } else { 0.0 }
}
