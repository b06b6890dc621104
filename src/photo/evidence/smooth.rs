//! Gaussian smoothing of a plane.

use ndarray::Array2;

/// Gaussian smoothing with kernel radius ceil(3σ) and zeros beyond the border; unchanged at σ = 0.
pub(super) fn smooth(plane: &Array2<f32>, sigma_px: f64) -> Array2<f32> {
    let radius = (3.0 * sigma_px).ceil() as usize;
    if radius == 0 {
        return plane.clone();
    }
    let g: Vec<f32> = (0..=radius).map(|x| (-0.5 * (x as f64 / sigma_px).powi(2)).exp() as f32).collect();
    let total = g[0] + 2.0 * g[1..].iter().sum::<f32>();
    let g: Vec<f32> = g.iter().map(|x| x / total).collect();
    let (height, width) = plane.dim();
    let mut along_x = Array2::<f32>::zeros((height + 2 * radius, width));
    let mut padded = vec![0.0; width + 2 * radius];
    for (row, mut out) in plane.rows().into_iter().zip(along_x.rows_mut().into_iter().skip(radius)) {
        padded[radius..radius + width].iter_mut().zip(row).for_each(|(p, &v)| *p = v);
        for x in 0..width {
            let mut sum = g[0] * padded[radius + x];
            for r in 1..=radius {
                sum += g[r] * (padded[radius + x - r] + padded[radius + x + r]);
            }
            out[x] = sum;
        }
    }
    let mut out = Array2::zeros((height, width));
    for (y, mut row) in out.rows_mut().into_iter().enumerate() {
        for x in 0..width {
            let mut sum = g[0] * along_x[[radius + y, x]];
            for r in 1..=radius {
                sum += g[r] * (along_x[[radius + y - r, x]] + along_x[[radius + y + r, x]]);
            }
            row[x] = sum;
        }
    }
    out
}
