//! The axes of a figure.

use crate::report::page::html::number;
use std::fmt::Write;

/// A value axis from round number to round number.
pub(super) struct Axis {
    low: f64,
    high: f64,
    step: f64,
}

impl Axis {
    /// An axis that holds the values, and zero where it is near.
    pub(super) fn of(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let low = if low > 0.0 && low < 0.5 * high { 0.0 } else { low };
        let span = if high > low { high - low } else { high.abs().max(1.0) };
        let raw = span / 4.0;
        let power = 10f64.powf(raw.log10().floor());
        let step = [1.0, 2.0, 2.5, 5.0, 10.0].map(|f| f * power).into_iter().find(|s| *s >= raw).unwrap_or(raw);
        Self { low: (low / step).floor() * step, high: ((low + span) / step).ceil() * step, step }
    }

    /// Share of the way from low to high.
    pub(super) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    pub(super) fn ticks(&self) -> impl Iterator<Item = f64> {
        let count = ((self.high - self.low) / self.step).round() as usize;
        let (low, step) = (self.low, self.step);
        (0..=count).map(move |k| low + step * k as f64)
    }
}

/// The lines of the values from `left` to `right`, each with its number before it; `y` is where a value stands.
pub(super) fn lines(axis: &Axis, left: f64, right: f64, y: impl Fn(f64) -> f64, t: &mut String) {
    for tick in axis.ticks() {
        let _ = write!(
            t,
            "<path class=\"axis\" d=\"M{left} {0:.1}H{right}\"/><text x=\"{1:.1}\" y=\"{2:.1}\" text-anchor=\"end\">{3}</text>",
            y(tick),
            left - 4.0,
            y(tick) + 4.0,
            number(tick)
        );
    }
}

/// The numbers below a figure, at height `y`; `x` is where a value stands.
pub(super) fn numbers(axis: &Axis, x: impl Fn(f64) -> f64, y: f64, t: &mut String) {
    for tick in axis.ticks() {
        let _ = write!(t, "<text x=\"{:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>", x(tick), number(tick));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_go_from_round_number_to_round_number() {
        let axis = Axis::of([812.0, 1390.0].into_iter());
        assert_eq!((axis.low, axis.high, axis.step), (800.0, 1400.0, 200.0));
        let axis = Axis::of([3.0, 97.0].into_iter());
        assert_eq!(axis.ticks().collect::<Vec<_>>(), [0.0, 25.0, 50.0, 75.0, 100.0]);
        let axis = Axis::of([5.0].into_iter());
        assert!(axis.share(5.0) >= 0.0 && axis.share(5.0) <= 1.0);
    }
}
