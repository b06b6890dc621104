//! Powell's direction-set method: a minimum of a function of several variables without its derivatives.
//! Paper 2.2.3; M. J. D. Powell, The Computer Journal 7 (1964) 155.
//!
//! A round minimises along each direction of a set in turn (Brent's parabolic line search). The whole step of the round
//! becomes a direction too where the function still falls beyond its end; it takes the place of the direction that
//! brought most, so that the set does not collapse. Rounds end when the value stands still to `tolerance` of
//! itself, i.e. with 1e-4 when its top four digits do. Values that are not finite count as infinitely high.

/// When to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Relative change of the value over a round that counts as standing still, 1e-12..0.1.
    pub tolerance: f64,
    /// Rounds at most.
    pub rounds: usize,
}

/// Where the search ended.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The variables.
    pub x: Vec<f64>,
    /// The function there.
    pub value: f64,
    /// Rounds taken.
    pub rounds: usize,
    /// Whether the value stood still before the rounds ran out.
    pub converged: bool,
}

/// Minimises `f` from `start`; `steps` are the sizes of the first trial step along each variable, not 0.
pub fn minimise(mut f: impl FnMut(&[f64]) -> f64, start: &[f64], steps: &[f64], stop: Stop) -> Minimum {
    let n = start.len();
    let mut f = |x: &[f64]| {
        let value = f(x);
        if value.is_finite() { value } else { f64::INFINITY }
    };
    let mut directions: Vec<Vec<f64>> =
        (0..n).map(|i| (0..n).map(|j| if i == j { steps[i] } else { 0.0 }).collect()).collect();
    let mut x = start.to_vec();
    let mut value = f(&x);
    for round in 1..=stop.rounds {
        let (from, before) = (x.clone(), value);
        let (mut most, mut best) = (0.0, 0);
        for (k, d) in directions.iter().enumerate() {
            let at = value;
            value = along(&mut f, &mut x, value, d, stop.tolerance);
            if at - value > most {
                (most, best) = (at - value, k);
            }
        }
        if before - value <= stop.tolerance * 0.5 * (before.abs() + value.abs()) + f64::MIN_POSITIVE {
            return Minimum { x, value, rounds: round, converged: true };
        }
        let whole: Vec<f64> = x.iter().zip(&from).map(|(a, b)| a - b).collect();
        let beyond: Vec<f64> = x.iter().zip(&whole).map(|(a, d)| a + d).collect();
        let there = f(&beyond);
        if there < before {
            let bend = 2.0 * (before - 2.0 * value + there) * (before - value - most).powi(2);
            if bend < most * (before - there).powi(2) {
                value = along(&mut f, &mut x, value, &whole, stop.tolerance);
                directions.remove(best);
                directions.push(whole);
            }
        }
    }
    Minimum { x, value, rounds: stop.rounds, converged: false }
}

