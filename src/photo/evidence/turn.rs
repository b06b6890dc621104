//! The background that views of a still camera share, pixel by pixel.
//!
//! Per pixel the most frequent colour of the views that look into the water there. Once the roots' colour is known, a mode
//! that looks like root must be the majority. A pixel is sure where enough views share its mode; elsewhere, deep in a bush,
//! the sure pixels around say what to expect (their mean in a window), and views that show it there confirm it: unconfirmed, the
//! pixel's variance is that between root and background, and it has hardly a say.

use super::Codes;
use super::drift::Even;
use super::fill::Areas;
use super::mode::Colours;
use super::noise::Noise;
use super::roots::{Likeness, RootColour};
use super::shorth::{normal_span, span};
use crate::photo::Picture;
use ndarray::{Array2, Array3, Axis, Zip};
use rayon::prelude::*;

/// Share of views that must show a mode, and of one that looks like root.
const SURE: f32 = 0.2;
const SURE_LIKE_ROOT: f32 = 0.6;
/// Fewer views make nothing sure.
const FEWEST: u16 = 3;
/// A colour this near to what is expected, in deviations squared, confirms it.
const CONFIRMS: f32 = 9.0;
/// Colours in 5 x 5 unsure pixels that must confirm.
const CONFIRMED: u32 = 3;

/// The views of one still room.
#[derive(Clone, Copy)]
pub struct Group<'a> {
    /// All photographs of the study.
    pub photos: &'a [Picture],
    /// Their drift.
    pub even: &'a [Even],
    /// Which pixels look into the water.
    pub clear: &'a [Array2<bool>],
    /// Those of the group.
    pub members: &'a [usize],
}

/// Modes of all pixels.
#[derive(Debug, Clone)]
pub struct Turn {
    /// (y, x, rgb), codes.
    pub mean: Codes,
    /// (y, x, rgb), summed squares about it, codes².
    scatter: Array3<f32>,
    /// Views that share it.
    pub count: Array2<u16>,
    /// Views that look into the water there.
    pub seen: Array2<u16>,
    /// Noise deviation of each channel that colours were compared by, codes.
    pub sigma: [f32; 3],
}

/// A background with its variance.
#[derive(Debug, Clone)]
pub struct Still {
    /// (y, x, rgb), codes.
    pub background: Codes,
    /// (y, x, rgb), codes².
    pub variance: Array3<f32>,
}

impl<'a> Group<'a> {
    fn size(&self) -> (usize, usize) {
        self.clear[0].dim()
    }

    /// Colours of a pixel over the views, divided by `sigma`.
    fn gather(&self, y: usize, x: usize, sigma: [f32; 3], colours: &mut Colours) {
        colours.clear();
        for &v in self.members.iter().filter(|&&v| self.clear[v][[y, x]]) {
            let colour = self.even[v].pixel(&self.photos[v], y, x);
            colours.push([0, 1, 2].map(|c| colour[c] / sigma[c]));
        }
    }

    /// Noise deviation of each channel, from the shortest half of the views at many pixels: the lower part of their spans, since
    /// roots widen some.
    fn sigma(&self) -> [f32; 3] {
        const RANK: f64 = 0.3;
        let (height, width) = self.size();
        let step = ((height * width) as f64 / 60_000.0).sqrt().ceil() as usize;
        let mut spans: [Vec<f32>; 3] = Default::default();
        let mut colours = Colours::default();
        for y in (0..height).step_by(step) {
            for x in (0..width).step_by(step) {
                self.gather(y, x, [1.0; 3], &mut colours);
                if colours.len() < self.members.len() {
                    continue;
                }
                for (c, spans) in spans.iter_mut().enumerate() {
                    let mut values: Vec<f32> = (0..colours.len()).map(|n| colours.get(n)[c]).collect();
                    values.sort_unstable_by(f32::total_cmp);
                    spans.push(span(&values));
                }
            }
        }
        let of_noise = normal_span(self.members.len(), RANK).max(0.1);
        spans.map(|mut spans| {
            let at = (spans.len() as f64 * RANK) as usize;
            let low =
                if spans.is_empty() { 2.0 } else { *spans.select_nth_unstable_by(at, f32::total_cmp).1 / of_noise };
            // Rounding to codes leaves no less.
            low.max(0.6)
        })
    }

