//! Smooth curves through noisy points in order.
//!
//! The curve is a chain of knots at equal spacing h ≈ `step_mm`, joined by straight chords. The knots
//! minimise `Σᵢ wᵢ |xᵢ − C(sᵢ)|² + λ Σ |Δ²Cⱼ|²`, a smoothing spline in its discrete form (Whittaker,
//! Eilers): a wave of length L in the data comes through with the share `1 / (1 + (L₀ / L)⁴)`, L₀ =
//! `wavelength_mm`, whatever the density of the data, so that the length of a root does not depend on
//! the grid. The arc position sᵢ of a point starts as the chord length along the points and is then
//! replaced by the foot of the point on the last fit: zigzag in the data does not lengthen the curve.
//! Further values (rootness, scale) ride along through the same smoothing.

use crate::optics::Vec3;

/// How often the points' arc positions are taken anew from the fit; more changes nothing visible.
const ROUNDS: usize = 3;

/// Knots `[x, y, z, extra...]` of the smooth curve through `values` (each `[x, y, z, extra...]`) in
/// their order. Fewer than two distinct points come back as they are.
pub fn smooth<const D: usize>(values: &[[f64; D]], step_mm: f64, wavelength_mm: f64) -> Vec<[f64; D]> {
    let mut arc = chord_lengths(values);
    let length = arc.last().copied().unwrap_or(0.0);
    if values.len() < 2 || length < 1e-9 {
        return values.iter().take(1).copied().collect();
    }
    let mut knots = fit(values, &arc, length, step_mm, wavelength_mm);
    for _ in 1..ROUNDS {
        let length = feet(values, &knots, &mut arc);
        if length < 1e-9 {
            break;
        }
        knots = fit(values, &arc, length, step_mm, wavelength_mm);
    }
    // Equal spacing of the final knots: the fit shortens zigzag, not everywhere alike.
    resample(&knots, step_mm)
}

/// `values` at ascending positions `arc` (mm), smoothed as a curve's are, given back at the same positions.
pub fn smooth_values<const D: usize>(
    arc: &[f64],
    values: &[[f64; D]],
    step_mm: f64,
    wavelength_mm: f64,
) -> Vec<[f64; D]> {
    let (Some(&first), Some(&last)) = (arc.first(), arc.last()) else { return Vec::new() };
    let length = last - first;
    if values.len() < 3 || length < 1e-9 {
        return values.to_vec();
    }
    let from: Vec<f64> = arc.iter().map(|s| s - first).collect();
    let knots = fit(values, &from, length, step_mm, wavelength_mm);
    let h = length / (knots.len() - 1) as f64;
    from.iter()
        .map(|s| {
            let k = ((s / h) as usize).min(knots.len() - 2);
            let f = s / h - k as f64;
            std::array::from_fn(|d| knots[k][d] + f * (knots[k + 1][d] - knots[k][d]))
        })
        .collect()
}

/// The polyline at equal arc spacing close to `step_mm`, both ends kept; extra values interpolated.
pub fn resample<const D: usize>(line: &[[f64; D]], step_mm: f64) -> Vec<[f64; D]> {
    let arc = chord_lengths(line);
    let length = arc.last().copied().unwrap_or(0.0);
    if line.len() < 2 || length < 1e-9 {
        return line.iter().take(1).copied().collect();
    }
    let pieces = (length / step_mm).round().max(1.0) as usize;
    let mut at = 0;
    (0..=pieces)
        .map(|k| {
            let s = length * k as f64 / pieces as f64;
            while at + 2 < line.len() && arc[at + 1] < s {
                at += 1;
            }
            let f = ((s - arc[at]) / (arc[at + 1] - arc[at]).max(1e-12)).clamp(0.0, 1.0);
            std::array::from_fn(|d| line[at][d] + f * (line[at + 1][d] - line[at][d]))
        })
        .collect()
}

/// Arc length from the first point to each point, mm.
pub fn chord_lengths<const D: usize>(line: &[[f64; D]]) -> Vec<f64> {
    let mut sum = 0.0;
    let mut arc = Vec::with_capacity(line.len());
    for (k, p) in line.iter().enumerate() {
        if k > 0 {
            sum += (position(p) - position(&line[k - 1])).norm();
        }
        arc.push(sum);
    }
    arc
}

