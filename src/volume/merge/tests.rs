use super::*;
use ndarray::{Array4, ArrayView4};
use proptest::prelude::*;

/// Slow reference in f64: Weiszfeld from the best of the mean and all points, very many steps.
fn reference(points: &[[f64; 3]]) -> ([f64; 3], f64) {
    let cost = |y: [f64; 3]| points.iter().map(|p| distance(*p, y)).sum::<f64>();
    let n = points.len() as f64;
    let mut y = [0, 1, 2].map(|c| points.iter().map(|p| p[c]).sum::<f64>() / n);
    for _ in 0..20_000 {
        let mut weight = 0.0;
        let mut sum = [0.0; 3];
        for p in points {
            let w = 1.0 / distance(*p, y).max(1e-12);
            weight += w;
            for c in 0..3 {
                sum[c] += w * p[c];
            }
        }
        y = sum.map(|s| s / weight);
    }
    points.iter().copied().chain([y]).map(|p| (p, cost(p))).min_by(|a, b| a.1.total_cmp(&b.1)).unwrap()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt()
}

fn paper() -> Merge {
    Merge { estimator: Estimator::GeometricMedian, ..Merge::default() }
}

/// One voxel row of which every voxel holds the same views.
fn volumes(points: &[[u8; 3]], width: usize) -> Vec<Array4<u8>> {
    points
        .iter()
        .map(|p| Array4::from_shape_fn((1, 1, width, 4), |(_, _, _, c)| if c < 3 { p[c] } else { 255 }))
        .collect()
}

fn merged(volumes: &[Array4<u8>], params: &Merge) -> Merged {
    let views: Vec<_> = volumes.iter().map(|v| v.view()).collect();
    merge(&views, params).unwrap()
}

fn random(shape: (usize, usize, usize), views: usize, seed: u32) -> Vec<Array4<u8>> {
    let mut state = seed;
    (0..views)
        .map(|_| {
            Array4::from_shape_fn((shape.0, shape.1, shape.2, 4), |(.., c)| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                let byte = (state >> 24) as u8;
                if c == 3 { if byte > 60 { 255 } else { 0 } } else { byte }
            })
        })
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn geometric_median_is_the_minimiser(points in prop::collection::vec(prop::array::uniform3(0u8..12), 3..24)) {
        // Few codes: coincident points and minimisers at data points are frequent.
        let params = Merge { tolerance: 1e-5, max_steps: 5000, ..paper() };
        let out = merged(&volumes(&points, 3), &params);
        let exact: Vec<_> = points.iter().map(|p| p.map(|x| f64::from(x) / 255.0)).collect();
        let (_, least) = reference(&exact);
        for i in 0..3 {
            let got = [0, 1, 2].map(|c| f64::from(out.colour[[0, 0, i, c]]));
            let cost: f64 = exact.iter().map(|p| distance(*p, got)).sum();
            prop_assert!(cost <= least + 1e-5 * points.len() as f64, "{cost} > {least}");
        }
    }

    #[test]
    fn quantiles_are_numpys(values in prop::collection::vec(0u8..255, 3..40), q in 0.0f32..1.0) {
        let points: Vec<_> = values.iter().map(|&v| [v, v, v]).collect();
        let out = merged(&volumes(&points, 1), &Merge { estimator: Estimator::Quantile, quantile: q, ..Merge::default() });
        let mut sorted = values.clone();
        sorted.sort_unstable();
        let at = f64::from(q) * (sorted.len() - 1) as f64;
        let (low, high) = (f64::from(sorted[at.floor() as usize]), f64::from(sorted[at.ceil() as usize]));
        let expected = (low + (at - at.floor()) * (high - low)) / 255.0;
        prop_assert!((f64::from(out.colour[[0, 0, 0, 1]]) - expected).abs() < 1e-4);
    }
}

#[test]
fn a_minority_of_any_colour_does_not_move_the_median_far() {
    let mut points = vec![[100, 100, 100]; 10];
    points.extend([[255, 0, 0]; 9]);
    let out = merged(&volumes(&points, 1), &paper());
    for c in 0..3 {
        assert!((out.colour[[0, 0, 0, c]] - 100.0 / 255.0).abs() < 1e-6);
    }
    assert_eq!(out.coverage[[0, 0, 0]], 19);
}

#[test]
fn voxels_seen_by_too_few_views_are_unknown() {
    let mut volumes = volumes(&[[10, 20, 30], [11, 20, 30], [12, 20, 30]], 2);
    volumes[2][[0, 0, 1, 3]] = 0;
    let out = merged(&volumes, &Merge::default());
    assert!(!out.colour[[0, 0, 0, 0]].is_nan() && out.colour[[0, 0, 1, 0]].is_nan());
    assert!(out.residual[[0, 0, 1]].is_nan());
    assert_eq!([out.coverage[[0, 0, 0]], out.coverage[[0, 0, 1]]], [3, 2]);
}

/// Planes from..to, without the first five columns so that blocks of lanes fall differently.
fn cut<T>(mut volume: ArrayView4<T>, from: usize, to: usize) -> ArrayView4<T> {
    volume.slice_axis_inplace(Axis(0), (from..to).into());
    volume.slice_axis_inplace(Axis(2), (5..).into());
    volume
}

