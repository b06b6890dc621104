//! Which beads stay.

use super::ExplainParams;
use super::beads::Chain;
use super::gain::{FOR, gains};
use super::look::Looking;
use super::stretch::stretches;
use super::width;

/// Rounds in which the costs rise to what they are.
const ROUNDS: usize = 14;
/// Rounds in which only what the photographs speak against goes.
const LENIENT: usize = 4;
/// Rounds of coming back and going again at most.
const EXCHANGES: usize = 3;
/// What comes back must be worth this times its cost, or it would go again.
const BACK: f32 = 1.3;

/// Which beads the photographs need.
pub fn choose(chain: &Chain, looking: &[Looking<'_>], params: &ExplainParams) -> Vec<bool> {
    let all = looking.len() as f64;
    let step = f64::from(FOR) * params.photographs.max(params.share * all);
    let (step, end) = (step as f32, FOR * (params.end * all) as f32);
    let mut radius_mm = width::first(chain, looking);
    let mut kept = vec![true; chain.len()];
    let worth = |kept: &[bool], radius_mm: &[f32], step: f32, end: f32| -> Vec<bool> {
        let gains = gains(chain, looking, kept, radius_mm);
        chain.pieces.iter().flat_map(|piece| stretches(&gains[piece.clone()], step, end)).collect()
    };
    for round in 1..=ROUNDS {
        let risen = round as f32 / ROUNDS as f32;
        let lenient = all as f32 * (1.0 - (round - 1) as f32 / LENIENT as f32).max(0.0);
        let worth = worth(&kept, &radius_mm, step * risen - lenient, end * risen);
        kept.iter_mut().zip(&worth).for_each(|(kept, worth)| *kept &= worth);
    }
    for exchange in 0..EXCHANGES {
        if exchange < 2 {
            radius_mm = width::then(chain, looking, &kept, &radius_mm);
        }
        let before = kept.clone();
        let back = worth(&kept, &radius_mm, BACK * step, end);
        kept.iter_mut().zip(&back).for_each(|(kept, back)| *kept |= back);
        let worth = worth(&kept, &radius_mm, step, end);
        kept.iter_mut().zip(&worth).for_each(|(kept, worth)| *kept &= worth);
        if kept == before && exchange > 0 {
            break;
        }
    }
    kept
}
