//! Which roots a day misses, and the days with those that were found.

use super::{Recalled, Wanted};
use crate::growth::follow::{FollowParams, Growth};
use crate::growth::motion::Motion;
use crate::roots::TracedRoot;
use crate::roots::traits::topology::length_mm;

/// The roots that day `day` misses, in its own frame, parents first; `days` have the roots of each day in the frame of the first, under their
/// common numbers.
pub fn wanted(growth: &Growth, days: &[Vec<TracedRoot>], day: usize, first_from_day: &Motion) -> Vec<Wanted> {
    let of = |other: usize, id: i64| days[other].iter().find(|r| r.root.id == id);
    let mut all: Vec<Wanted> = growth
        .tracks
        .iter()
        .filter(|track| of(day, track.id).is_none())
        .filter_map(|track| {
            let later = (day + 1..days.len()).find_map(|d| Some((d, of(d, track.id)?)));
            let earlier = (0..day).rev().find_map(|d| Some((d, of(d, track.id)?)));
            let least_mm = earlier.map_or(0.0, |(_, root)| length_mm(&root.root));
            let (by, root) = later.or(earlier)?;
            let mut line = inverse(root, first_from_day);
            // On some day it may hang on none: the last one knows best.
            line.root.parent = track.parent;
            Some(Wanted { line, by, least_mm })
        })
        .collect();
    all.sort_by_key(|one| (one.line.root.order, one.line.root.id));
    all
}

fn inverse(root: &TracedRoot, first_from_day: &Motion) -> TracedRoot {
    TracedRoot { root: first_from_day.inverse().root(&root.root), ..root.clone() }
}

/// The roots over days with those that were found with another day's help; `days` get them too.
pub fn joined(
    growth: Growth,
    days: &mut [(f64, Vec<TracedRoot>)],
    recalled: &[Recalled],
    params: &FollowParams,
) -> Growth {
    let mut growth = growth;
    for one in recalled {
        let [day, _] = one.days;
        let Some(track) = growth.tracks.iter_mut().find(|t| t.id == one.root.root.id) else { continue };
        track.seen[day] = Some(days[day].1.len());
        days[day].1.push(one.root.clone());
    }
    growth.again(days, params)
}
