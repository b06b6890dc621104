//! Sampled Gaussian kernels and their first two derivatives.
//!
//! All three reach to radius ceil(5σ) (what the second derivative needs; Sato et al., Handbook of
//! Biomedical Image Analysis 2). They are normalised by their moments, so that polynomials of second
//! degree are differentiated exactly however coarse the sampling. A filter is the correlation
//! `Σ k[x] f[i + x]`; [`correlate`] is its one inner loop.

/// A kernel and its derivatives, half of each: entries 0..=radius; the first derivative is odd, the
/// others are even.
#[derive(Debug, Clone, PartialEq)]
pub struct Kernels {
    /// Smoothing: sums to 1.
    pub smooth: Vec<f32>,
    /// First derivative per sample: Σ x k = 1.
    pub first: Vec<f32>,
    /// Second derivative per sample²: Σ k = 0, Σ x² k = 2.
    pub second: Vec<f32>,
}

/// Half width in samples of the kernels of standard deviation `sigma` (samples).
pub fn radius(sigma: f64) -> usize {
    (5.0 * sigma).ceil() as usize
}

impl Kernels {
    /// The kernels of standard deviation `sigma` in samples, positive.
    pub fn new(sigma: f64) -> Self {
        let g: Vec<f64> = (0..=radius(sigma)).map(|x| (-0.5 * (x as f64 / sigma).powi(2)).exp()).collect();
        let sum = |f: &dyn Fn(f64) -> f64| g[0] * f(0.0) + 2.0 * (1..g.len()).map(|x| g[x] * f(x as f64)).sum::<f64>();
        let (m0, m2, m4) = (sum(&|_| 1.0), sum(&|x| x * x), sum(&|x| x.powi(4)));
        // Second derivative as (x² - m2/m0) g, whose sum is 0 and whose second moment is m4 - m2²/m0.
        let scale = 2.0 / (m4 - m2 * m2 / m0);
        let each = |f: &dyn Fn(f64, f64) -> f64| g.iter().enumerate().map(|(x, &g)| f(x as f64, g) as f32).collect();
        Self {
            smooth: each(&|_, g| g / m0),
            first: each(&|x, g| x * g / m2),
            second: each(&|x, g| scale * (x * x - m2 / m0) * g),
        }
    }
}

/// Outputs that [`correlate`] holds in registers while it runs through the kernel.
const BLOCK: usize = 32;

/// `out[i] = k[0] row(0)[i] + Σ_x k[x] (row(x)[i] ± row(-x)[i])`, minus for an odd kernel, summed in
/// the order of x. `row(x)` gives the samples displaced by x, at least as many as `out` holds.
#[inline(always)]
pub fn correlate<'a>(out: &mut [f32], kernel: &[f32], odd: bool, row: impl Fn(isize) -> &'a [f32]) {
    let whole = out.len() / BLOCK * BLOCK;
    let (blocks, rest) = out.split_at_mut(whole);
    for (n, out) in blocks.chunks_exact_mut(BLOCK).enumerate() {
        let from = n * BLOCK;
        let part = |x: isize| &row(x)[from..from + BLOCK];
        let mut sums = [0.0; BLOCK];
        add_up(&mut sums, kernel, odd, part);
        out.copy_from_slice(&sums);
    }
    add_up(rest, kernel, odd, |x| &row(x)[whole..]);
}

#[inline(always)]
fn add_up<'a>(out: &mut [f32], kernel: &[f32], odd: bool, row: impl Fn(isize) -> &'a [f32]) {
    let n = out.len();
    let centre = &row(0)[..n];
    for i in 0..n {
        out[i] = kernel[0] * centre[i];
    }
    for (x, &k) in kernel.iter().enumerate().skip(1) {
        let (ahead, behind) = (&row(x as isize)[..n], &row(-(x as isize))[..n]);
        if odd {
            for i in 0..n {
                out[i] += k * (ahead[i] - behind[i]);
            }
        } else {
            for i in 0..n {
                out[i] += k * (ahead[i] + behind[i]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_exact_even_for_narrow_kernels() {
        for sigma in [0.4, 0.7, 1.0, 2.3] {
            let k = Kernels::new(sigma);
            let moment = |k: &[f32], p: i32, odd: bool| {
                let tail: f64 = (1..k.len()).map(|x| f64::from(k[x]) * (x as f64).powi(p)).sum();
                let sign = if odd == (p % 2 == 1) { 2.0 } else { 0.0 };
                sign * tail + if p == 0 { f64::from(k[0]) } else { 0.0 }
            };
            assert!((moment(&k.smooth, 0, false) - 1.0).abs() < 1e-6);
            assert!((moment(&k.first, 1, true) - 1.0).abs() < 1e-6);
            assert!(moment(&k.second, 0, false).abs() < 1e-5);
            assert!((moment(&k.second, 2, false) - 2.0).abs() < 1e-5);
        }
    }
}