/// The position within `[x, y, z, extra...]`.
pub fn position<const D: usize>(p: &[f64; D]) -> Vec3 {
    Vec3::new(p[0], p[1], p[2])
}

/// Arc positions of the points' feet on the knots' polyline, never running backwards; gives the length
/// between the first and the last foot, and shifts the arc so that it starts at 0.
fn feet<const D: usize>(values: &[[f64; D]], knots: &[[f64; D]], arc: &mut [f64]) -> f64 {
    let knot_arc = chord_lengths(knots);
    let mut from = 0;
    for (value, s) in values.iter().zip(arc.iter_mut()) {
        let p = position(value);
        let mut best = (f64::INFINITY, from, knot_arc[from]);
        // A foot moves on by little from point to point: some millimetres of knots are enough.
        for k in from.saturating_sub(4)..(from + 24).min(knots.len() - 1) {
            let (a, b) = (position(&knots[k]), position(&knots[k + 1]));
            let along = b - a;
            let f = ((p - a).dot(&along) / along.norm_squared().max(1e-18)).clamp(0.0, 1.0);
            let distance = (p - a - along * f).norm_squared();
            if distance < best.0 {
                best = (distance, k, knot_arc[k] + f * along.norm());
            }
        }
        from = best.1;
        *s = best.2;
    }
    let mut high = arc[0];
    for s in arc.iter_mut() {
        high = high.max(*s);
        *s = high;
    }
    let first = arc[0];
    arc.iter_mut().for_each(|s| *s -= first);
    arc.last().copied().unwrap_or(0.0)
}

/// The penalised least squares fit for given arc positions: a symmetric system of half bandwidth 2.
fn fit<const D: usize>(
    values: &[[f64; D]],
    arc: &[f64],
    length: f64,
    step_mm: f64,
    wavelength_mm: f64,
) -> Vec<[f64; D]> {
    let pieces = (length / step_mm).round().max(1.0) as usize;
    let n = pieces + 1;
    let h = length / pieces as f64;
    // The weight of the penalty for data of one point per mm is (L0/2π)⁴; the discrete second
    // difference over h is h² times the derivative, a sum over knots 1/h times the integral.
    let density = values.len() as f64 / length;
    let lambda = density * (wavelength_mm / std::f64::consts::TAU).powi(4) / h.powi(3);
    let mut diagonal = vec![1e-9 * density; n];
    let mut first = vec![0.0; n];
    let mut second = vec![0.0; n];
    let mut right = vec![[0.0; D]; n];
    for (value, &s) in values.iter().zip(arc) {
        let k = ((s / h) as usize).min(n - 2);
        let f = (s / h - k as f64).clamp(0.0, 1.0);
        diagonal[k] += (1.0 - f) * (1.0 - f);
        diagonal[k + 1] += f * f;
        first[k] += f * (1.0 - f);
        for d in 0..D {
            right[k][d] += (1.0 - f) * value[d];
            right[k + 1][d] += f * value[d];
        }
    }
    for k in 1..n - 1 {
        diagonal[k - 1] += lambda;
        diagonal[k] += 4.0 * lambda;
        diagonal[k + 1] += lambda;
        first[k - 1] -= 2.0 * lambda;
        first[k] -= 2.0 * lambda;
        second[k - 1] += lambda;
    }
    solve_banded(&mut diagonal, &mut first, &mut second, &mut right);
    right
}

/// Solves a symmetric positive definite system of half bandwidth 2 by LDLᵀ, in place in `right`.
fn solve_banded<const D: usize>(diagonal: &mut [f64], first: &mut [f64], second: &mut [f64], right: &mut [[f64; D]]) {
    let n = diagonal.len();
    for k in 0..n {
        let pivot = diagonal[k];
        let (l1, l2) = (first[k] / pivot, second[k] / pivot);
        let value = right[k];
        if k + 1 < n {
            diagonal[k + 1] -= l1 * first[k];
            first[k + 1] -= l1 * second[k];
            right[k + 1] = minus(right[k + 1], l1, value);
        }
        if k + 2 < n {
            diagonal[k + 2] -= l2 * second[k];
            right[k + 2] = minus(right[k + 2], l2, value);
        }
        first[k] = l1;
        second[k] = l2;
    }
    for k in (0..n).rev() {
        let mut value = right[k].map(|v| v / diagonal[k]);
        if k + 1 < n {
            value = minus(value, first[k], right[k + 1]);
        }
        if k + 2 < n {
            value = minus(value, second[k], right[k + 2]);
        }
        right[k] = value;
    }
}

