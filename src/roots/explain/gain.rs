//! What each bead alone accounts for: logarithms of likelihood ratios, summed over the photographs.

use super::beads::Chain;
use super::overlap::Overlap;
use rayon::prelude::*;
use std::ops::Range;

/// Beads before and behind whose gains are taken together, since looks are blurred.
const BESIDE: usize = 1;
/// Beads of a share of the work.
const SHARE: usize = 64;

/// Expected gain of every bead where the others are roots with the probabilities `present`.
pub fn expected(chain: &Chain, overlaps: &[Overlap], present: &[f32]) -> Vec<f32> {
    let sum: Vec<f32> = (0..chain.len())
        .into_par_iter()
        .with_min_len(SHARE)
        .map(|b| overlaps.iter().map(|overlap| overlap.expected(b, present)).sum())
        .collect();
    chain.pieces.iter().flat_map(|piece| mean(chain, piece, &sum[piece.clone()])).collect()
}

/// Gain of every bead of a piece where it is known which others are roots (`present` 0 or 1).
pub fn known(chain: &Chain, overlaps: &[Overlap], present: &[f32], piece: &Range<usize>) -> Vec<f32> {
    let sum: Vec<f32> = piece
        .clone()
        .into_par_iter()
        .with_min_len(SHARE)
        .map(|b| overlaps.iter().map(|overlap| overlap.known(b, present)).sum())
        .collect();
    mean(chain, piece, &sum)
}

fn mean(chain: &Chain, piece: &Range<usize>, sum: &[f32]) -> Vec<f32> {
    let mean = |b: usize| {
        let near = chain.near(b, BESIDE);
        let count = near.len() as f32;
        sum[near.start - piece.start..near.end - piece.start].iter().sum::<f32>() / count
    };
    piece.clone().map(mean).collect()
}
