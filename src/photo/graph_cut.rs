//! The region of an object in a photograph, by graph cut with colour models.  Paper 2.2.3; C. Rother, V. Kolmogorov,
//! A. Blake, ACM Trans. Graph. 23 (2004) 309.
//!
//! Some pixels are known to show the object or what is around it; the others are decided. Both sides have a mixture of
//! `components` normal distributions of colour. In turns the mixtures are learnt from the pixels of their side, and the
//! pixels are divided by the least cut of the energy `Σ D(z) + γ Σ exp(-β |z - z'|²) / |x - x'|`: D is minus the
//! logarithm of the mixture's density, the second sum runs over neighbours (8) on different sides, and β is
//! 1 / 2⟨|z - z'|²⟩. Turns end when no pixel changes sides. Colours are RGB, 0..255 as encoded.

use crate::error::{Error, Result};
use crate::math::maxflow::Graph;
use nalgebra::{Matrix3, Vector3};
use ndarray::{Array2, ArrayView2, ArrayView3};
use serde::{Deserialize, Serialize};

/// What is known of a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// It shows what is around the object.
    Outside,
    /// It shows the object.
    Inside,
    /// Nothing.
    Nothing,
}

/// How the region is cut out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CutParams {
    /// Normal distributions per colour model, 1..20.
    pub components: usize,
    /// Weight γ of the border's length against colour, 0..1000.
    pub gamma: f64,
    /// Turns of learning and cutting at most, 1..50.
    pub turns: usize,
}

impl Default for CutParams {
    /// The values of the method's authors.
    fn default() -> Self {
        Self { components: 5, gamma: 50.0, turns: 10 }
    }
}

/// Whether each pixel shows the object; pixels of which something is known keep that.
///
/// # Errors
/// Where the sizes differ, or nothing is known to lie inside, or outside.
pub fn cut(picture: ArrayView3<u8>, known: ArrayView2<Known>, params: &CutParams) -> Result<Array2<bool>> {
    let (h, w) = known.dim();
    if picture.dim() != (h, w, 3) {
        return Err(Error::failed(format!("a picture of {:?} does not go with a map of {:?}", picture.dim(), (h, w))));
    }
    for (side, name) in [(Known::Inside, "inside"), (Known::Outside, "outside")] {
        if !known.iter().any(|k| *k == side) {
            return Err(Error::failed(format!("no pixel is known to lie {name} the object")));
        }
    }
    let colours: Vec<Vector3<f64>> =
        picture.rows().into_iter().map(|p| Vector3::new(f64::from(p[0]), f64::from(p[1]), f64::from(p[2]))).collect();
    let colours = Array2::from_shape_vec((h, w), colours).expect("one colour a pixel");
    // Unknown pixels first count to neither side.
    let mut inside = known.mapv(|k| k == Known::Inside);
    let mut first = true;
    let beta = contrast(&colours);
    for _ in 0..params.turns {
        let of = |side: bool| -> Vec<Vector3<f64>> {
            let counts = |at: (usize, usize)| inside[at] == side && !(first && known[at] == Known::Nothing);
            colours.indexed_iter().filter(|(at, _)| counts(*at)).map(|(_, c)| *c).collect()
        };
        let (object, around) = (Mixture::of(of(true), params.components), Mixture::of(of(false), params.components));
        let next = least_cut(&colours, known, &object, &around, beta, params.gamma);
        let still = next == inside;
        inside = next;
        if still && !first {
            break;
        }
        first = false;
    }
    Ok(inside)
}

/// The four neighbours after a pixel, (down, right), with one over their distance.
const AFTER: [(usize, isize, f64); 4] =
    [(0, 1, 1.0), (1, 0, 1.0), (1, 1, std::f64::consts::FRAC_1_SQRT_2), (1, -1, std::f64::consts::FRAC_1_SQRT_2)];