/// a − f b.
fn minus<const D: usize>(a: [f64; D], f: f64, b: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| a[d] - f * b[d])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn helix(s: f64) -> [f64; 3] {
        let turn = s / 20.0;
        [12.0 * turn.cos(), 12.0 * turn.sin(), 16.0 * turn]
    }

    /// A pseudo-random value in -1..1.
    fn noise(k: usize) -> f64 {
        (k as f64 * 12.9898).sin() * 43758.5453 % 1.0
    }

    #[test]
    fn length_does_not_depend_on_the_grid() {
        for spacing in [0.5, 1.0] {
            let data: Vec<[f64; 3]> = (0..(100.0 / spacing) as usize)
                .map(|k| {
                    let p = helix(k as f64 * spacing);
                    std::array::from_fn(|d| p[d] + 0.4 * spacing * noise(3 * k + d))
                })
                .collect();
            let curve = smooth(&data, 0.5, 6.0);
            let length = *chord_lengths(&curve).last().unwrap();
            assert!((length / 100.0 - 1.0).abs() < 0.02, "{length} mm at {spacing} mm");
            let rms = (curve
                .iter()
                .map(|p| {
                    (0..20_000)
                        .map(|k| (position(p) - position(&helix(k as f64 * 0.005))).norm_squared())
                        .fold(f64::INFINITY, f64::min)
                })
                .sum::<f64>()
                / curve.len() as f64)
                .sqrt();
            assert!(rms < 0.25 * spacing, "{rms} mm at {spacing} mm");
        }
    }

    #[test]
    fn a_straight_line_stays_and_its_extra_value_too() {
        let data: Vec<[f64; 4]> = (0..30).map(|k| [0.3 * k as f64, 1.0, 2.0, 0.1 * k as f64]).collect();
        let curve = smooth(&data, 0.5, 8.0);
        assert!((chord_lengths(&curve).last().unwrap() - 8.7).abs() < 1e-6);
        for p in &curve {
            assert!((p[1] - 1.0).abs() < 1e-6 && (p[3] - p[0] / 3.0).abs() < 1e-6);
        }
    }

    #[test]
    fn the_banded_solver_solves() {
        let (d, f, s) = (vec![5.0, 6.0, 7.0, 6.0], vec![-2.0, -1.0, -2.0, 0.0], vec![0.5, 0.25, 0.0, 0.0]);
        let x = [1.0, -2.0, 3.0, 0.5];
        let mut right: Vec<[f64; 1]> = (0..4)
            .map(|k| {
                let mut sum = d[k] * x[k];
                if k + 1 < 4 {
                    sum += f[k] * x[k + 1];
                }
                if k + 2 < 4 {
                    sum += s[k] * x[k + 2];
                }
                if k >= 1 {
                    sum += f[k - 1] * x[k - 1];
                }
                if k >= 2 {
                    sum += s[k - 2] * x[k - 2];
                }
                [sum]
            })
            .collect();
        solve_banded(&mut d.clone(), &mut f.clone(), &mut s.clone(), &mut right);
        for k in 0..4 {
            assert!((right[k][0] - x[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn degenerate_input_is_harmless() {
        assert!(smooth::<3>(&[], 0.5, 6.0).is_empty());
        assert_eq!(smooth(&[[1.0, 2.0, 3.0]], 0.5, 6.0).len(), 1);
        assert_eq!(smooth(&[[1.0, 2.0, 3.0]; 4], 0.5, 6.0).len(), 1);
        assert_eq!(smooth(&[[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]], 0.5, 6.0).len(), 2);
    }
}
