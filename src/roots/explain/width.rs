//! Radii of the beads from the photographs' shares of root.
//!
//! Across a root its shares sum up to its width ([`super::cover::Cover::radius_px`]). From the bead's middle the sum goes either way until
//! hardly any root is left or another one begins. What lies beside or behind only ever makes it wider: while it is not known
//! which pieces are roots, one of the narrowest views counts; once it is, views past all other roots count, and of these one
//! somewhat below the middle, since there is always something that is not known.

use super::beads::Chain;
use super::look::{Look, Looking, read};
use super::tubes::Tubes;
use crate::math::robust::median;
use nalgebra::Vector2;
use rayon::prelude::*;

/// Share of the views, from the narrowest, of which the widest counts: before and after the others are known.
const FIRST: f64 = 0.15;
const THEN: f64 = 0.35;
/// Step across, px.
const STEP_PX: f32 = 0.5;
/// Share that a root's middle has at least, and at which it ends.
const MIDDLE: f32 = 0.3;
const END: f32 = 0.1;
/// Rise of the share at which another root begins.
const RISE: f32 = 0.15;
/// Share of others from which a place is theirs.
const THEIRS: f32 = 0.1;
/// Farthest way across, px.
const FARTHEST_PX: f32 = 30.0;
/// Fewest views.
const VIEWS: usize = 3;
/// Beads before and behind over whose median a radius is taken: it changes slowly.
const BESIDE: usize = 10;
/// Thinnest, mm.
const LEAST_MM: f64 = 0.05;
/// Where nothing is measured, mm.
const UNKNOWN_MM: f64 = 0.3;

/// Radii, mm, before it is known which beads are roots.
pub fn first(chain: &Chain, looking: &[Looking<'_>]) -> Vec<f32> {
    radii(chain, looking, FIRST, None)
}

/// Radii, mm, with the kept beads known to be roots; `before` where too few photographs look past the others.
pub fn then(chain: &Chain, looking: &[Looking<'_>], kept: &[bool], before: &[f32]) -> Vec<f32> {
    radii(chain, looking, THEN, Some((kept, before)))
}

fn radii(chain: &Chain, looking: &[Looking<'_>], quantile: f64, known: Option<(&[bool], &[f32])>) -> Vec<f32> {
    let views: Vec<Vec<Option<f32>>> = looking
        .par_iter()
        .map(|looking| {
            let tubes = known.map(|(kept, radius_mm)| Tubes::new(looking, chain, radius_mm, |b| kept[b]));
            let radius = |b: usize| radius_mm(looking, looking.looks[b].as_ref()?, tubes.as_ref(), chain.piece[b]);
            (0..chain.len()).map(radius).collect()
        })
        .collect();
    let own: Vec<Option<f64>> = (0..chain.len())
        .into_par_iter()
        .map(|b| {
            let mut radii: Vec<f32> = views.iter().filter_map(|view| view[b]).collect();
            radii.sort_by(f32::total_cmp);
            (radii.len() >= VIEWS).then(|| f64::from(radii[(radii.len() as f64 * quantile) as usize]))
        })
        .collect();
    let mut all: Vec<f64> = own.iter().flatten().copied().collect();
    let typical = if all.is_empty() { UNKNOWN_MM } else { median(&mut all) };
    (0..chain.len())
        .map(|b| {
            let mut near: Vec<f64> = chain.near(b, BESIDE).filter_map(|k| own[k]).collect();
            match known {
                Some((_, before)) if near.is_empty() => before[b],
                _ if near.is_empty() => typical as f32,
                _ => median(&mut near).max(LEAST_MM) as f32,
            }
        })
        .collect()
}

/// Radius that one photograph shows, mm; none where others cover the root or run into it.
fn radius_mm(looking: &Looking<'_>, look: &Look, tubes: Option<&Tubes<'_, '_>>, piece: u32) -> Option<f32> {
    let theirs = |at: Vector2<f32>| tubes.is_some_and(|tubes| tubes.others(at, piece).any(|(_, share)| share > THEIRS));
    if look.share < MIDDLE || theirs(look.pixel) {
        return None;
    }
    let mut area = STEP_PX * look.share;
    for side in [-1.0, 1.0] {
        let across = Vector2::new(-look.along.y, look.along.x) * (side * STEP_PX);
        let (mut lowest, mut way) = (look.share, 1.0);
        loop {
            let at = look.pixel + across * way;
            let (share, _) = read(&looking.witness, at)?;
            if share < END || share > lowest + RISE {
                break;
            }
            if theirs(at) || way * STEP_PX > FARTHEST_PX {
                return None;
            }
            lowest = lowest.min(share);
            area += STEP_PX * share;
            way += 1.0;
        }
    }
    Some(looking.cover.radius_px(area) / look.px_per_mm)
}