    /// The modes, whatever roots look like.
    pub fn modes(&self) -> Turn {
        let (height, width) = self.size();
        let mut turn = Turn {
            mean: Array3::zeros((height, width, 3)),
            scatter: Array3::zeros((height, width, 3)),
            count: Array2::zeros((height, width)),
            seen: Array2::zeros((height, width)),
            sigma: self.sigma(),
        };
        self.update(&mut turn, None);
        turn
    }

    /// Finds the modes anew; with a likeness, where a minority's mode looks like root.
    fn update(&self, turn: &mut Turn, likeness: Option<&Likeness>) {
        let sigma = turn.sigma;
        let rows = turn.mean.axis_iter_mut(Axis(0)).into_par_iter().zip(turn.scatter.axis_iter_mut(Axis(0)));
        let rows = rows.zip(turn.count.axis_iter_mut(Axis(0)).into_par_iter().zip(turn.seen.axis_iter_mut(Axis(0))));
        rows.enumerate().for_each(|(y, ((mut mean, mut scatter), (mut count, mut seen)))| {
            let mut colours = Colours::default();
            for x in 0..count.len() {
                let codes = [0, 1, 2].map(|c| mean[[x, c]]);
                if likeness.is_some_and(|l| 2 * count[x] >= seen[x] || !l.holds(codes)) {
                    continue;
                }
                self.gather(y, x, sigma, &mut colours);
                let doubtful =
                    |colour: [f32; 3]| likeness.is_some_and(|l| l.holds([0, 1, 2].map(|c| colour[c] * sigma[c])));
                let Some(mode) = colours.mode(doubtful) else { continue };
                for c in 0..3 {
                    mean[[x, c]] = mode.mean[c] * sigma[c];
                    scatter[[x, c]] = mode.scatter[c] * sigma[c] * sigma[c];
                }
                (count[x], seen[x]) = (mode.count as u16, colours.len() as u16);
            }
        });
    }

    /// The background once the roots' colour is known.
    pub fn still(&self, mut turn: Turn, roots: &RootColour, noise: &Noise) -> Still {
        let likeness = roots.likeness();
        self.update(&mut turn, Some(&likeness));
        let sure = Array2::from_shape_fn(turn.count.dim(), |(y, x)| {
            let (count, seen) = (turn.count[[y, x]], turn.seen[[y, x]]);
            let like_root = likeness.holds([0, 1, 2].map(|c| turn.mean[[y, x, c]]));
            let share = if like_root { SURE_LIKE_ROOT } else { SURE };
            count >= FEWEST && f32::from(count) >= share * f32::from(seen)
        });
        let mut still = Still { variance: turn.pooled_variance(noise), background: turn.mean.clone() };
        self.fill(&turn, &sure, roots, &likeness, &mut still);
        still
    }

