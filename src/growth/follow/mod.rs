//! Roots over days: which root of a later day is which of an earlier one.
//!
//! All days stand in one frame. A root that grows at its tip lies on its later self: of every earlier root and every later one, the
//! length of the earlier that lies within [`FollowParams::within_mm`] of the later and runs with it. Pairs are taken from
//! the most length on, weighed by the share of the earlier root that it is; each root once. What is left of the later day is new, what
//! is left of the earlier vanished: hidden or dead, it is looked for again on every later day where it was seen last.

mod emerged;
mod interval;
mod later;
mod rehang;
#[cfg(test)]
mod tests;

pub use emerged::emerged;
pub use interval::{Interval, State};
pub use rehang::Rehung;

use crate::error::{Error, Result};
use crate::growth::overlap::{Overlap, overlaps};
use crate::roots::{Root, TracedRoot};
use serde::{Deserialize, Serialize};

/// How roots are followed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FollowParams {
    /// How far a root may lie from its later self, mm, 0.1 to 20: sway, and what tracing and registration are off.
    pub within_mm: f64,
    /// Least share of a root that lies on its later self, 0 to 1.
    pub overlap: f64,
}

impl Default for FollowParams {
    fn default() -> Self {
        Self { within_mm: 1.5, overlap: 0.5 }
    }
}

impl FollowParams {
    /// Refuses what finds nothing or anything.
    ///
    /// # Errors
    /// Names the number.
    pub fn check(&self) -> Result<()> {
        for (name, value, least, most) in
            [("within_mm", self.within_mm, 0.1, 20.0), ("overlap", self.overlap, 0.05, 1.0)]
        {
            if !(least..=most).contains(&value) {
                return Err(Error::usage(format!("follow.{name} is {value}")).help(format!("give {least} to {most}")));
            }
        }
        Ok(())
    }
}

/// One root over days.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// Its number on all days, from 0.
    pub id: i64,
    /// The number of the root that it springs from; -1 for none.
    pub parent: i64,
    /// Branching order when it was seen last.
    pub order: u32,
    /// Per day the place of its root in the day's list, where it was seen.
    pub seen: Vec<Option<usize>>,
}

/// The roots of a plant over days.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Growth {
    /// All roots that were ever seen, in the order of their first day.
    pub tracks: Vec<Track>,
    /// What each did between the days it was seen, and where it came or went.
    pub intervals: Vec<Interval>,
    /// Where roots were told apart otherwise than on their own day, because other days know better.
    pub rehung: Vec<Rehung>,
}

impl Growth {
    /// Traits of the growth from the day before to `day`, over `since` days: the mean elongation rate of all roots that were followed
    /// over this interval and of those of each order, and how many roots appeared and vanished.
    pub fn traits(&self, day: usize, since: f64) -> Vec<(String, f64)> {
        let of_day = || self.intervals.iter().filter(|i| i.days == [day - 1, day]);
        let order = |root: i64| self.tracks.iter().find(|t| t.id == root).map_or(0, |t| t.order);
        let mean = |wanted: &dyn Fn(u32) -> bool| {
            let of = of_day().filter(|i| wanted(order(i.root)));
            let rates: Vec<f64> = of.filter_map(|i| Some(i.elongation_mm? / since)).collect();
            rates.iter().sum::<f64>() / rates.len() as f64
        };
        let count = |state: State| of_day().filter(|i| i.state == state).count() as f64;
        let mut traits = vec![("elongation_mm_per_day".to_owned(), mean(&|_| true))];
        traits.extend((0..=2).map(|n| (format!("elongation_order_{n}_mm_per_day"), mean(&|order| order == n))));
        traits.push(("roots_appeared".to_owned(), count(State::Appeared)));
        traits.push(("roots_vanished".to_owned(), count(State::Vanished)));
        traits
    }

    /// The same roots, and what they did between days, told anew from the `days` they are seen on.
    #[must_use]
    pub fn again(self, days: &[(f64, Vec<TracedRoot>)], params: &FollowParams) -> Self {
        let intervals = interval::all(&self.tracks, &plain(days), params);
        Self { intervals, ..self }
    }

