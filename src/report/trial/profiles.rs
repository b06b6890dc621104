//! Where the roots of each group lie: root length by depth, mean and standard deviation over the plants of the last date.

use super::axes::{Axis, lines, numbers};
use super::{COLOURS, Page, plants};
use crate::report::page::html::escape;
use std::fmt::Write;

const WIDTH: f64 = 520.0;
const HEIGHT: f64 = 340.0;
const LEFT: f64 = 52.0;
const TOP: f64 = 40.0;
const BOTTOM: f64 = 30.0;

/// Middle of a layer, mean and standard deviation of the length in it.
type Row = [f64; 3];

/// The profile of several plants; where one ends before the others it has no roots.
fn mean(profiles: &[&Vec<[f64; 3]>]) -> Vec<Row> {
    let longest = profiles.iter().max_by_key(|p| p.len()).map(|p| p.as_slice()).unwrap_or_default();
    let n = profiles.len() as f64;
    let row = |k: usize| {
        let values = profiles.iter().map(|p| p.get(k).map_or(0.0, |layer| layer[2]));
        let mean = values.clone().sum::<f64>() / n;
        let sd = (values.map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
        [0.5 * (longest[k][0] + longest[k][1]), mean, sd]
    };
    (0..longest.len()).map(row).collect()
}

/// The figure of a group column.
pub(super) fn panel(page: &Page<'_>, column: usize, groups: &[&str], t: &mut String) {
    let Some(date) = page.dates().pop() else { return };
    let of_group = |group: &&str| {
        let of = page.captures.iter().filter(|c| c.date == date && c.groups[column] == *group);
        let profiles: Vec<_> = of.filter_map(|c| Some(&c.known.as_ref().ok()?.profile)).collect();
        (profiles.len(), mean(&profiles))
    };
    let all: Vec<(usize, Vec<Row>)> = groups.iter().map(of_group).collect();
    let rows = || all.iter().flat_map(|(_, rows)| rows);
    if rows().next().is_none() {
        return;
    }
    let lengths = Axis::of(rows().map(|r| r[1] + r[2]).chain([0.0]));
    let depths = Axis::of(rows().map(|r| r[0]).chain([0.0]));
    let x = |length: f64| LEFT + lengths.share(length.max(0.0)) * (WIDTH - LEFT - 12.0);
    let y = |depth: f64| TOP + depths.share(depth) * (HEIGHT - TOP - BOTTOM);
    let title = format!("Root length by depth{}", if date.is_empty() { String::new() } else { format!(", {date}") });
    let title = escape(&title);
    let _ = write!(
        t,
        "<figure class=\"profile\"><svg class=\"chart\" style=\"max-width:40rem\" role=\"img\" aria-label=\"{title}\" \
         viewBox=\"0 0 {WIDTH} {HEIGHT}\"><text class=\"title\" x=\"8\" y=\"17\">{title}</text>\
         <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">mm of root per layer</text><text x=\"8\" y=\"{:.1}\">depth, mm</text>",
        WIDTH - 12.0,
        HEIGHT - 4.0,
        TOP - 6.0
    );
    lines(&depths, LEFT, WIDTH, y, t);
    numbers(&lengths, x, HEIGHT - 16.0, t);
    for (g, ((count, rows), group)) in all.iter().zip(groups).enumerate().filter(|(_, ((n, _), _))| *n > 0) {
        let colour = COLOURS[g % COLOURS.len()];
        let line = |of: &dyn Fn(&Row) -> f64| -> Vec<String> {
            rows.iter().map(|r| format!("{:.1} {:.1}", x(of(r)), y(r[0]))).collect()
        };
        let (low, mut high) = (line(&|r| r[1] - r[2]), line(&|r| r[1] + r[2]));
        high.reverse();
        if *count > 1 {
            let _ = write!(
                t,
                "<path d=\"M{}L{}Z\" fill=\"{colour}\" fill-opacity=\".14\"/>",
                low.join("L"),
                high.join("L")
            );
        }
        let _ = write!(
            t,
            "<path d=\"M{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/><circle cx=\"{:.1}\" cy=\"26\" r=\"4\" fill=\"{colour}\"/>\
             <text x=\"{:.1}\" y=\"30\">{}, {}</text>",
            line(&|r| r[1]).join("L"),
            150.0 + 120.0 * g as f64,
            158.0 + 120.0 * g as f64,
            escape(group),
            plants(*count)
        );
    }
    t.push_str("</svg><figcaption>Lines are means, bands one standard deviation.</figcaption></figure>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shallow_plant_has_no_roots_below() {
        let (a, b) = (vec![[0.0, 10.0, 4.0], [10.0, 20.0, 6.0]], vec![[0.0, 10.0, 8.0]]);
        let rows = mean(&[&a, &b]);
        assert_eq!((rows[0][0], rows[0][1], rows[1][1]), (5.0, 6.0, 3.0));
        assert!((rows[1][2] - 18f64.sqrt()).abs() < 1e-12);
        assert!(mean(&[]).is_empty());
    }
}
