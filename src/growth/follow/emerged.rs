//! When each point of a root was there first.

use super::interval::foot;
use crate::growth::overlap::places;
use crate::roots::TracedRoot;

/// Of each root of day `day` and each of its points the first of the `times` at which the root had come as far; `days` have the roots of
/// each day in one frame under their common numbers.
pub fn emerged(days: &[Vec<TracedRoot>], times: &[f64], day: usize) -> Vec<Vec<f64>> {
    days[day].iter().map(|root| of_root(days, times, day, root)).collect()
}

fn of_root(days: &[Vec<TracedRoot>], times: &[f64], day: usize, root: &TracedRoot) -> Vec<f64> {
    let along = places(&root.root);
    // How far the tip had come, by day; a later day that shows less takes nothing back.
    let reached = (0..day).filter_map(|d| {
        let earlier = days[d].iter().find(|r| r.root.id == root.root.id)?;
        Some((times[d], foot(places(&earlier.root).last()?, &along)))
    });
    let reached: Vec<(f64, f64)> = reached.collect();
    let mut arc_mm = 0.0;
    let points = &root.root.points_mm;
    (0..points.len())
        .map(|k| {
            if k > 0 {
                arc_mm += (0..3).map(|c| (points[k][c] - points[k - 1][c]).powi(2)).sum::<f64>().sqrt();
            }
            reached.iter().find(|(_, tip_mm)| arc_mm <= tip_mm + 1e-9).map_or(times[day], |(time, _)| *time)
        })
        .collect()
}