/// Calls `take` for every pair of neighbours.
fn pairs(h: usize, w: usize, mut take: impl FnMut((usize, usize), (usize, usize), f64)) {
    for y in 0..h {
        for x in 0..w {
            for (down, right, nearness) in AFTER {
                let (v, u) = (y + down, x.wrapping_add_signed(right));
                if v < h && u < w {
                    take((y, x), (v, u), nearness);
                }
            }
        }
    }
}

/// β: one over twice the mean squared difference of neighbours.
fn contrast(colours: &Array2<Vector3<f64>>) -> f64 {
    let (h, w) = colours.dim();
    let (mut sum, mut count) = (0.0, 0_usize);
    pairs(h, w, |a, b, _| {
        sum += (colours[a] - colours[b]).norm_squared();
        count += 1;
    });
    if sum > 0.0 { count as f64 / (2.0 * sum) } else { 0.0 }
}

fn least_cut(
    colours: &Array2<Vector3<f64>>,
    known: ArrayView2<Known>,
    object: &Mixture,
    around: &Mixture,
    beta: f64,
    gamma: f64,
) -> Array2<bool> {
    let (h, w) = colours.dim();
    let mut number = Array2::from_elem((h, w), usize::MAX);
    let open: Vec<(usize, usize)> =
        known.indexed_iter().filter(|(_, k)| **k == Known::Nothing).map(|(at, _)| at).collect();
    let mut graph = Graph::new(open.len());
    for (n, &at) in open.iter().enumerate() {
        number[at] = n;
        // On the source's side, the object's, a pixel pays its cost as object: the arc to the sink is cut.
        graph.terminals(n, around.cost(&colours[at]), object.cost(&colours[at]));
    }
    pairs(h, w, |a, b, nearness| {
        let (m, n) = (number[a], number[b]);
        if m == usize::MAX && n == usize::MAX {
            return;
        }
        let weight = gamma * nearness * (-beta * (colours[a] - colours[b]).norm_squared()).exp();
        match (m, n) {
            (usize::MAX, n) => tie(&mut graph, n, known[a], weight),
            (m, usize::MAX) => tie(&mut graph, m, known[b], weight),
            (m, n) => graph.arc(m, n, weight, weight),
        }
    });
    let (_, sides) = graph.solve();
    let mut inside = known.mapv(|k| k == Known::Inside);
    for (&at, side) in open.iter().zip(sides) {
        inside[at] = side;
    }
    inside
}

/// A neighbour whose side is known.
fn tie(graph: &mut Graph, node: usize, known: Known, weight: f64) {
    if known == Known::Inside {
        graph.terminals(node, weight, 0.0);
    } else {
        graph.terminals(node, 0.0, weight);
    }
}

/// A normal distribution of colour.
struct Normal {
    mean: Vector3<f64>,
    precision: Matrix3<f64>,
    /// ln of the share less half the ln of the determinant.
    level: f64,
}

/// Several of them.
struct Mixture(Vec<Normal>);

/// Variance added to every distribution: rounding to whole levels, and a little noise.
const FLOOR: f64 = 1.0;

impl Mixture {
    /// Divides the colours by splitting, again and again, the group of the largest variance across its longest axis, and
    /// then by the nearest distribution.
    fn of(colours: Vec<Vector3<f64>>, components: usize) -> Self {
        let total = colours.len() as f64;
        let mut groups = vec![colours];
        while groups.len() < components {
            let longest = |g: &Vec<Vector3<f64>>| {
                let eigen = moments(g).1.symmetric_eigen();
                let k = eigen.eigenvalues.imax();
                (eigen.eigenvalues[k] * g.len() as f64, eigen.eigenvectors.column(k).into_owned())
            };
            let spreads: Vec<_> = groups.iter().map(longest).collect();
            let Some(k) = (0..groups.len()).max_by(|&i, &j| spreads[i].0.total_cmp(&spreads[j].0)) else { break };
            let axis = spreads[k].1;
            let mean = moments(&groups[k]).0;
            let (above, below): (Vec<_>, Vec<_>) =
                std::mem::take(&mut groups[k]).into_iter().partition(|c| axis.dot(&(c - mean)) > 0.0);
            if above.is_empty() || below.is_empty() {
                groups[k] = [above, below].concat();
                break;
            }
            groups[k] = above;
            groups.push(below);
        }
        let fit = |groups: &[Vec<Vector3<f64>>]| Self(groups.iter().map(|g| Normal::of(g, total)).collect());
        let mut mixture = fit(&groups);
        let mut next = vec![Vec::new(); mixture.0.len()];
        for c in groups.into_iter().flatten() {
            next[mixture.nearest(&c).0].push(c);
        }
        next.retain(|g| !g.is_empty());
        mixture = fit(&next);
        mixture
    }

