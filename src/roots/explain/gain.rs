//! What each bead alone accounts for.

use super::beads::Chain;
use super::look::Looking;
use super::model::Model;
use rayon::prelude::*;

/// Standard deviation of a share about the model's: noise, shading, a width that is a little off.
const ERROR: f32 = 0.2;
/// Most that a photograph can tell for a bead: pixels may be wrong in ways that no noise describes.
pub const FOR: f32 = 3.0;
/// Most that it can tell against one: water where root should be is hardly chance, but roots move.
const AGAINST: f32 = 6.0;
/// Beads before and behind whose gains are taken together, since looks are blurred.
const BESIDE: usize = 1;

/// Gain of every bead, kept or not, when all other kept pieces are as they are: the logarithm of a likelihood ratio, summed over
/// the photographs.
pub fn gains(chain: &Chain, looking: &[Looking<'_>], kept: &[bool], radius_mm: &[f32]) -> Vec<f32> {
    let views: Vec<Vec<f32>> = looking
        .par_iter()
        .map(|looking| {
            let model = Model::new(looking, chain, kept, radius_mm);
            let gain = |b: usize| {
                let Some(look) = looking.looks[b] else { return 0.0 };
                let others = model.others_between(look.pixel, chain.piece[b]);
                let own = looking.cover.share(0.0, radius_mm[b] * look.px_per_mm);
                let (before, after) = (look.share - others, look.share - others.max(own));
                ((before * before - after * after) / (2.0 * ERROR * ERROR)).clamp(-AGAINST, FOR) * look.say
            };
            (0..chain.len()).map(gain).collect()
        })
        .collect();
    let mut sum = vec![0.0_f32; chain.len()];
    for view in &views {
        sum.iter_mut().zip(view).for_each(|(sum, gain)| *sum += gain);
    }
    (0..chain.len())
        .map(|b| {
            let near = chain.near(b, BESIDE);
            let count = near.len() as f32;
            sum[near].iter().sum::<f32>() / count
        })
        .collect()
}
