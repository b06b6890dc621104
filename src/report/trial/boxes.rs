//! One trait of all plants: points and boxes, groups side by side on each date.

use super::axes::{Axis, lines};
use super::{COLOURS, Page, label};
use crate::report::page::html::{escape, number};
use std::fmt::Write;

const WIDTH: f64 = 360.0;
const HEIGHT: f64 = 240.0;
const LEFT: f64 = 46.0;
const TOP: f64 = 28.0;
const BOTTOM: f64 = 44.0;

/// Quantile of sorted values by linear interpolation.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let k = at as usize;
    sorted[k] + (at - k as f64) * (sorted[(k + 1).min(sorted.len() - 1)] - sorted[k])
}

/// The panel of a trait; nothing where no plant has it.
pub(super) fn panel(page: &Page<'_>, column: usize, groups: &[&str], name: &str, t: &mut String) {
    let known = || page.captures.iter().filter_map(|c| Some((c, c.known.as_ref().ok()?.value(name)?)));
    if known().next().is_none() {
        return;
    }
    let dates: Vec<&str> = page.dates().into_iter().filter(|d| known().any(|(c, _)| c.date == *d)).collect();
    let axis = Axis::of(known().map(|(_, value)| value));
    let y = |value: f64| HEIGHT - BOTTOM - axis.share(value) * (HEIGHT - TOP - BOTTOM);
    let of_date = (WIDTH - LEFT - 8.0) / dates.len() as f64;
    let of_group = (of_date * 0.84 / groups.len() as f64).min(60.0);
    let title = label(name);
    let _ = write!(
        t,
        "<figure><svg class=\"chart\" role=\"img\" aria-label=\"{title}\" viewBox=\"0 0 {WIDTH} {HEIGHT}\">\
         <text class=\"title\" x=\"8\" y=\"17\">{title}</text>"
    );
    lines(&axis, LEFT, WIDTH, y, t);
    for (d, date) in dates.iter().enumerate() {
        let middle = LEFT + of_date * (d as f64 + 0.5);
        let _ = write!(
            t,
            "<text x=\"{middle:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
            HEIGHT - 26.0,
            escape(date)
        );
        for (g, group) in groups.iter().enumerate() {
            let x = middle + of_group * (g as f64 + 0.5 - groups.len() as f64 / 2.0);
            let colour = COLOURS[g % COLOURS.len()];
            let of = || known().filter(|(c, _)| c.date == *date && c.groups[column] == *group);
            let mut values: Vec<f64> = of().map(|(_, value)| value).collect();
            values.sort_by(f64::total_cmp);
            if values.len() > 2 {
                let [low, middle, high] = [0.25, 0.5, 0.75].map(|s| y(quantile(&values, s)));
                let half = 0.36 * of_group;
                let _ = write!(
                    t,
                    "<rect x=\"{:.1}\" y=\"{high:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{colour}\" fill-opacity=\".16\" \
                     stroke=\"{colour}\"/><path d=\"M{:.1} {middle:.1}h{:.1}\" stroke=\"{colour}\" stroke-width=\"2\"/>",
                    x - half,
                    2.0 * half,
                    low - high,
                    x - half,
                    2.0 * half
                );
            }
            for (k, (c, value)) in of().enumerate() {
                // Beside each other in turn, so that equal values are told apart.
                let beside = x + of_group * 0.09 * ((k % 5) as f64 - 2.0);
                let _ = write!(
                    t,
                    "<a href=\"{}\"><circle cx=\"{beside:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"{colour}\"><title>{}, {}: {}</title></circle></a>",
                    escape(&c.link),
                    y(value),
                    escape(&c.title()),
                    escape(group),
                    number(value)
                );
            }
        }
    }
    let across = (WIDTH - 16.0) / groups.len() as f64;
    for (g, group) in groups.iter().enumerate() {
        let x = 8.0 + across * g as f64;
        let _ = write!(
            t,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"{}\"/><text x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            x + 4.0,
            HEIGHT - 10.0,
            COLOURS[g % COLOURS.len()],
            x + 12.0,
            HEIGHT - 6.0,
            escape(group)
        );
    }
    t.push_str("</svg></figure>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_lie_between_values() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
    }
}
