//! The geometric median by Weiszfeld's iteration with the step of Vardi and Zhang (PNAS 97, 2000) where
//! the estimate meets a data point, and an exact finish there.
//!
//! At y, with η the number of points at y and R = Σ (x - y)/|x - y| over the others, the step goes to
//! (1 - γ) T(y) + γ y, γ = min(1, η/|R|), T the mean weighted by 1/|x - y|. Weiszfeld creeps when the
//! minimiser is a data point, so the data point nearest to where it stops is tried in the end: a point
//! is the minimiser exactly if |R| ≤ η there.

use super::{Bundle, LANES, Lane, UNIT};

/// Colours nearer than this are one point: 1/255 apart at least where they differ in 8 bits.
const SAME: f32 = 1e-5 * UNIT;

/// Geometric median per lane, for the lanes that `known` marks; starts at the mean.
pub(super) fn median(
    bundle: &Bundle,
    count: &Lane,
    known: &[bool; LANES],
    tolerance: f32,
    max_steps: usize,
) -> [Lane; 3] {
    let mut y = bundle.mean(count);
    // Lanes stop on their own, so that a voxel's result does not depend on its neighbours in the block.
    let mut moving = known.map(|k| f32::from(u8::from(k)));
    for _ in 0..max_steps {
        let pull = Pull::at(bundle, &y);
        let mut go_on = false;
        for i in 0..LANES {
            let step = pull.step(i) * moving[i];
            let d = [0, 1, 2].map(|c| pull.sum[c][i] * step);
            for c in 0..3 {
                y[c][i] += d[c];
            }
            let moved = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if moved <= tolerance * tolerance {
                moving[i] = 0.0;
            }
            go_on |= moving[i] != 0.0;
        }
        if !go_on {
            break;
        }
    }
    let nearest = nearest(bundle, &y);
    let pull = Pull::at(bundle, &nearest);
    for i in 0..LANES {
        if pull.strength(i) <= pull.here[i] {
            for c in 0..3 {
                y[c][i] = nearest[c][i];
            }
        }
    }
    y
}

/// The forces of the data points on an estimate.
struct Pull {
    /// R: sum of the unit vectors to the points elsewhere.
    sum: [Lane; 3],
    /// Sum of the inverse distances to them.
    weight: Lane,
    /// η: number of points here.
    here: Lane,
}

impl Pull {
    fn at(bundle: &Bundle, y: &[Lane; 3]) -> Self {
        let mut pull = Self { sum: [[0.0; LANES]; 3], weight: [0.0; LANES], here: [0.0; LANES] };
        for l in 0..bundle.mask.len() {
            let [r, g, b] = [&bundle.channel[0][l], &bundle.channel[1][l], &bundle.channel[2][l]];
            let mask = &bundle.mask[l];
            for i in 0..LANES {
                let (dr, dg, db) = (r[i] - y[0][i], g[i] - y[1][i], b[i] - y[2][i]);
                let d2 = dr * dr + dg * dg + db * db;
                let apart = if d2 > SAME * SAME { mask[i] } else { 0.0 };
                let w = apart / d2.max(SAME * SAME).sqrt();
                pull.sum[0][i] += w * dr;
                pull.sum[1][i] += w * dg;
                pull.sum[2][i] += w * db;
                pull.weight[i] += w;
                pull.here[i] += mask[i] - apart;
            }
        }
        pull
    }

    /// |R| of a lane.
    fn strength(&self, i: usize) -> f32 {
        let [r, g, b] = [self.sum[0][i], self.sum[1][i], self.sum[2][i]];
        (r * r + g * g + b * b).sqrt()
    }

    /// Factor from R to the step: (1 - γ) / Σ 1/|x - y|, since T(y) - y = R / Σ 1/|x - y|.
    fn step(&self, i: usize) -> f32 {
        let strength = self.strength(i);
        let free = (1.0 - self.here[i] / strength.max(1e-20)).max(0.0);
        free / self.weight[i].max(1e-20)
    }
}

fn nearest(bundle: &Bundle, y: &[Lane; 3]) -> [Lane; 3] {
    let mut best = *y;
    let mut least = [f32::INFINITY; LANES];
    for l in 0..bundle.mask.len() {
        for i in 0..LANES {
            let p = [0, 1, 2].map(|c| bundle.channel[c][l][i]);
            let d = [0, 1, 2].map(|c| p[c] - y[c][i]);
            let d2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            if bundle.mask[l][i] != 0.0 && d2 < least[i] {
                least[i] = d2;
                for c in 0..3 {
                    best[c][i] = p[c];
                }
            }
        }
    }
    best
}
