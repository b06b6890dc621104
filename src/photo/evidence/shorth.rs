//! Noise of values of which some are no noise: the span of the shortest half, and what it is for pure noise.
//!
//! The shortest half of n normal values spans 1.349 deviations for many values, less for few. Its distribution is taken from
//! many draws of a fixed random sequence, so that few views are judged as fairly as many.

/// Span of the shortest half of sorted values.
pub(super) fn span(sorted: &[f32]) -> f32 {
    let half = (sorted.len() / 2).max(2);
    let spans = sorted.windows(half).map(|values| values[half - 1] - values[0]);
    spans.reduce(f32::min).unwrap_or(0.0)
}

/// The span, in deviations, that a share `rank` of sets of `n` normal values stays under.
pub(super) fn normal_span(n: usize, rank: f64) -> f32 {
    const DRAWS: usize = 4000;
    let mut state = 0x853c_49e6_748f_ea9bu64;
    let mut uniform = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1u64 << 24) as f32
    };
    // Twelve uniform values sum to a nearly normal one.
    let mut normal = || (0..12).map(|_| uniform()).sum::<f32>() - 6.0;
    let mut spans: Vec<f32> = (0..DRAWS)
        .map(|_| {
            let mut values: Vec<f32> = (0..n).map(|_| normal()).collect();
            values.sort_unstable_by(f32::total_cmp);
            span(&values)
        })
        .collect();
    *spans.select_nth_unstable_by((DRAWS as f64 * rank) as usize, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outliers_do_not_widen_the_shortest_half() {
        assert_eq!(span(&[0.0, 1.0, 1.5, 2.0, 50.0, 90.0]), 1.0);
        assert_eq!(span(&[1.0]), 0.0);
    }

    #[test]
    fn many_normal_values_span_what_theory_says_and_few_less() {
        assert!((normal_span(400, 0.5) - 1.349).abs() < 0.12, "{}", normal_span(400, 0.5));
        assert!(normal_span(6, 0.5) < 0.9 && normal_span(6, 0.3) < normal_span(6, 0.5));
    }
}