    /// The likeliest distribution with its -ln of share times density, constants left out.
    fn nearest(&self, colour: &Vector3<f64>) -> (usize, f64) {
        let cost = |n: &Normal| {
            let d = colour - n.mean;
            0.5 * d.dot(&(n.precision * d)) - n.level
        };
        self.0.iter().map(cost).enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0))
    }

    /// -ln of the density, moved up by a constant so that it is never below 0.
    fn cost(&self, colour: &Vector3<f64>) -> f64 {
        // No distribution is narrower than the floor, so that no level is above 0.
        self.nearest(colour).1.max(0.0)
    }
}

impl Normal {
    fn of(colours: &[Vector3<f64>], total: f64) -> Self {
        let (mean, covariance) = moments(colours);
        let covariance = covariance + Matrix3::identity() * FLOOR;
        let precision = covariance.try_inverse().unwrap_or_else(|| Matrix3::identity() / FLOOR);
        let level = (colours.len() as f64 / total).ln() - 0.5 * covariance.determinant().max(f64::MIN_POSITIVE).ln();
        Self { mean, precision, level }
    }
}

/// Mean and covariance.
fn moments(colours: &[Vector3<f64>]) -> (Vector3<f64>, Matrix3<f64>) {
    let n = colours.len().max(1) as f64;
    let mean = colours.iter().sum::<Vector3<f64>>() / n;
    let covariance = colours.iter().map(|c| (c - mean) * (c - mean).transpose()).sum::<Matrix3<f64>>() / n;
    (mean, covariance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;

    #[test]
    fn a_speckled_disc_is_cut_along_its_rim() {
        let disc = |y: usize, x: usize| (y as f64 - 30.0).hypot(x as f64 - 30.0) < 20.3;
        let noise = |y: usize, x: usize, c: usize| (y * 7919 + x * 104_729 + c * 31) % 23;
        let picture = Array3::from_shape_fn((60, 60, 3), |(y, x, c)| {
            // The object is speckled in two colours, the room is a third one.
            let base = if !disc(y, x) {
                [90, 95, 100]
            } else if (y / 3 + x / 3) % 2 == 0 {
                [200, 190, 180]
            } else {
                [40, 35, 60]
            };
            (base[c] + noise(y, x, c)) as u8
        });
        let known = Array2::from_shape_fn((60, 60), |(y, x)| match (y as f64 - 30.0).hypot(x as f64 - 30.0) {
            d if d < 14.0 => Known::Inside,
            d if d > 26.0 => Known::Outside,
            _ => Known::Nothing,
        });
        let inside = cut(picture.view(), known.view(), &CutParams::default()).unwrap();
        let wrong = inside.indexed_iter().filter(|((y, x), i)| **i != disc(*y, *x)).count();
        assert!(wrong <= 12, "{wrong} pixels are on the wrong side");
    }

    #[test]
    fn one_colour_and_unknown_sides_are_no_trouble() {
        let picture = Array3::<u8>::zeros((8, 9, 3));
        let mut known = Array2::from_elem((8, 9), Known::Nothing);
        assert!(cut(picture.view(), known.view(), &CutParams::default()).is_err());
        known[(0, 0)] = Known::Inside;
        known[(7, 8)] = Known::Outside;
        let inside = cut(picture.view(), known.view(), &CutParams::default()).unwrap();
        assert!(inside[(0, 0)] && !inside[(7, 8)]);
    }
}