#[test]
fn bricks_equal_the_whole_bit_for_bit_in_every_mode() {
    let volumes = random((5, 4, 37), 9, 7);
    for estimator in
        [Estimator::GeometricMedian, Estimator::Mean, Estimator::Median, Estimator::Quantile, Estimator::LowMean]
    {
        for metric in [Metric::Rgb, Metric::Lab] {
            let params = Merge { estimator, metric, ..Merge::default() };
            let whole = merged(&volumes, &params);
            for (from, to) in [(0, 2), (2, 3), (3, 5)] {
                let slabs: Vec<_> = volumes.iter().map(|v| cut(v.view(), from, to)).collect();
                let slab = merge(&slabs, &params).unwrap();
                let bits = |a: ArrayView4<f32>| a.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert_eq!(bits(slab.colour.view()), bits(cut(whole.colour.view(), from, to)));
                assert_eq!(
                    slab.coverage,
                    whole.coverage.slice_axis(Axis(0), (from..to).into()).slice_axis(Axis(2), (5..).into())
                );
            }
        }
    }
}

#[test]
fn lab_and_rgb_agree_where_all_views_agree() {
    let volumes = volumes(&[[120, 80, 40]; 4], 1);
    let out = merged(&volumes, &Merge { metric: Metric::Lab, ..paper() });
    for (c, code) in [120.0, 80.0, 40.0].into_iter().enumerate() {
        assert!((out.colour[[0, 0, 0, c]] * 255.0 - code).abs() < 0.1);
    }
}

#[test]
fn the_geometric_median_in_lab_is_that_of_the_lab_colours() {
    let points = [[200, 40, 30], [190, 60, 20], [60, 180, 90], [210, 50, 60], [30, 30, 200]];
    let params = Merge { metric: Metric::Lab, tolerance: 1e-6, max_steps: 5000, ..paper() };
    let out = merged(&volumes(&points, 1), &params);
    let lab = |rgb: [f32; 3]| lab_of_srgb(rgb).map(f64::from);
    let exact: Vec<_> = points.iter().map(|p| lab(p.map(|x| x as f32 / 255.0))).collect();
    let (_, least) = reference(&exact);
    let got = lab([0, 1, 2].map(|c| out.colour[[0, 0, 0, c]]));
    let cost: f64 = exact.iter().map(|p| distance(*p, got)).sum();
    assert!(cost <= least + 0.05, "{cost} > {least}");
    let in_rgb = merged(&volumes(&points, 1), &Merge { metric: Metric::Rgb, ..params });
    assert!((0..3).any(|c| (in_rgb.colour[[0, 0, 0, c]] - out.colour[[0, 0, 0, c]]).abs() > 1e-3), "metrics differ");
}

#[test]
fn mean_and_median_are_those_of_the_channels() {
    let points = [[10, 200, 30], [20, 100, 90], [60, 120, 0], [90, 90, 10], [20, 130, 250]];
    for (estimator, expected) in [(Estimator::Mean, [40.0, 128.0, 76.0]), (Estimator::Median, [20.0, 120.0, 30.0])] {
        let out = merged(&volumes(&points, 2), &Merge { estimator, ..Merge::default() });
        for c in 0..3 {
            assert!((out.colour[[0, 0, 1, c]] * 255.0 - expected[c]).abs() < 1e-3, "{estimator:?}");
        }
        let spread: f64 =
            points.iter().map(|p| distance(p.map(f64::from), expected.map(f64::from))).sum::<f64>() / 5.0 / 255.0;
        assert!((f64::from(out.residual[[0, 0, 1]]) - spread).abs() < 1e-5, "the residual is the mean distance");
    }
}

#[test]
fn bad_input_is_refused() {
    let a = Array4::<u8>::zeros((2, 3, 4, 4));
    let b = Array4::<u8>::zeros((2, 3, 5, 4));
    assert!(merge(&[a.view(), b.view()], &Merge::default()).unwrap_err().message.contains("view 1"));
    assert!(merge(&[], &Merge::default()).is_err());
    let error = Merge { quantile: 2.0, tolerance: f32::NAN, ..Merge::default() }.check().unwrap_err();
    assert_eq!(error.others.len(), 1);
}

#[test]
fn the_low_mean_takes_the_share_of_views_that_it_names() {
    let points: Vec<_> = [90, 10, 70, 30, 50].iter().map(|&v| [v, v, 255 - v]).collect();
    let low = |quantile| {
        let params = Merge { estimator: Estimator::LowMean, quantile, ..Merge::default() };
        let colour = merged(&volumes(&points, 1), &params).colour;
        [colour[[0, 0, 0, 0]] * 255.0, colour[[0, 0, 0, 2]] * 255.0]
    };
    for (q, expected) in
        [(0.0, [10.0, 165.0]), (0.2, [10.0, 165.0]), (0.4, [20.0, 175.0]), (0.5, [26.0, 181.0]), (1.0, [50.0, 205.0])]
    {
        let got = low(q);
        assert!((got[0] - expected[0]).abs() < 1e-3 && (got[1] - expected[1]).abs() < 1e-3, "{q}: {got:?}");
    }
}
