//! The most frequent colour of a pixel over the views, and how closely it is shared.
//!
//! Each view's colour is scored by how many views lie within [`REACH`] of it (noise deviations, squared, of three
//! channels: 99 % of pure noise); the greatest score wins, the closer company on a tie. Roots vary in shade, the still
//! background in noise alone, so it wins also where most views show some root, as long as a few do not.

/// Squared distance, in noise deviations, of colours that are the same.
pub(super) const REACH: f32 = 12.0;

/// Colours of one pixel in all views, in noise deviations, channel by channel.
#[derive(Debug, Default)]
pub(super) struct Colours {
    channel: [Vec<f32>; 3],
    scores: Vec<f32>,
    counts: Vec<f32>,
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mode {
    /// Mean of the colours that share it, in noise deviations.
    pub mean: [f32; 3],
    /// Sum of their squared distances from the mean, by channel.
    pub scatter: [f32; 3],
    /// How many they are.
    pub count: usize,
}

impl Colours {
    pub fn clear(&mut self) {
        self.channel.iter_mut().for_each(Vec::clear);
    }

    pub fn push(&mut self, colour: [f32; 3]) {
        self.channel.iter_mut().zip(colour).for_each(|(channel, value)| channel.push(value));
    }

    pub fn len(&self) -> usize {
        self.channel[0].len()
    }

    pub fn get(&self, n: usize) -> [f32; 3] {
        [0, 1, 2].map(|c| self.channel[c][n])
    }

    /// The mode among colours of which `doubtful` ones count only where they are the majority; `None` without colours.
    pub fn mode(&mut self, doubtful: impl Fn([f32; 3]) -> bool) -> Option<Mode> {
        let n = self.len();
        self.counts.resize(n, 0.0);
        self.scores.resize(n, 0.0);
        for i in 0..n {
            let (mut count, mut distance) = (0.0f32, 0.0f32);
            let [r, g, b] = self.get(i);
            let [red, green, blue] = &self.channel;
            for j in 0..n {
                let d = (red[j] - r) * (red[j] - r) + (green[j] - g) * (green[j] - g) + (blue[j] - b) * (blue[j] - b);
                count += if d < REACH { 1.0 } else { 0.0 };
                distance += if d < REACH { d } else { REACH };
            }
            let penalty = if 2.0 * count < n as f32 && doubtful([r, g, b]) { n as f32 } else { 0.0 };
            self.counts[i] = count;
            self.scores[i] = count - penalty - 1e-3 * distance / n as f32;
        }
        let best = (0..n).max_by(|&a, &b| self.scores[a].total_cmp(&self.scores[b]).then(b.cmp(&a)))?;
        let mut mode = self.around(self.get(best));
        for _ in 0..2 {
            mode = self.around(mode.mean);
        }
        Some(mode)
    }

    /// The colours within reach of `centre`; the centre alone where there are none.
    fn around(&self, centre: [f32; 3]) -> Mode {
        let (mut sum, mut squares, mut count) = ([0.0; 3], [0.0; 3], 0usize);
        for n in 0..self.len() {
            let d = [0, 1, 2].map(|c| self.channel[c][n] - centre[c]);
            if d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < REACH {
                count += 1;
                for c in 0..3 {
                    sum[c] += d[c];
                    squares[c] += d[c] * d[c];
                }
            }
        }
        if count == 0 {
            return Mode { mean: centre, scatter: [0.0; 3], count: 0 };
        }
        let shift = sum.map(|s| s / count as f32);
        Mode {
            mean: [0, 1, 2].map(|c| centre[c] + shift[c]),
            scatter: [0, 1, 2].map(|c| (squares[c] - sum[c] * shift[c]).max(0.0)),
            count,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(colours: &[[f32; 3]], doubtful: impl Fn([f32; 3]) -> bool) -> Mode {
        let mut all = Colours::default();
        colours.iter().for_each(|&c| all.push(c));
        all.mode(doubtful).unwrap()
    }

    #[test]
    fn the_background_wins_where_most_views_show_shaded_roots() {
        let mut colours: Vec<[f32; 3]> = (0..12).map(|n| [30.0 + 6.0 * n as f32, 40.0, 20.0]).collect();
        colours.extend([[10.0, 11.0, 12.0], [10.8, 11.0, 11.5], [9.5, 11.3, 12.2], [10.0, 10.4, 12.0]]);
        let mode = of(&colours, |_| false);
        assert_eq!(mode.count, 4);
        assert!((mode.mean[0] - 10.1).abs() < 0.1 && mode.scatter[0] > 0.0);
    }

    #[test]
    fn what_looks_like_root_must_be_the_majority() {
        let root = |c: [f32; 3]| c[0] > 50.0;
        let mut colours = vec![[60.0; 3]; 5];
        colours.extend([[10.0; 3]; 3]);
        colours.extend([[20.0, 0.0, 0.0], [0.0, 30.0, 0.0], [0.0, 0.0, 40.0], [5.0, 40.0, 5.0]]);
        assert_eq!(of(&colours, root).mean, [10.0; 3]);
        colours.extend([[60.0; 3]; 9]);
        assert_eq!(of(&colours, root).mean, [60.0; 3]);
    }

    #[test]
    fn no_colours_have_no_mode() {
        assert_eq!(Colours::default().mode(|_| false), None);
    }
}