    /// The roots of a day under their common numbers; a parent that is not seen that day counts as none.
    pub fn day(&self, day: usize, roots: &[TracedRoot]) -> Vec<TracedRoot> {
        let number = |place: usize| self.tracks.iter().find(|t| t.seen[day] == Some(place)).map(|t| t.id);
        let numbers: Vec<Option<i64>> = (0..roots.len()).map(number).collect();
        let mut named = roots.to_vec();
        for (k, root) in named.iter_mut().enumerate() {
            let parent = roots.iter().position(|r| r.root.id == roots[k].root.parent);
            root.root.parent = parent.and_then(|p| numbers[p]).unwrap_or(-1);
            root.root.id = numbers[k].unwrap_or(-1);
        }
        named
    }
}

/// A root that is looked for: its track, and the day and place where it was seen last.
struct Last {
    track: usize,
    day: usize,
    place: usize,
}

/// Follows the roots of `days`, each the roots of one day in the common frame with its time in days. Days help each other tell roots
/// apart: forks are settled by earlier days (`rehang`), then every day is read by the next (`later`).
pub fn follow(days: &mut [(f64, Vec<TracedRoot>)], params: &FollowParams) -> Growth {
    let mut all: Vec<Vec<TracedRoot>> = days.iter_mut().map(|(_, roots)| std::mem::take(roots)).collect();
    let mut rehung = rehang::rehang(&mut all, params.within_mm);
    for day in (1..all.len()).rev() {
        let (first, rest) = all.split_at_mut(day);
        rehung.extend(later::read_by(day - 1, &mut first[day - 1], &rest[0], params.within_mm));
    }
    days.iter_mut().zip(all).for_each(|((_, roots), new)| *roots = new);
    Growth { rehung, ..tracked(&plain(days), params) }
}

fn plain(days: &[(f64, Vec<TracedRoot>)]) -> Vec<(f64, Vec<Root>)> {
    days.iter().map(|(time, roots)| (*time, roots.iter().map(|r| r.root.clone()).collect())).collect()
}

/// Follows roots as they are.
fn tracked(days: &[(f64, Vec<Root>)], params: &FollowParams) -> Growth {
    let mut growth = Growth::default();
    for (day, (_, roots)) in days.iter().enumerate() {
        let last: Vec<Last> = growth.tracks.iter().enumerate().filter_map(|(n, t)| last_of(n, t)).collect();
        let earlier: Vec<&Root> = last.iter().map(|l| &days[l.day].1[l.place]).collect();
        let pairs = matched(&earlier, roots, params);
        let mut track_of = vec![None; roots.len()];
        for track in &mut growth.tracks {
            track.seen.push(None);
        }
        for pair in &pairs {
            let track = last[pair.earlier].track;
            track_of[pair.later] = Some(track);
            growth.tracks[track].seen[day] = Some(pair.later);
        }
        for place in 0..roots.len() {
            if track_of[place].is_none() {
                track_of[place] = Some(growth.tracks.len());
                let mut seen = vec![None; day + 1];
                seen[day] = Some(place);
                let id = growth.tracks.len() as i64;
                growth.tracks.push(Track { id, parent: -1, order: roots[place].order, seen });
            }
        }
        for (place, track) in track_of.iter().enumerate() {
            let parent = roots.iter().position(|r| r.id == roots[place].parent).and_then(|p| track_of[p]);
            if let Some(track) = track {
                growth.tracks[*track].parent = parent.map_or(-1, |p| p as i64);
                growth.tracks[*track].order = roots[place].order;
            }
        }
    }
    growth.intervals = interval::all(&growth.tracks, days, params);
    growth
}

fn last_of(n: usize, track: &Track) -> Option<Last> {
    let day = track.seen.iter().rposition(Option::is_some)?;
    Some(Last { track: n, day, place: track.seen[day]? })
}

/// Pairs of an earlier and a later root that are one, each root in one pair at most.
fn matched(earlier: &[&Root], later: &[Root], params: &FollowParams) -> Vec<Overlap> {
    let mut all = overlaps(earlier, &later.iter().collect::<Vec<_>>(), params.within_mm, false);
    all.retain(|pair| pair.share >= params.overlap);
    all.sort_by(|a, b| b.weight().total_cmp(&a.weight()).then((a.earlier, a.later).cmp(&(b.earlier, b.later))));
    let (mut of_earlier, mut of_later) = (vec![false; earlier.len()], vec![false; later.len()]);
    all.retain(|pair| {
        let free = !of_earlier[pair.earlier] && !of_later[pair.later];
        if free {
            (of_earlier[pair.earlier], of_later[pair.later]) = (true, true);
        }
        free
    });
    all
}