    /// Fills in what is not sure.
    fn fill(&self, turn: &Turn, sure: &Array2<bool>, roots: &RootColour, likeness: &Likeness, still: &mut Still) {
        let areas = Areas::new(&turn.mean, sure);
        let sigma = turn.sigma;
        let (height, width) = sure.dim();
        let unsure: Vec<(usize, usize)> =
            sure.indexed_iter().filter_map(|(at, &sure)| (!sure && turn.seen[at] > 0).then_some(at)).collect();
        let filled: Vec<_> = unsure
            .par_iter()
            .map_init(Colours::default, |colours, &(y, x)| {
                let (expected, spread) = areas.around(y, x)?;
                let variance = [0, 1, 2].map(|c| spread[c] + 5.0 * sigma[c] * sigma[c]);
                self.gather(y, x, [1.0; 3], colours);
                let (mut sum, mut count) = ([0.0f32; 3], 0u32);
                for colour in (0..colours.len()).map(|n| colours.get(n)) {
                    let off: f32 = (0..3).map(|c| (colour[c] - expected[c]).powi(2) / variance[c]).sum();
                    if off < CONFIRMS && !likeness.holds(colour) {
                        count += 1;
                        (0..3).for_each(|c| sum[c] += colour[c]);
                    }
                }
                let own = count as f32 / (count as f32 + 1.0);
                let mean = [0, 1, 2].map(|c| own * sum[c] / count.max(1) as f32 + (1.0 - own) * expected[c]);
                let variance = [0, 1, 2].map(|c| (1.0 - own) * variance[c] + own * 1.5 * sigma[c] * sigma[c]);
                Some((mean, variance, expected, count))
            })
            .collect();
        let mut confirming = Array2::<u32>::zeros((height, width));
        for (&at, filled) in unsure.iter().zip(&filled) {
            confirming[at] = filled.map_or(0, |f| f.3);
        }
        for (&(y, x), filled) in unsure.iter().zip(&filled) {
            let rows = y.saturating_sub(2)..(y + 3).min(height);
            let around: u32 =
                rows.map(|v| (x.saturating_sub(2)..(x + 3).min(width)).map(|u| confirming[[v, u]]).sum::<u32>()).sum();
            for c in 0..3 {
                let (mean, mut variance, expected) =
                    filled.map_or((turn.mean[[y, x, c]], 0.0, turn.mean[[y, x, c]]), |f| (f.0[c], f.1[c], f.2[c]));
                if around < CONFIRMED {
                    variance += (roots.mean[c] as f32 - expected).powi(2);
                }
                still.background[[y, x, c]] = mean;
                let known = &mut still.variance[[y, x, c]];
                *known = known.max(variance);
            }
        }
    }
}

impl Turn {
    /// Pairs of level and variance of the pixels that most views share.
    pub fn levels(&self) -> Vec<(f32, f32)> {
        let step = (self.count.len() / 200_000).max(1);
        let shared = self.count.indexed_iter().step_by(step).filter(|&(at, &n)| n >= 4 && 2 * n > self.seen[at]);
        shared
            .flat_map(|((y, x), &n)| {
                [0, 1, 2].map(|c| (self.mean[[y, x, c]], self.scatter[[y, x, c]] / f32::from(n - 1)))
            })
            .collect()
    }

    /// Whether most views share the mode, and no more loosely than `times` the noise's deviation.
    pub fn is_quiet(&self, y: usize, x: usize, times: f32, noise: &Noise) -> bool {
        let (count, seen) = (self.count[[y, x]], self.seen[[y, x]]);
        let free = f32::from(count.saturating_sub(1)).max(1.0);
        let (mut found, mut expected) = (0.0, 0.0);
        for c in 0..3 {
            found += self.scatter[[y, x, c]] / free;
            expected += noise.variance(self.mean[[y, x, c]]);
        }
        2 * count > seen && found < times * times * expected
    }

    /// Variance over the views of each pixel and its eight neighbours, at least the noise's.
    fn pooled_variance(&self, noise: &Noise) -> Array3<f32> {
        let (height, width) = self.count.dim();
        let mut out = Array3::zeros((height, width, 3));
        Zip::indexed(out.lanes_mut(Axis(2))).par_for_each(|(y, x), mut variance| {
            if self.seen[[y, x]] == 0 {
                return;
            }
            let (mut sum, mut free) = ([0.0f32; 3], 0.0f32);
            for v in y.saturating_sub(1)..(y + 2).min(height) {
                for u in x.saturating_sub(1)..(x + 2).min(width) {
                    free += f32::from(self.count[[v, u]].saturating_sub(1));
                    (0..3).for_each(|c| sum[c] += self.scatter[[v, u, c]]);
                }
            }
            for c in 0..3 {
                variance[c] = (sum[c] / free.max(1.0)).max(noise.variance(self.mean[[y, x, c]]));
            }
        });
        out
    }
}