/// Golden section: the part of an interval that a step without a parabola takes.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// Moves `x` to the minimum along `direction` and returns the value there, at most `value`.
fn along(f: &mut impl FnMut(&[f64]) -> f64, x: &mut [f64], value: f64, direction: &[f64], tolerance: f64) -> f64 {
    if direction.iter().all(|d| *d == 0.0) {
        return value;
    }
    let place = |t: f64| -> Vec<f64> { x.iter().zip(direction).map(|(a, d)| a + t * d).collect() };
    let mut g = |t: f64| f(&place(t));
    // Downhill by growing steps until the function rises again: a < b < c with g(b) the least.
    let (mut b, mut gb) = (0.0, value);
    let mut a;
    let mut c;
    let (right, left) = (g(1.0), g(-1.0));
    if right >= value && left >= value {
        (a, c) = (-1.0, 1.0);
    } else {
        let mut step = if right < left { 1.0 } else { -1.0 };
        a = 0.0;
        (b, gb) = (step, right.min(left));
        c = b;
        for _ in 0..60 {
            step *= 1.618_033_988_749_895;
            c = b + step;
            let gc = g(c);
            if gc >= gb {
                break;
            }
            (a, b, gb) = (b, c, gc);
        }
        if a > c {
            (a, c) = (c, a);
        }
    }
    // Brent: parabolas through the three least points, golden sections where those fail.
    let (mut w, mut gw, mut v, mut gv) = (b, gb, b, gb);
    let (mut step, mut earlier) = (0.0_f64, 0.0_f64);
    for _ in 0..60 {
        let close = tolerance * b.abs().max(1.0) * 0.1;
        let middle = 0.5 * (a + c);
        if (b - middle).abs() <= 2.0 * close - 0.5 * (c - a) {
            break;
        }
        let mut golden = true;
        if earlier.abs() > close {
            let r = (b - w) * (gb - gv);
            let q = (b - v) * (gb - gw);
            let mut p = (b - v) * q - (b - w) * r;
            let mut s = 2.0 * (q - r);
            if s > 0.0 {
                p = -p;
            }
            s = s.abs();
            if p.is_finite() && p.abs() < (0.5 * s * earlier).abs() && p > s * (a - b) && p < s * (c - b) {
                earlier = step;
                step = p / s;
                let t = b + step;
                if t - a < 2.0 * close || c - t < 2.0 * close {
                    step = close.copysign(middle - b);
                }
                golden = false;
            }
        }
        if golden {
            earlier = if b >= middle { a - b } else { c - b };
            step = GOLDEN * earlier;
        }
        let t = if step.abs() >= close { b + step } else { b + close.copysign(step) };
        let gt = g(t);
        if gt <= gb {
            if t >= b {
                a = b;
            } else {
                c = b;
            }
            (v, gv, w, gw, b, gb) = (w, gw, b, gb, t, gt);
        } else {
            if t < b {
                a = t;
            } else {
                c = t;
            }
            if gt <= gw || w == b {
                (v, gv, w, gw) = (w, gw, t, gt);
            } else if gt <= gv || v == b || v == w {
                (v, gv) = (t, gt);
            }
        }
    }
    if gb < value {
        let there = place(b);
        x.copy_from_slice(&there);
        gb
    } else {
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FINE: Stop = Stop { tolerance: 1e-12, rounds: 200 };

    #[test]
    fn a_bent_valley_is_followed_to_its_end() {
        let rosenbrock = |x: &[f64]| (1.0 - x[0]).powi(2) + 100.0 * (x[1] - x[0] * x[0]).powi(2);
        let found = minimise(rosenbrock, &[-1.2, 1.0], &[0.1, 0.1], FINE);
        assert!(found.converged && found.value < 1e-12, "{found:?}");
        assert!((found.x[0] - 1.0).abs() < 1e-5 && (found.x[1] - 1.0).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn a_function_that_is_nowhere_finite_returns_the_start() {
        let found = minimise(|_| f64::NAN, &[1.0, 2.0], &[1.0, 1.0], FINE);
        assert_eq!(found.x, [1.0, 2.0]);
    }

    proptest! {
        #[test]
        fn skew_bowls_are_solved(a in prop::collection::vec(-1.0..1.0_f64, 16), m in prop::collection::vec(-5.0..5.0_f64, 4)) {
            // f = |A (x - m)|² + |x - m|² has its one minimum at m.
            let f = |x: &[f64]| {
                let d: Vec<f64> = x.iter().zip(&m).map(|(x, m)| x - m).collect();
                let rows = a.chunks(4).map(|r| r.iter().zip(&d).map(|(a, d)| a * d).sum::<f64>().powi(2)).sum::<f64>();
                rows + d.iter().map(|d| d * d).sum::<f64>()
            };
            let found = minimise(f, &[0.0; 4], &[0.5; 4], FINE);
            for (x, m) in found.x.iter().zip(&m) {
                prop_assert!((x - m).abs() < 1e-4, "{found:?} {m}");
            }
        }
    }
}
