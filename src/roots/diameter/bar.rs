//! A bar of light of given width, blurred by a Gaussian.
//!
//! Across a root the light falls off towards its limbs: not at all where light comes from everywhere, with √(1 − u²)
//! (u from -1 to 1) where all of it comes from the camera's side. The bar's profile is `1 − limb + limb √(1 − u²)`; the root is
//! taken as a pile of flat bars (`LAYERS`), so that the blur stays that of edges.

/// ½ (1 + erf(x / √2)) to 1.2e-7 (rational approximation by Hastings; Abramowitz and Stegun 7.1.26).
pub fn normal_below(x: f64) -> f64 {
    let z = x.abs() * std::f64::consts::FRAC_1_SQRT_2;
    let t = 1.0 / (1.0 + 0.327_591_1 * z);
    let series =
        t * (0.254_829_592 + t * (-0.284_496_736 + t * (1.421_413_741 + t * (-1.453_152_027 + t * 1.061_405_429))));
    let tail = 0.5 * series * (-z * z).exp();
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// Widths and heights of three flat bars that make √(1 − u²): its layers of equal thickness, at their middles.
const LAYERS: [[f64; 2]; 3] = [[0.986_013, 1.0 / 3.0], [0.866_025, 1.0 / 3.0], [0.552_771, 1.0 / 3.0]];

/// The blurred edge and the point spread, tabulated, for one point spread.
#[derive(Debug, Clone)]
pub struct Bars {
    spread_px: f64,
    limb: f64,
    /// Light beyond an edge at 0, and the spread's density times its standard deviation.
    table: Vec<[f64; 2]>,
}

/// Where the table ends, in standard deviations.
const REACH: f64 = 5.0;
/// Entries per standard deviation.
const PER_SIGMA: f64 = 64.0;

impl Bars {
    /// Bars blurred by `spread_px` whose light falls off by `limb` (0 to 1) towards the limbs.
    pub fn new(spread_px: f64, limb: f64) -> Self {
        let n = (2.0 * REACH * PER_SIGMA) as usize;
        let entry = |k: usize| {
            let z = k as f64 / PER_SIGMA - REACH;
            [normal_below(z), 0.398_942_280_401 * (-0.5 * z * z).exp()]
        };
        Self { spread_px, limb, table: (0..=n + 1).map(entry).collect() }
    }

    /// Light at `x` beyond an edge at 0, and the density of the point spread there, times its variance.
    fn edge_and_bell(&self, x: f64) -> (f64, f64) {
        let at = (x / self.spread_px + REACH) * PER_SIGMA;
        if at <= 0.0 {
            return (0.0, 0.0);
        }
        if at >= 2.0 * REACH * PER_SIGMA {
            return (1.0, 0.0);
        }
        let k = at as usize;
        let f = at - k as f64;
        let ([e0, b0], [e1, b1]) = (self.table[k], self.table[k + 1]);
        (e0 + f * (e1 - e0), self.spread_px * (b0 + f * (b1 - b0)))
    }

    /// At `x`, of a bar of `width` about 0: what it covers, 1 inside a wide one; its light; and that of a bar whose light
    /// rises from -1 to 1 across its width.
    pub fn at(&self, x: f64, width: f64) -> [f64; 3] {
        let half = 0.5 * width;
        let (left, right) = (self.edge_and_bell(x + half), self.edge_and_bell(x - half));
        let flat = left.0 - right.0;
        let shade = (x * flat + left.1 - right.1) / half;
        if self.limb <= 0.0 {
            return [flat, flat, shade];
        }
        // The widest layer is nearly the flat bar itself.
        let layer = |[share, height]: [f64; 2]| {
            height * (self.edge_and_bell(x + share * half).0 - self.edge_and_bell(x - share * half).0)
        };
        let round = LAYERS[0][1] * flat + layer(LAYERS[1]) + layer(LAYERS[2]);
        [flat, flat + self.limb * (round - flat), shade]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_keeps_its_light_and_its_edges() {
        let bars = Bars::new(0.6, 0.0);
        assert!((bars.at(0.0, 20.0)[1] - 1.0).abs() < 1e-6);
        assert!((bars.at(10.0, 20.0)[1] - 0.5).abs() < 1e-6);
        let sum: f64 = (-4000..4000).map(|k| bars.at(f64::from(k) * 0.005, 1.7)[1] * 0.005).sum();
        assert!((sum - 1.7).abs() < 1e-4);
        let x = 0.7;
        let blurred: f64 = (-850..850)
            .map(|k| f64::from(k) * 0.001 + 0.0005)
            .map(|t| {
                t / 0.85 * (-0.5 * ((x - t) / 0.6f64).powi(2)).exp() / (0.6 * std::f64::consts::TAU.sqrt()) * 0.001
            })
            .sum();
        assert!((bars.at(x, 1.7)[2] - blurred).abs() < 1e-4);
        let round = Bars::new(0.3, 1.0);
        let area: f64 = (-4000..4000).map(|k| round.at(f64::from(k) * 0.005, 4.0)[1] * 0.005).sum();
        assert!(
            (area / std::f64::consts::PI - 1.0).abs() < 0.03,
            "{area}: half the area of a circle of radius 2, over it"
        );
        assert!((normal_below(1.0) - 0.841_344_746).abs() < 2e-7 && (normal_below(-2.0) - 0.022_750_132).abs() < 2e-7);
    }
}
