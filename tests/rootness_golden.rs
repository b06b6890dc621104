//! Rootness against scikit-image and ITK, whose line measures agree with equation 16 where nothing bends: with
//! γ23 = 0.5 it is scikit-image's √(λ2 λ3), with γ23 = 1 ITK's min(|λ2|, |λ3|). The goldens are made by
//! `tests/data/rootness/golden.py`; the three codes sample the Gaussian differently, hence the tolerance.

use ndarray::Array3;
use rootvox::volume::rootness::{Rootness, rootness};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    side: usize,
    sigma: f64,
    inner: [usize; 2],
    noise_scikit_image: Vec<f32>,
    rod_scikit_image: Vec<f32>,
    rod_itk: Vec<f32>,
}

fn golden() -> Golden {
    serde_json::from_str(include_str!("data/rootness/golden.json")).expect("the file of golden.py")
}

fn noise(side: usize) -> Array3<f32> {
    let mut state = 1u32;
    Array3::from_shape_simple_fn((side, side, side), || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as f32
    })
}

fn rod(side: usize) -> Array3<f32> {
    let middle = (side as f32 - 1.0) / 2.0;
    Array3::from_shape_fn((side, side, side), |(_, j, i)| {
        let (x, y) = (i as f32 - middle, j as f32 - middle);
        100.0 * (-x * x / (2.0 * 1.5 * 1.5) - y * y / (2.0 * 3.0 * 3.0)).exp()
    })
}

/// Root mean square of the differences over that of the expected values.
fn relative_rms(volume: &Array3<f32>, golden: &Golden, params: &Rootness, expected: &[f32]) -> f64 {
    let out = rootness(volume.view(), 1.0, params).expect("in range");
    let [from, to] = golden.inner;
    let got = out.rootness.slice_move(ndarray::s![from..to, from..to, from..to]);
    assert_eq!(got.len(), expected.len());
    let square = |x: f32| f64::from(x) * f64::from(x);
    let difference: f64 = got.iter().zip(expected).map(|(a, b)| square(a - b)).sum();
    (difference / expected.iter().map(|&b| square(b)).sum::<f64>()).sqrt()
}

fn params(golden: &Golden, gamma23: f64) -> Rootness {
    // γ12 = 0 takes the curvature along the line out of the measure, as scikit-image does.
    Rootness { sigma: vec![golden.sigma], gamma23, gamma12: 0.0, alpha: 1e-6, dark: false }
}

#[test]
fn a_random_volume_measures_as_in_scikit_image() {
    let golden = golden();
    let off = relative_rms(&noise(golden.side), &golden, &params(&golden, 0.5), &golden.noise_scikit_image);
    assert!(off < 0.02, "relative rms {off}");
}

#[test]
fn a_rod_measures_as_in_scikit_image_and_itk() {
    let golden = golden();
    let volume = rod(golden.side);
    let off = relative_rms(&volume, &golden, &params(&golden, 0.5), &golden.rod_scikit_image);
    assert!(off < 0.02, "scikit-image: relative rms {off}");
    let off = relative_rms(&volume, &golden, &params(&golden, 1.0), &golden.rod_itk);
    assert!(off < 0.02, "ITK: relative rms {off}");
}
