//! Which beads stay.
//!
//! Each piece's best stretches depend on those of the others. First nothing is certain: every bead is a root with a
//! probability, each photograph tells what it may be expected to tell, and from that follow new probabilities (mean field,
//! with the exact marginals of each piece's chain), while the heat falls from what all photographs together can tell for a bead to
//! little more than one of them. So what is contradicted goes early, and of those that account for the same the better one stays. Then it is
//! known who is there, and piece by piece, the least worth first, each keeps the stretches that are best given all others, until
//! none changes. Widths are taken anew in between, past the roots then known.

use super::beads::Chain;
use super::look::Looking;
use super::overlap::{FOR, Overlap};
use super::stretch::{Costs, probable, stretches};
use super::{ExplainParams, gain, width};
use rayon::prelude::*;

/// Rounds from hot to cold; later passes start after two thirds.
const ROUNDS: usize = 40;
const LATER: usize = 26;
/// Passes, with widths taken anew before all but the first.
const PASSES: usize = 3;
/// Heat at the end, in logarithms of likelihood.
const COLD: f32 = 2.0;
/// Part of the way to its new probability that a bead goes in a round: all go at once, and would go to and fro.
const WAY: f32 = 0.5;
/// Most sweeps through the pieces.
const SWEEPS: usize = 3;

/// Which beads the photographs need.
pub fn choose(chain: &Chain, looking: &[Looking<'_>], params: &ExplainParams) -> Vec<bool> {
    let all = looking.len() as f64;
    let costs = Costs {
        step: FOR * params.photographs.max(params.share * all) as f32,
        end: FOR * (params.end * all) as f32,
        cut: FOR * (params.cut * all) as f32,
    };
    let hot = (FOR * all as f32).max(COLD);
    let mut radius_mm = width::first(chain, looking);
    let mut present = vec![0.5; chain.len()];
    let mut kept = vec![true; chain.len()];
    for pass in 0..PASSES {
        if pass > 0 {
            radius_mm = width::then(chain, looking, &kept, &radius_mm);
        }
        let overlaps: Vec<Overlap> =
            looking.par_iter().map(|looking| Overlap::new(looking, chain, &radius_mm)).collect();
        for round in if pass == 0 { 0 } else { LATER }..ROUNDS {
            let heat = hot * (COLD / hot).powf(round as f32 / (ROUNDS - 1) as f32);
            let gains = gain::expected(chain, &overlaps, &present);
            let now: Vec<Vec<f32>> =
                chain.pieces.par_iter().map(|piece| probable(&gains[piece.clone()], &costs, heat)).collect();
            present.iter_mut().zip(now.iter().flatten()).for_each(|(p, now)| *p += WAY * (now - *p));
        }
        kept = settle(chain, &overlaps, &present, &costs);
    }
    kept
}

/// From probabilities to a choice of which no single piece would want to change.
fn settle(chain: &Chain, overlaps: &[Overlap], present: &[f32], costs: &Costs) -> Vec<bool> {
    let gains = gain::expected(chain, overlaps, present);
    let mut kept: Vec<bool> = chain.pieces.iter().flat_map(|piece| stretches(&gains[piece.clone()], costs)).collect();
    let mut known: Vec<f32> = kept.iter().map(|kept| f32::from(u8::from(*kept))).collect();
    let worth = |piece: &std::ops::Range<usize>| -> f32 {
        piece.clone().filter(|b| kept[*b]).map(|b| gains[b] - costs.step).sum()
    };
    let mut order: Vec<(f32, usize)> = chain.pieces.iter().map(worth).zip(0..).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    for _ in 0..SWEEPS {
        let mut changed = false;
        for (_, number) in &order {
            let piece = &chain.pieces[*number];
            let own = gain::known(chain, overlaps, &known, piece);
            for (b, stays) in piece.clone().zip(stretches(&own, costs)) {
                changed |= kept[b] != stays;
                kept[b] = stays;
                known[b] = f32::from(u8::from(stays));
            }
        }
        if !changed {
            break;
        }
    }
    kept
}
