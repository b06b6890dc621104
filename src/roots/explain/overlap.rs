//! What a photograph tells for each bead, and which others could have told it.

use super::beads::Chain;
use super::look::{Look, Looking, read};
use super::tubes::Tubes;
use nalgebra::Vector2;

/// Standard deviation of a share about the model's: noise, shading, a width that is a little off.
const ERROR: f32 = 0.2;
/// Most that a photograph can tell for a bead: pixels may be wrong in ways that no noise describes.
pub const FOR: f32 = 3.0;
/// Most that it can tell against one: water where root should be is hardly chance, but roots move.
const AGAINST: f32 = 6.0;
/// Shares below it are none.
const LEAST: f32 = 0.05;
/// Where a tube's sides are looked at, in radii from its middle, and from how far a pixel's middle tells something else, px.
const SIDE: f32 = 0.7;
const APART_PX: f32 = 0.5;

/// A bead of another piece that covers a bead's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Over {
    bead: u32,
    /// How much of what the bead would account for it accounts for, 0..1.
    part: f32,
}

/// What a photograph tells of a bead.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Word {
    /// Share that it shows at the bead's middle, share that the bead alone would give, and how far the word counts, 0..1.
    share: f32,
    own: f32,
    say: f32,
    /// For the bead when no other root is there, by its middle and sides: logarithm of a likelihood ratio.
    alone: f32,
    /// By its middle only.
    middle: f32,
}

/// A photograph's word on each bead.
#[derive(Debug, Clone, Default)]
pub struct Overlap {
    words: Vec<Word>,
    /// Where in `over` each bead's others begin; one more at the end.
    start: Vec<u32>,
    over: Vec<Over>,
}

impl Overlap {
    /// The word of a photograph when beads have these radii, mm.
    pub fn new(looking: &Looking<'_>, chain: &Chain, radius_mm: &[f32]) -> Self {
        let tubes = Tubes::new(looking, chain, radius_mm, |_| true);
        let mut overlap = Self::default();
        let mut others: Vec<(u32, Over)> = Vec::new();
        for (b, look) in looking.looks.iter().enumerate() {
            overlap.start.push(overlap.over.len() as u32);
            let word = look.map_or_else(Word::default, |look| word(looking, &look, radius_mm[b]));
            overlap.words.push(word);
            let Some(look) = look.filter(|_| word.alone != 0.0 && word.own >= LEAST) else { continue };
            others.clear();
            for (bead, share) in tubes.others(look.pixel, chain.piece[b]).filter(|(_, share)| *share >= LEAST) {
                others.push((chain.piece[bead as usize], Over { bead, part: (share / word.own).min(1.0) }));
            }
            others.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.part.total_cmp(&a.1.part)).then(a.1.bead.cmp(&b.1.bead)));
            others.dedup_by_key(|other| other.0);
            overlap.over.extend(others.iter().map(|other| other.1));
        }
        overlap.start.push(overlap.over.len() as u32);
        overlap
    }

    /// Probability that no other root covers the bead, where each is there with the probability `present`.
    fn free(&self, bead: usize, present: &[f32]) -> f32 {
        let over = &self.over[self.start[bead] as usize..self.start[bead + 1] as usize];
        over.iter().map(|over| 1.0 - present[over.bead as usize] * over.part).product()
    }

    /// What the photograph may be expected to tell for a bead.
    pub fn expected(&self, bead: usize, present: &[f32]) -> f32 {
        self.words[bead].alone * self.free(bead, present)
    }

    /// What it tells where it is known which others are there (`present` 0 or 1).
    pub fn known(&self, bead: usize, present: &[f32]) -> f32 {
        let word = &self.words[bead];
        let free = self.free(bead, present);
        told(word.share, word.own * (1.0 - free), word.own) * word.say + (word.alone - word.middle) * free
    }
}

/// Logarithm of the likelihood ratio where `share` is shown: the bead gives `own`, others give `others`.
fn told(share: f32, others: f32, own: f32) -> f32 {
    let (before, after) = (share - others, share - own.max(others));
    ((before * before - after * after) / (2.0 * ERROR * ERROR)).clamp(-AGAINST, FOR)
}

fn word(looking: &Looking<'_>, look: &Look, radius_mm: f32) -> Word {
    let radius_px = radius_mm * look.px_per_mm;
    let own = looking.cover.share(0.0, radius_px);
    let middle = told(look.share, 0.0, own) * look.say;
    let across = Vector2::new(-look.along.y, look.along.x) * (SIDE * radius_px);
    let side = |at: Vector2<f32>| {
        let (share, say) = read(&looking.witness, at)?;
        Some(told(share, 0.0, looking.cover.share(SIDE * radius_px, radius_px)) * say.min(look.say))
    };
    let sides = [side(look.pixel - across), side(look.pixel + across)];
    let sides: Vec<f32> = sides.into_iter().flatten().filter(|_| SIDE * radius_px >= APART_PX).collect();
    let alone = (middle + sides.iter().sum::<f32>()) / (1 + sides.len()) as f32;
    Word { share: look.share, own, say: look.say, alone, middle }
}
